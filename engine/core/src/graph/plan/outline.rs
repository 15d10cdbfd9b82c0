//! The half of a plan that does not follow from sizes but through the order of its steps: who runs, when, and on which queue.

use super::dependencies::Dependencies;
use super::history::{History, Schedule};
use super::lifetimes::Lifetimes;
use super::queues::{Crossing, Families};
use super::versions::Versions;
use super::{Chosen, CullReason, DeviceModel, Requirements, Usage, barriers, order, queues, requirements, usage};
use crate::graph::description::{Description, PassId, ResourceId};
use crate::graph::errors::GraphErrors;

/// What a plan's memory and its barriers follow from.
pub(super) struct Outline {
    pub(super) versions: Versions,
    /// By pass.
    pub(super) live: Vec<bool>,
    pub(super) culled: Vec<(PassId, CullReason)>,
    pub(super) dependencies: Dependencies,
    /// By resource.
    pub(super) usages: Vec<Option<Usage>>,
    pub(super) families: Families,
    pub(super) schedule: Schedule,
    pub(super) history: History,
    pub(super) crossings: Vec<Crossing>,
    pub(super) lifetimes: Lifetimes,
}

/// By resource: the memory of a transient that is used.
pub(super) type Needs = Vec<Option<Requirements>>;

impl Outline {
    pub(super) fn new(
        description: &Description,
        chosen: Chosen,
        device: &dyn DeviceModel,
    ) -> Result<(Self, Needs), GraphErrors> {
        let Chosen { versions, live, culled, events, dependencies } = chosen;

        // 1. What each resource is used for, and the memory it takes.
        let usages = usage::usages(description, &live);
        let needs = requirements(description, device, &usages)?;

        // 2. Put passes and read-backs in order.
        let order = order::order(description, &dependencies, &live, &bytes(&needs));

        // 3. Give each a queue.
        let families = Families::new(device);
        let schedule = queues::assign(description, &versions, order, &families);

        // 4. What happens to each cell, and when each resource is alive.
        let history = History::new(description, &versions, events, &schedule);
        let crossings = barriers::crossings(&history, versions.cells.len(), &schedule);
        let lifetimes = Lifetimes::new(description, &versions, &history, &schedule, &crossings);
        let outline =
            Self { versions, live, culled, dependencies, usages, families, schedule, history, crossings, lifetimes };
        Ok((outline, needs))
    }

    /// The memory that resources of other sizes take, where steps stay in their order.
    pub(super) fn needs_of(&self, description: &Description, device: &dyn DeviceModel) -> Option<Needs> {
        let needs = requirements(description, device, &self.usages).ok()?;
        let order = order::order(description, &self.dependencies, &self.live, &bytes(&needs));
        (order == self.schedule.nodes).then_some(needs)
    }

    /// Whether all of a resource is one cell.
    pub(super) fn is_whole(&self, resource: ResourceId) -> bool {
        self.versions.cells.of(resource).len() == 1
    }
}

/// By resource: what a transient takes, 0 for others.
fn bytes(needs: &Needs) -> Vec<u64> {
    needs.iter().map(|needs| needs.map_or(0, |needs| needs.size.max(1))).collect()
}
