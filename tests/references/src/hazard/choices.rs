//! What random passes can do to a range, and how a range can be taken apart.

use ash::vk::{ImageAspectFlags as Aspects, PipelineStageFlags2 as Stages};
use shadowgraph::graph::description::{Access, Queue, Range, Shape};

/// What a pass of a queue can do to a range.
pub(super) fn accesses(shape: &Shape, range: &Range, queue: Queue, writes: bool) -> Vec<Access> {
    let (vertex, fragment, compute) = (Stages::VERTEX_SHADER, Stages::FRAGMENT_SHADER, Stages::COMPUTE_SHADER);
    let color = matches!(range, Range::Image { aspects, .. } if *aspects == Aspects::COLOR);
    let mut all = match (shape, writes) {
        (Shape::Buffer { .. }, false) => vec![
            Access::uniform(vertex),
            Access::storage_buffer_read(fragment),
            Access::storage_buffer_read(vertex | fragment),
            Access::storage_buffer_read(compute),
            Access::uniform(compute),
            Access::vertex(),
            Access::index(),
            Access::indirect(),
            Access::copy_read(),
            Access::transfer_read(),
        ],
        (Shape::Buffer { .. }, true) => vec![
            Access::storage_buffer_write(compute),
            Access::storage_buffer_read_write(compute),
            Access::storage_buffer_read_write(fragment),
            Access::transfer_write(),
            Access::clear(),
        ],
        (Shape::Image(_), false) => vec![
            Access::sampled(fragment),
            Access::sampled(vertex | fragment),
            Access::sampled(compute),
            Access::copy_read(),
            Access::transfer_read(),
        ],
        (Shape::Image(_), true) => vec![Access::copy_write(), Access::clear()],
    };
    if matches!(shape, Shape::Image(_)) {
        all.extend(match (color, writes) {
            (true, false) => vec![Access::storage_image_read(compute), Access::storage_image_read(fragment)],
            (true, true) => vec![
                Access::color_attachment(false),
                Access::color_attachment(true),
                Access::storage_image_write(compute),
                Access::storage_image_read_write(compute),
                Access::blit_write(),
            ],
            (false, false) => vec![Access::depth_attachment_read()],
            (false, true) => vec![Access::depth_attachment_write()],
        });
    }
    let allowed = match queue {
        Queue::Graphics => Stages::from_raw(u64::MAX),
        Queue::Compute => compute | Stages::DRAW_INDIRECT | Stages::COPY | Stages::CLEAR | Stages::ALL_TRANSFER,
        Queue::Transfer => Stages::COPY | Stages::CLEAR | Stages::ALL_TRANSFER,
    };
    all.retain(|access| allowed.contains(access.stages));
    all
}

/// A range cut in two: by mips, layers or aspects, where it has several; a buffer by bytes.
pub(super) fn halves(range: Range, way: u8, at: u8) -> Vec<Range> {
    match range {
        Range::Buffer([first, end]) if end - first >= 8 => {
            let middle = first + 4 + u64::from(at) * (end - first - 8) / 255;
            vec![Range::Buffer([first, middle]), Range::Buffer([middle, end])]
        }
        Range::Image { aspects, mips: [m, mips], layers: [l, layers] } => {
            let depth = Aspects::DEPTH | Aspects::STENCIL;
            let cut = |first: u32, end: u32| first + 1 + u32::from(at) % (end - first - 1);
            if aspects == depth && way.is_multiple_of(3) {
                let part = |aspects| Range::Image { aspects, mips: [m, mips], layers: [l, layers] };
                vec![part(Aspects::DEPTH), part(Aspects::STENCIL)]
            } else if mips - m > 1 && way.is_multiple_of(2) {
                let part = |mips| Range::Image { aspects, mips, layers: [l, layers] };
                vec![part([m, cut(m, mips)]), part([cut(m, mips), mips])]
            } else if layers - l > 1 {
                let part = |layers| Range::Image { aspects, mips: [m, mips], layers };
                vec![part([l, cut(l, layers)]), part([cut(l, layers), layers])]
            } else {
                Vec::new()
            }
        }
        Range::Buffer(_) => Vec::new(),
    }
}
