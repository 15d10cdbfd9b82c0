//! Frames and segments of frames in a row: what one leaves, the next one finds.

use shadowgraph::graph::description::{Description, Origin, PassId, ResourceId};
use shadowgraph::graph::plan::{DeviceModel, Plan, Segment, Work};

use super::contents::Contents;
use super::memory::placements;
use super::record::{Kind, Record};
use super::replay::Replay;

/// A frame, and which of its kept resources lie in the memory of which ones of the frame before.
pub struct Frame {
    /// What it does.
    pub description: Description,
    /// Its plan.
    pub plan: Plan,
    /// This frame's resource, and that of the frame before.
    pub carried: Vec<(ResourceId, ResourceId)>,
}

/// Everything that is wrong with the plans of successive frames. Accesses of one frame are held against those of the
/// frames before, whatever state the descriptions say that resources arrive in.
pub fn check_frames(frames: &[Frame], device: &dyn DeviceModel) -> Vec<String> {
    let mut errors = Vec::new();
    let mut before: Option<Replay> = None;
    for (index, frame) in frames.iter().enumerate() {
        let mut replay = Replay::new(&frame.description, &frame.plan, device);
        if let Some(old) = &before {
            frame.carried.iter().for_each(|&(new, known)| replay.carry(new, old, known));
        }
        replay.run();
        errors.extend(replay.errors.drain(..).map(|error| format!("frame {index}: {error}")));
        before = Some(replay);
    }
    errors
}

/// Everything that is wrong with the plans of a frame's segments, for a frame that is right. Accesses of one segment
/// are held against those of all before it. That the device is done with transients of the segments before is taken
/// for granted: the host waited to read.
pub fn check_segments(whole: &Description, segments: &[Segment], device: &dyn DeviceModel) -> Vec<String> {
    let plans: Vec<Plan> = segments.iter().map(of_whole).collect();
    let plans: Vec<&Plan> = plans.iter().collect();
    let mut replay = Replay::over(whole, &plans, device);
    replay.completeness(&plans);
    for (segment, plan) in segments.iter().zip(&plans) {
        placements(&segment.description, plan, device, &mut replay.errors);
        replay.begin(plan);
        replay.batches();
        replay.settle();
    }
    replay.end();
    replay.errors
}

/// A segment's plan, with passes and roots numbered as in the whole frame.
fn of_whole(segment: &Segment) -> Plan {
    let mut plan = segment.plan.clone();
    let pass = |pass: PassId| PassId(pass.0 + segment.passes.start as u32);
    for step in &mut plan.steps {
        step.work = match step.work {
            Work::Pass(id) => Work::Pass(pass(id)),
            Work::ReadBack(root) => Work::ReadBack(segment.roots[root]),
        };
    }
    plan.culled.iter_mut().for_each(|(id, _)| *id = pass(*id));
    plan
}

impl Replay<'_> {
    /// Begins a resource in the state that another replay left one in.
    fn carry(&mut self, resource: ResourceId, old: &Replay, known: ResourceId) {
        for atom in self.atoms.all(resource) {
            let parts: Vec<_> =
                self.atoms.same(atom, &old.atoms, known).into_iter().map(|atom| &old.parts[atom]).collect();
            let part = &mut self.parts[atom];
            let claims = part.contents == Contents::Arrived;
            let holds = parts.iter().all(|old| old.contents != Contents::Nothing && old.released.is_none());
            // Between the frames there may be readers that the last one made it visible to.
            part.records.retain(|record| record.kind == Kind::Read);
            part.records.extend(parts.iter().flat_map(|old| &old.records).map(Record::of_the_frame_before));
            part.layout = parts[0].layout;
            part.owner = parts.iter().find_map(|old| old.owner);
            if claims && !holds {
                let name = &self.description.resources[resource.0 as usize].name;
                self.errors.push(format!("`{name}` arrives with contents, but nobody left any"));
                part.contents = Contents::Nothing;
            }
        }
        debug_assert!(matches!(self.description.resources[resource.0 as usize].origin, Origin::Kept { .. }));
    }
}
