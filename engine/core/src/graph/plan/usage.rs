//! What each memory access is allowed on, and the usage flags that it asks for.

use ash::vk::{
    AccessFlags2 as Mask, BufferUsageFlags as BufferUsage, ImageAspectFlags as Aspects, ImageLayout as Layout,
    ImageUsageFlags as ImageUsage, PipelineStageFlags2 as Stages,
};

use super::Usage;
use super::stages::bits;
use crate::graph::description::{Access, Description, Resource, Root, Shape, Use};

const SHADERS: Stages = Stages::from_raw(
    Stages::VERTEX_SHADER.as_raw()
        | Stages::TESSELLATION_CONTROL_SHADER.as_raw()
        | Stages::TESSELLATION_EVALUATION_SHADER.as_raw()
        | Stages::GEOMETRY_SHADER.as_raw()
        | Stages::FRAGMENT_SHADER.as_raw()
        | Stages::COMPUTE_SHADER.as_raw(),
);
const TRANSFERS: Stages = Stages::from_raw(
    Stages::ALL_TRANSFER.as_raw()
        | Stages::COPY.as_raw()
        | Stages::BLIT.as_raw()
        | Stages::RESOLVE.as_raw()
        | Stages::CLEAR.as_raw(),
);
const TESTS: Stages = Stages::from_raw(Stages::EARLY_FRAGMENT_TESTS.as_raw() | Stages::LATE_FRAGMENT_TESTS.as_raw());

/// One bit of an access mask.
pub(super) struct Kind {
    pub(super) mask: Mask,
    /// Stages that can do it.
    pub(super) stages: Stages,
    image: ImageUsage,
    buffer: BufferUsage,
    /// Aspects of images it works on.
    pub(super) aspects: Aspects,
    /// Layouts of images it works in.
    pub(super) layouts: &'static [Layout],
}

const fn kind(mask: Mask, stages: Stages) -> Kind {
    let (image, buffer) = (ImageUsage::empty(), BufferUsage::empty());
    Kind { mask, stages, image, buffer, aspects: Aspects::empty(), layouts: &[] }
}

const ANY_ASPECT: Aspects =
    Aspects::from_raw(Aspects::COLOR.as_raw() | Aspects::DEPTH.as_raw() | Aspects::STENCIL.as_raw());
const DEPTH_STENCIL: Aspects = Aspects::from_raw(Aspects::DEPTH.as_raw() | Aspects::STENCIL.as_raw());
const READ_ONLY: &[Layout] = &[
    Layout::READ_ONLY_OPTIMAL,
    Layout::SHADER_READ_ONLY_OPTIMAL,
    Layout::DEPTH_STENCIL_READ_ONLY_OPTIMAL,
    Layout::DEPTH_READ_ONLY_OPTIMAL,
    Layout::STENCIL_READ_ONLY_OPTIMAL,
    Layout::GENERAL,
];
const DEPTH_READ: &[Layout] = &[
    Layout::READ_ONLY_OPTIMAL,
    Layout::DEPTH_STENCIL_READ_ONLY_OPTIMAL,
    Layout::DEPTH_READ_ONLY_OPTIMAL,
    Layout::STENCIL_READ_ONLY_OPTIMAL,
    Layout::ATTACHMENT_OPTIMAL,
    Layout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
    Layout::DEPTH_ATTACHMENT_OPTIMAL,
    Layout::STENCIL_ATTACHMENT_OPTIMAL,
    Layout::GENERAL,
];
const DEPTH_WRITE: &[Layout] = &[
    Layout::ATTACHMENT_OPTIMAL,
    Layout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
    Layout::DEPTH_ATTACHMENT_OPTIMAL,
    Layout::STENCIL_ATTACHMENT_OPTIMAL,
    Layout::GENERAL,
];
const COLOR: &[Layout] = &[Layout::ATTACHMENT_OPTIMAL, Layout::COLOR_ATTACHMENT_OPTIMAL, Layout::GENERAL];

/// Every access that a pass may declare.
pub(super) const KINDS: &[Kind] = &[
    Kind { buffer: BufferUsage::INDIRECT_BUFFER, ..kind(Mask::INDIRECT_COMMAND_READ, Stages::DRAW_INDIRECT) },
    Kind { buffer: BufferUsage::INDEX_BUFFER, ..kind(Mask::INDEX_READ, Stages::INDEX_INPUT) },
    Kind { buffer: BufferUsage::VERTEX_BUFFER, ..kind(Mask::VERTEX_ATTRIBUTE_READ, Stages::VERTEX_ATTRIBUTE_INPUT) },
    Kind { buffer: BufferUsage::UNIFORM_BUFFER, ..kind(Mask::UNIFORM_READ, SHADERS) },
    Kind {
        image: ImageUsage::SAMPLED,
        aspects: ANY_ASPECT,
        layouts: READ_ONLY,
        ..kind(Mask::SHADER_SAMPLED_READ, SHADERS)
    },
    Kind {
        image: ImageUsage::STORAGE,
        buffer: BufferUsage::STORAGE_BUFFER,
        aspects: Aspects::COLOR,
        layouts: &[Layout::GENERAL],
        ..kind(Mask::SHADER_STORAGE_READ, SHADERS)
    },
    Kind {
        image: ImageUsage::STORAGE,
        buffer: BufferUsage::STORAGE_BUFFER,
        aspects: Aspects::COLOR,
        layouts: &[Layout::GENERAL],
        ..kind(Mask::SHADER_STORAGE_WRITE, SHADERS)
    },
    Kind {
        image: ImageUsage::COLOR_ATTACHMENT,
        aspects: Aspects::COLOR,
        layouts: COLOR,
        ..kind(Mask::COLOR_ATTACHMENT_READ, Stages::COLOR_ATTACHMENT_OUTPUT)
    },
    Kind {
        image: ImageUsage::COLOR_ATTACHMENT,
        aspects: Aspects::COLOR,
        layouts: COLOR,
        ..kind(Mask::COLOR_ATTACHMENT_WRITE, Stages::COLOR_ATTACHMENT_OUTPUT)
    },
    Kind {
        image: ImageUsage::INPUT_ATTACHMENT,
        aspects: Aspects::COLOR,
        layouts: &[Layout::GENERAL],
        ..kind(Mask::INPUT_ATTACHMENT_READ, Stages::FRAGMENT_SHADER)
    },
    Kind {
        image: ImageUsage::DEPTH_STENCIL_ATTACHMENT,
        aspects: DEPTH_STENCIL,
        layouts: DEPTH_READ,
        ..kind(Mask::DEPTH_STENCIL_ATTACHMENT_READ, TESTS)
    },
    Kind {
        image: ImageUsage::DEPTH_STENCIL_ATTACHMENT,
        aspects: DEPTH_STENCIL,
        layouts: DEPTH_WRITE,
        ..kind(Mask::DEPTH_STENCIL_ATTACHMENT_WRITE, TESTS)
    },
    Kind {
        image: ImageUsage::TRANSFER_SRC,
        buffer: BufferUsage::TRANSFER_SRC,
        aspects: ANY_ASPECT,
        layouts: &[Layout::TRANSFER_SRC_OPTIMAL, Layout::GENERAL],
        ..kind(Mask::TRANSFER_READ, TRANSFERS)
    },
    Kind {
        image: ImageUsage::TRANSFER_DST,
        buffer: BufferUsage::TRANSFER_DST,
        aspects: ANY_ASPECT,
        layouts: &[Layout::TRANSFER_DST_OPTIMAL, Layout::GENERAL],
        ..kind(Mask::TRANSFER_WRITE, TRANSFERS)
    },
];

/// Every access of images, and every one of buffers.
pub(super) const ON_IMAGES: Mask = all_on(true);
pub(super) const ON_BUFFERS: Mask = all_on(false);

const fn all_on(images: bool) -> Mask {
    let (mut all, mut index) = (0, 0);
    while index < KINDS.len() {
        let kind = &KINDS[index];
        let usage = if images { kind.image.as_raw() } else { kind.buffer.as_raw() };
        all |= if usage == 0 { 0 } else { kind.mask.as_raw() };
        index += 1;
    }
    Mask::from_raw(all)
}

impl Kind {
    /// The image usage it needs.
    pub(super) fn usage(&self) -> ImageUsage {
        self.image
    }
}

/// Stages that a compute queue has.
pub(super) const COMPUTE_STAGES: Stages = Stages::from_raw(
    Stages::COMPUTE_SHADER.as_raw()
        | Stages::DRAW_INDIRECT.as_raw()
        | Stages::ALL_TRANSFER.as_raw()
        | Stages::COPY.as_raw()
        | Stages::CLEAR.as_raw(),
);

/// Stages that a transfer queue has.
pub(super) const TRANSFER_STAGES: Stages =
    Stages::from_raw(Stages::ALL_TRANSFER.as_raw() | Stages::COPY.as_raw() | Stages::CLEAR.as_raw());

/// Each stage of an access with each of its masks that reads in that stage.
pub(super) fn reads(access: &Access) -> impl Iterator<Item = (Stages, Mask)> {
    let (stages, mask) = (access.stages, access.reads());
    kinds(mask).flat_map(move |kind| {
        let able = bits((stages & kind.stages).as_raw()).map(Stages::from_raw);
        able.map(|stage| (stage, kind.mask))
    })
}

/// The kinds of access that a mask asks for.
pub(super) fn kinds(mask: Mask) -> impl Iterator<Item = &'static Kind> {
    bits(mask.as_raw()).filter_map(|bit| KINDS.get(usize::from(PLACES[bit.trailing_zeros() as usize])))
}

/// By number of an access's bit: its place among the kinds.
const PLACES: [u8; 64] = {
    let mut places = [u8::MAX; 64];
    let mut place = 0;
    while place < KINDS.len() {
        places[KINDS[place].mask.as_raw().trailing_zeros() as usize] = place as u8;
        place += 1;
    }
    places
};

/// Usage flags that accesses of a resource ask for.
pub(super) fn usage_of(shape: &Shape, mask: Mask) -> Usage {
    let kinds = kinds(mask);
    match shape {
        Shape::Image(_) => Usage::Image(kinds.fold(ImageUsage::empty(), |all, kind| all | kind.image)),
        Shape::Buffer { .. } => Usage::Buffer(kinds.fold(BufferUsage::empty(), |all, kind| all | kind.buffer)),
    }
}

/// Usage flags of every resource that live passes and read-backs use.
pub(super) fn usages(description: &Description, live: &[bool]) -> Vec<Option<Usage>> {
    let mut masks = vec![Mask::NONE; description.resources.len()];
    let mut add = |version: u32, access: &Access| {
        masks[description.versions[version as usize].resource.0 as usize] |= access.mask;
    };
    for (pass, _) in description.passes.iter().zip(live).filter(|(_, live)| **live) {
        description.uses_of(pass).iter().for_each(|used: &Use| add(used.version.0, &used.access));
    }
    for root in description.roots.iter().filter(|root: &&Root| root.read_back) {
        add(root.version.0, &Access::copy_read());
    }
    // No access is empty: this was checked.
    let usage = |(resource, &mask): (&Resource, &Mask)| (!mask.is_empty()).then(|| usage_of(&resource.shape, mask));
    description.resources.iter().zip(&masks).map(usage).collect()
}
