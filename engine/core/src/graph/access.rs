//! The accesses that uses of resources come down to. Nobody else types stages, masks and layouts.
//!
//! Layouts are the generic ones of Vulkan 1.3: `ATTACHMENT_OPTIMAL` and `READ_ONLY_OPTIMAL` fit colour, depth and
//! stencil alike, so a depth image that is tested and sampled in one pass needs no other layout. A buffer's layout is
//! not looked at.

use ash::vk::{self, AccessFlags2 as Mask, ImageLayout as Layout, PipelineStageFlags2 as Stages};

use super::description::{Access, Shape};

/// Stages that run the depth and stencil tests.
const FRAGMENT_TESTS: Stages =
    Stages::from_raw(Stages::EARLY_FRAGMENT_TESTS.as_raw() | Stages::LATE_FRAGMENT_TESTS.as_raw());

/// Every bit of an access mask that writes.
const WRITES: Mask = Mask::from_raw(
    Mask::SHADER_WRITE.as_raw()
        | Mask::SHADER_STORAGE_WRITE.as_raw()
        | Mask::COLOR_ATTACHMENT_WRITE.as_raw()
        | Mask::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw()
        | Mask::TRANSFER_WRITE.as_raw()
        | Mask::HOST_WRITE.as_raw()
        | Mask::MEMORY_WRITE.as_raw(),
);

impl Access {
    /// Nothing: no stage, no access, no layout. An imported buffer in this state is idle and visible to everybody, an
    /// imported image holds nothing.
    pub const NONE: Access = Access { stages: Stages::NONE, mask: Mask::NONE, layout: Layout::UNDEFINED };

    const fn new(stages: Stages, mask: Mask, layout: Layout) -> Self {
        Self { stages, mask, layout }
    }

    /// A colour attachment that is written. `load`: its earlier contents are loaded or blended with.
    pub const fn color_attachment(load: bool) -> Self {
        let read = if load { Mask::COLOR_ATTACHMENT_READ.as_raw() } else { 0 };
        let mask = Mask::from_raw(Mask::COLOR_ATTACHMENT_WRITE.as_raw() | read);
        Self::new(Stages::COLOR_ATTACHMENT_OUTPUT, mask, Layout::ATTACHMENT_OPTIMAL)
    }

    /// A colour attachment that fragments read and write in primitive order.
    pub const fn ordered_attachment() -> Self {
        let stages = Stages::COLOR_ATTACHMENT_OUTPUT.as_raw() | Stages::FRAGMENT_SHADER.as_raw();
        let mask = Mask::COLOR_ATTACHMENT_READ.as_raw()
            | Mask::COLOR_ATTACHMENT_WRITE.as_raw()
            | Mask::INPUT_ATTACHMENT_READ.as_raw();
        Self::new(Stages::from_raw(stages), Mask::from_raw(mask), Layout::GENERAL)
    }

    /// A depth or stencil attachment that is tested and written.
    pub const fn depth_attachment_write() -> Self {
        let mask = Mask::from_raw(
            Mask::DEPTH_STENCIL_ATTACHMENT_READ.as_raw() | Mask::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw(),
        );
        Self::new(FRAGMENT_TESTS, mask, Layout::ATTACHMENT_OPTIMAL)
    }

    /// A depth or stencil attachment that is tested and left as it is.
    pub const fn depth_attachment_read() -> Self {
        Self::new(FRAGMENT_TESTS, Mask::DEPTH_STENCIL_ATTACHMENT_READ, Layout::READ_ONLY_OPTIMAL)
    }

    /// An attachment that multisampled colour is resolved to.
    pub const fn resolve_attachment() -> Self {
        Self::new(Stages::COLOR_ATTACHMENT_OUTPUT, Mask::COLOR_ATTACHMENT_WRITE, Layout::ATTACHMENT_OPTIMAL)
    }

    /// A sampled image, with or without its sampler, seen by these shader stages.
    pub const fn sampled(stages: Stages) -> Self {
        Self::new(stages, Mask::SHADER_SAMPLED_READ, Layout::READ_ONLY_OPTIMAL)
    }

    /// A storage image that these shader stages load from.
    pub const fn storage_image_read(stages: Stages) -> Self {
        Self::new(stages, Mask::SHADER_STORAGE_READ, Layout::GENERAL)
    }

    /// A storage image that these shader stages store to.
    pub const fn storage_image_write(stages: Stages) -> Self {
        Self::new(stages, Mask::SHADER_STORAGE_WRITE, Layout::GENERAL)
    }

    /// A storage image that these shader stages load from and store to, or use atomics on.
    pub const fn storage_image_read_write(stages: Stages) -> Self {
        let mask = Mask::SHADER_STORAGE_READ.as_raw() | Mask::SHADER_STORAGE_WRITE.as_raw();
        Self::new(stages, Mask::from_raw(mask), Layout::GENERAL)
    }

    /// A storage buffer that these shader stages load from.
    pub const fn storage_buffer_read(stages: Stages) -> Self {
        Self::new(stages, Mask::SHADER_STORAGE_READ, Layout::UNDEFINED)
    }

    /// A storage buffer that these shader stages store to.
    pub const fn storage_buffer_write(stages: Stages) -> Self {
        Self::new(stages, Mask::SHADER_STORAGE_WRITE, Layout::UNDEFINED)
    }

    /// A storage buffer that these shader stages load from and store to, or use atomics on.
    pub const fn storage_buffer_read_write(stages: Stages) -> Self {
        let mask = Mask::SHADER_STORAGE_READ.as_raw() | Mask::SHADER_STORAGE_WRITE.as_raw();
        Self::new(stages, Mask::from_raw(mask), Layout::UNDEFINED)
    }

    /// A uniform buffer seen by these shader stages.
    pub const fn uniform(stages: Stages) -> Self {
        Self::new(stages, Mask::UNIFORM_READ, Layout::UNDEFINED)
    }

    /// A vertex buffer.
    pub const fn vertex() -> Self {
        Self::new(Stages::VERTEX_ATTRIBUTE_INPUT, Mask::VERTEX_ATTRIBUTE_READ, Layout::UNDEFINED)
    }

    /// An index buffer.
    pub const fn index() -> Self {
        Self::new(Stages::INDEX_INPUT, Mask::INDEX_READ, Layout::UNDEFINED)
    }

    /// Arguments or the count of an indirect draw or dispatch.
    pub const fn indirect() -> Self {
        Self::new(Stages::DRAW_INDIRECT, Mask::INDIRECT_COMMAND_READ, Layout::UNDEFINED)
    }

    /// Source of any transfer command. [`Access::copy_read`] and [`Access::blit_read`] wait for less.
    pub const fn transfer_read() -> Self {
        Self::new(Stages::ALL_TRANSFER, Mask::TRANSFER_READ, Layout::TRANSFER_SRC_OPTIMAL)
    }

    /// Destination of any transfer command. [`Access::copy_write`], [`Access::blit_write`] and [`Access::clear`] wait
    /// for less.
    pub const fn transfer_write() -> Self {
        Self::new(Stages::ALL_TRANSFER, Mask::TRANSFER_WRITE, Layout::TRANSFER_DST_OPTIMAL)
    }

    /// Source of a copy.
    pub const fn copy_read() -> Self {
        Self::new(Stages::COPY, Mask::TRANSFER_READ, Layout::TRANSFER_SRC_OPTIMAL)
    }

    /// Destination of a copy.
    pub const fn copy_write() -> Self {
        Self::new(Stages::COPY, Mask::TRANSFER_WRITE, Layout::TRANSFER_DST_OPTIMAL)
    }

    /// Source of a blit.
    pub const fn blit_read() -> Self {
        Self::new(Stages::BLIT, Mask::TRANSFER_READ, Layout::TRANSFER_SRC_OPTIMAL)
    }

    /// Destination of a blit.
    pub const fn blit_write() -> Self {
        Self::new(Stages::BLIT, Mask::TRANSFER_WRITE, Layout::TRANSFER_DST_OPTIMAL)
    }

    /// Destination of a clear or a fill outside of rendering.
    pub const fn clear() -> Self {
        Self::new(Stages::CLEAR, Mask::TRANSFER_WRITE, Layout::TRANSFER_DST_OPTIMAL)
    }

    /// Memory that the host reads.
    pub const fn host_read() -> Self {
        Self::new(Stages::HOST, Mask::HOST_READ, Layout::GENERAL)
    }

    /// Memory that the host wrote.
    pub const fn host_write() -> Self {
        Self::new(Stages::HOST, Mask::HOST_WRITE, Layout::GENERAL)
    }

    /// An image that is shown in a window. The presentation's semaphore does the waiting.
    pub const fn present() -> Self {
        Self::new(Stages::NONE, Mask::NONE, Layout::PRESENT_SRC_KHR)
    }

    /// The part of the mask that writes.
    pub fn writes(self) -> Mask {
        self.mask & WRITES
    }

    /// The part of the mask that reads.
    pub fn reads(self) -> Mask {
        self.mask & !WRITES
    }

    /// Whether a resource that arrives in this state holds anything: an image in layout `UNDEFINED` does not.
    pub fn has_contents(self, shape: &Shape) -> bool {
        matches!(shape, Shape::Buffer { .. }) || self.layout != Layout::UNDEFINED
    }

    /// Stages and masks of both; the layout of the first.
    pub fn merge(self, other: Access) -> Access {
        let mut stages = self.stages | other.stages;
        if stages.contains(Stages::ALL_TRANSFER) {
            stages &= !(Stages::COPY | Stages::BLIT | Stages::RESOLVE | Stages::CLEAR);
        }
        Access { stages, mask: self.mask | other.mask, layout: self.layout }
    }
}

impl super::description::ImageShape {
    /// The aspects its format has.
    pub fn aspects(&self) -> vk::ImageAspectFlags {
        match self.format {
            vk::Format::D16_UNORM | vk::Format::X8_D24_UNORM_PACK32 | vk::Format::D32_SFLOAT => {
                vk::ImageAspectFlags::DEPTH
            }
            vk::Format::S8_UINT => vk::ImageAspectFlags::STENCIL,
            vk::Format::D16_UNORM_S8_UINT | vk::Format::D24_UNORM_S8_UINT | vk::Format::D32_SFLOAT_S8_UINT => {
                vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL
            }
            _ => vk::ImageAspectFlags::COLOR,
        }
    }
}
