//! The state of one part of a resource.

use ash::vk::ImageLayout as Layout;
use shadowgraph::graph::description::{Description, Origin, Queue, Shape, State};
use shadowgraph::graph::plan::{DeviceModel, Ownership};

use super::atoms::Atoms;
use super::contents::Contents;
use super::record::{Kind, Record, each, single};

/// State of one part of a resource.
#[derive(Clone, Debug)]
pub struct Part {
    pub records: Vec<Record>,
    pub layout: Layout,
    /// Queue family; nobody's until it is used.
    pub owner: Option<u32>,
    /// On its way to another family, with the layouts it goes from and to.
    pub released: Option<(Ownership, Layout, Layout)>,
    pub contents: Contents,
    /// When it was last written; later is more.
    pub written: usize,
}

/// The state before the frame.
pub fn arrival(description: &Description, atoms: &Atoms, device: &dyn DeviceModel, atom: usize) -> Part {
    let resource = &description.resources[atoms.resource(atom).0 as usize];
    let mut part = Part {
        records: Vec::new(),
        layout: Layout::UNDEFINED,
        owner: None,
        released: None,
        contents: Contents::Nothing,
        written: 0,
    };
    let is_image = matches!(resource.shape, Shape::Image(_));
    let state = match &resource.origin {
        Origin::Transient => None,
        Origin::Imported { before, .. } => Some((*before, !is_image || before.layout != Layout::UNDEFINED)),
        Origin::Kept { before, .. } => {
            let here = |state: &&State| atoms.of(atoms.resource(atom), &state.range).contains(&atom);
            before.iter().find(here).map(|state| (state.access, state.holds))
        }
    };
    if let Some((before, holds)) = state {
        part.layout = if is_image { before.layout } else { Layout::UNDEFINED };
        part.owner = device.family(Queue::Graphics).filter(|_| holds || !before.stages.is_empty());
        if holds {
            part.contents = Contents::Arrived;
        }
        if before.writes().is_empty() && !before.stages.is_empty() {
            part.records.push(Record::arrived(&before));
        }
        let kind = if before.writes().is_empty() { Kind::Read } else { Kind::Write };
        for stage in each(single(before.stages)) {
            let mask = if kind == Kind::Read { before.mask } else { before.writes() };
            part.records.push(Record::new(kind, "before the frame".into(), Queue::Graphics, 0, stage, mask));
        }
    }
    part
}
