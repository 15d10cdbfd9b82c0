//! Render passes whose fragments read the colour attachment that they write, in primitive order
//! (`VK_EXT_rasterization_order_attachment_access`). Dynamic rendering has no input attachments.

use ash::vk;

use super::commands::Commands;
use super::device::{Device, Garbage};
use crate::Result;

/// An attachment of such a pass.
#[derive(Clone, Copy)]
pub(crate) struct Target {
    /// What is attached.
    pub(crate) view: vk::ImageView,
    /// Its format.
    pub(crate) format: vk::Format,
    /// Its layout before, within and after the pass.
    pub(crate) layout: vk::ImageLayout,
    /// What is done with its contents before and after.
    pub(crate) operations: (vk::AttachmentLoadOp, vk::AttachmentStoreOp),
    /// What it is cleared to.
    pub(crate) clear: vk::ClearValue,
}

impl Target {
    /// All that a pipeline needs to know.
    pub(super) fn of(format: vk::Format) -> Self {
        Self {
            view: vk::ImageView::null(),
            format,
            layout: vk::ImageLayout::GENERAL,
            operations: (vk::AttachmentLoadOp::LOAD, vk::AttachmentStoreOp::STORE),
            clear: vk::ClearValue::default(),
        }
    }

    fn description(&self) -> vk::AttachmentDescription {
        let (load, store) = self.operations;
        vk::AttachmentDescription::default()
            .format(self.format)
            .samples(vk::SampleCountFlags::TYPE_1)
            .load_op(load)
            .store_op(store)
            .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
            .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
            .initial_layout(self.layout)
            .final_layout(self.layout)
    }
}

/// A pass over one colour attachment, which is read in order, and perhaps depth. Passes of the same formats are
/// compatible.
pub(super) fn ordered_pass(device: &Device, color: Target, depth: Option<Target>) -> Result<vk::RenderPass> {
    let attachments: Vec<_> = std::iter::once(color).chain(depth).map(|target| target.description()).collect();
    let read = [vk::AttachmentReference { attachment: 0, layout: color.layout }];
    let tested = depth.map(|depth| vk::AttachmentReference { attachment: 1, layout: depth.layout });
    let mut subpass = vk::SubpassDescription::default()
        .flags(vk::SubpassDescriptionFlags::RASTERIZATION_ORDER_ATTACHMENT_COLOR_ACCESS_EXT)
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .input_attachments(&read)
        .color_attachments(&read);
    if let Some(tested) = &tested {
        subpass = subpass.depth_stencil_attachment(tested);
    }
    let subpasses = [subpass];
    let info = vk::RenderPassCreateInfo::default().attachments(&attachments).subpasses(&subpasses);
    // SAFETY: a valid structure; what it points at lives.
    let made = unsafe { device.raw.create_render_pass(&info, None) };
    made.map_err(|e| device.error("vkCreateRenderPass", "ordered attachments", e))
}

impl Commands {
    /// Begins such a pass, with viewport and scissor.
    pub(crate) fn begin_ordered(&self, color: Target, depth: Option<Target>, size: [u32; 2]) -> Result<()> {
        let device = self.owner();
        let pass = ordered_pass(device, color, depth)?;
        let views: Vec<_> = std::iter::once(color).chain(depth).map(|target| target.view).collect();
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(pass)
            .attachments(&views)
            .width(size[0])
            .height(size[1])
            .layers(1);
        // SAFETY: a valid structure; what it points at lives.
        let made = unsafe { device.raw.create_framebuffer(&info, None) };
        // Both are kept until this recording has run.
        device.defer(Garbage::RenderPass(pass, *made.as_ref().unwrap_or(&vk::Framebuffer::null())));
        let framebuffer = made.map_err(|e| device.error("vkCreateFramebuffer", "ordered attachments", e))?;

        let extent = vk::Extent2D { width: size[0], height: size[1] };
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent };
        let clears: Vec<_> = std::iter::once(color).chain(depth).map(|target| target.clear).collect();
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(pass)
            .framebuffer(framebuffer)
            .render_area(area)
            .clear_values(&clears);
        let viewport =
            vk::Viewport { width: size[0] as f32, height: size[1] as f32, max_depth: 1.0, ..vk::Viewport::default() };
        // SAFETY: the command buffer is being recorded, outside of rendering; the views are of live images of this size.
        unsafe {
            device.raw.cmd_begin_render_pass(self.raw(), &begin, vk::SubpassContents::INLINE);
            device.raw.cmd_set_viewport(self.raw(), 0, &[viewport]);
            device.raw.cmd_set_scissor(self.raw(), 0, &[area]);
        }
        Ok(())
    }

    /// Ends it.
    pub(crate) fn end_ordered(&self) {
        // SAFETY: a render pass is begun.
        unsafe { self.device().cmd_end_render_pass(self.raw()) }
    }
}
