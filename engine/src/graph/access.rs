//! What a use of a resource needs, by what it is used as. Nobody else types Vulkan's access flags.

use ash::vk;
use ash::vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};

use super::description::{Access, ImageShape, Range};

impl Access {
    const fn new(stages: S, mask: A, layout: L) -> Self {
        Self { stages, mask, layout }
    }

    /// Nothing yet: contents are undefined.
    pub const fn none() -> Self {
        Self::new(S::NONE, A::NONE, L::UNDEFINED)
    }

    /// Colour attachment; `reads` where it is loaded or blended.
    pub fn color_attachment(reads: bool) -> Self {
        let mask = if reads { A::COLOR_ATTACHMENT_READ | A::COLOR_ATTACHMENT_WRITE } else { A::COLOR_ATTACHMENT_WRITE };
        Self::new(S::COLOR_ATTACHMENT_OUTPUT, mask, L::COLOR_ATTACHMENT_OPTIMAL)
    }

    /// Depth (and stencil) attachment, tested and written.
    pub fn depth_attachment_write() -> Self {
        let mask = A::DEPTH_STENCIL_ATTACHMENT_READ | A::DEPTH_STENCIL_ATTACHMENT_WRITE;
        Self::new(S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS, mask, L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL)
    }

    /// Depth (and stencil) attachment, tested only. May be sampled at the same time.
    pub fn depth_attachment_read() -> Self {
        let stages = S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS;
        Self::new(stages, A::DEPTH_STENCIL_ATTACHMENT_READ, L::DEPTH_STENCIL_READ_ONLY_OPTIMAL)
    }

    /// Sampled or fetched as a texture by these stages.
    pub fn sampled(stages: S) -> Self {
        Self::new(stages, A::SHADER_SAMPLED_READ, L::SHADER_READ_ONLY_OPTIMAL)
    }

    /// Storage image, loads only.
    pub fn storage_image_read(stages: S) -> Self {
        Self::new(stages, A::SHADER_STORAGE_READ, L::GENERAL)
    }

    /// Storage image, stores only.
    pub fn storage_image_write(stages: S) -> Self {
        Self::new(stages, A::SHADER_STORAGE_WRITE, L::GENERAL)
    }

    /// Storage image, loads and stores or atomics.
    pub fn storage_image_read_write(stages: S) -> Self {
        Self::new(stages, A::SHADER_STORAGE_READ | A::SHADER_STORAGE_WRITE, L::GENERAL)
    }

    /// Storage buffer, loads only.
    pub fn storage_buffer_read(stages: S) -> Self {
        Self::new(stages, A::SHADER_STORAGE_READ, L::UNDEFINED)
    }

    /// Storage buffer, stores only.
    pub fn storage_buffer_write(stages: S) -> Self {
        Self::new(stages, A::SHADER_STORAGE_WRITE, L::UNDEFINED)
    }

    /// Storage buffer, loads and stores or atomics.
    pub fn storage_buffer_read_write(stages: S) -> Self {
        Self::new(stages, A::SHADER_STORAGE_READ | A::SHADER_STORAGE_WRITE, L::UNDEFINED)
    }

    /// Uniform block.
    pub fn uniform(stages: S) -> Self {
        Self::new(stages, A::UNIFORM_READ, L::UNDEFINED)
    }

    /// Parameters of indirect draws and dispatches.
    pub fn indirect() -> Self {
        Self::new(S::DRAW_INDIRECT, A::INDIRECT_COMMAND_READ, L::UNDEFINED)
    }

    /// Vertex buffer.
    pub fn vertex() -> Self {
        Self::new(S::VERTEX_ATTRIBUTE_INPUT, A::VERTEX_ATTRIBUTE_READ, L::UNDEFINED)
    }

    /// Index buffer.
    pub fn index() -> Self {
        Self::new(S::INDEX_INPUT, A::INDEX_READ, L::UNDEFINED)
    }

    /// Source of a copy.
    pub fn transfer_read() -> Self {
        Self::new(S::ALL_TRANSFER, A::TRANSFER_READ, L::TRANSFER_SRC_OPTIMAL)
    }

    /// Destination of a copy, a fill or a clear.
    pub fn transfer_write() -> Self {
        Self::new(S::ALL_TRANSFER, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL)
    }

    /// Read by the host after the frame.
    pub fn host_read() -> Self {
        Self::new(S::HOST, A::HOST_READ, L::UNDEFINED)
    }

    /// Whether it writes.
    pub fn writes(&self) -> bool {
        let writes = A::COLOR_ATTACHMENT_WRITE
            | A::DEPTH_STENCIL_ATTACHMENT_WRITE
            | A::SHADER_STORAGE_WRITE
            | A::SHADER_WRITE
            | A::TRANSFER_WRITE
            | A::HOST_WRITE
            | A::MEMORY_WRITE;
        self.mask.intersects(writes)
    }
}

impl ImageShape {
    /// Aspects that the format has.
    pub fn aspects(&self) -> vk::ImageAspectFlags {
        use vk::ImageAspectFlags as Aspect;
        match self.format {
            vk::Format::D16_UNORM | vk::Format::D32_SFLOAT | vk::Format::X8_D24_UNORM_PACK32 => Aspect::DEPTH,
            vk::Format::S8_UINT => Aspect::STENCIL,
            vk::Format::D16_UNORM_S8_UINT | vk::Format::D24_UNORM_S8_UINT | vk::Format::D32_SFLOAT_S8_UINT => {
                Aspect::DEPTH | Aspect::STENCIL
            }
            _ => Aspect::COLOR,
        }
    }
}

impl Range {
    /// All of an image.
    pub fn whole_image(shape: &ImageShape) -> Self {
        Self::Image { aspects: shape.aspects(), mips: [0, shape.mips], layers: [0, shape.layers] }
    }

    /// Smallest block around two parts of one resource.
    pub fn hull(self, other: Self) -> Self {
        let around = |a: [u32; 2], b: [u32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        match (self, other) {
            (
                Self::Image { aspects, mips, layers },
                Self::Image { aspects: other_aspects, mips: other_mips, layers: other_layers },
            ) => Self::Image {
                aspects: aspects | other_aspects,
                mips: around(mips, other_mips),
                layers: around(layers, other_layers),
            },
            (Self::Buffer(a), Self::Buffer(b)) => Self::Buffer([a[0].min(b[0]), a[1].max(b[1])]),
            (range, _) => range,
        }
    }
}
