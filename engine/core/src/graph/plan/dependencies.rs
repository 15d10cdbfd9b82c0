//! Which pass must come before which: per cell, the users of an epoch stand between its writers and the next ones.

use super::lists::Lists;
use super::versions::Versions;
use crate::graph::description::{Description, VersionId};

/// A pass or a read-back: passes by their id, then roots by theirs.
pub(super) type Node = u32;

/// One use of one cell.
#[derive(Clone, Copy)]
pub(super) struct Event {
    /// Epoch `e` is written at `2 e - 1` and read at `2 e`. Who reads and writes over is only a writer.
    pub(super) time: u32,
    /// Who.
    pub(super) node: Node,
    /// Its place among the description's uses; 0 of a read-back.
    pub(super) used: u32,
}

/// Uses of all cells, by cell and time.
pub(super) struct Events(Lists<Event>);

impl Events {
    /// Of all passes and read-backs, as far as their versions are known.
    pub(super) fn new(description: &Description, versions: &Versions) -> Self {
        // 1. In recorded order.
        let most = versions.cells.slot_count() + description.roots.len();
        let mut recorded: Vec<(u32, Event)> = Vec::with_capacity(most);
        let mut add = |node: Node, used: u32, version: VersionId, writes: bool| {
            for slot in versions.cells.slots(version.0 as usize) {
                let time = 2 * versions.epoch[slot] + u32::from(writes);
                recorded.push((versions.cells.cell(slot), Event { time, node, used }));
            }
        };
        for (node, pass) in description.passes.iter().enumerate() {
            for (place, used) in (pass.uses.start..).zip(description.uses_of(pass)) {
                if versions.is_known(used.version) {
                    let writes = used.makes.is_some_and(|made| versions.is_known(made));
                    add(node as Node, place, used.version, writes);
                }
            }
        }
        let passes = description.passes.len() as Node;
        for (index, root) in description.roots.iter().enumerate() {
            if root.read_back && versions.is_known(root.version) {
                add(passes + index as Node, 0, root.version, false);
            }
        }

        // 2. By cell, and there by time: most come in order.
        let mut events = Self::by_cell(versions.cells.len(), &recorded);
        (0..events.cells()).for_each(|cell| events.sort(cell, |event| event.time));
        events
    }

    /// Each with its cell, of which there are `cells`; those of one come by time.
    pub(super) fn by_cell(cells: usize, recorded: &[(u32, Event)]) -> Self {
        Self(Lists::new(cells, recorded.iter().map(|&(cell, event)| (cell as usize, event))))
    }

    /// Number of all.
    pub(super) fn len(&self) -> usize {
        self.0.all().len()
    }

    /// Number of cells.
    pub(super) fn cells(&self) -> u32 {
        self.0.count() as u32
    }

    /// Of one cell, in order.
    pub(super) fn of(&self, cell: u32) -> &[Event] {
        self.0.of(cell as usize)
    }

    /// Puts those of one cell in order, where they are not; events that are alike stay as they are.
    pub(super) fn sort(&mut self, cell: u32, key: impl Fn(&Event) -> u32) {
        let events = self.0.of_mut(cell as usize);
        if !events.is_sorted_by_key(&key) {
            events.sort_by_key(&key);
        }
    }

    /// Leaves out what does not run.
    pub(super) fn retain(&mut self, runs: impl Fn(Node) -> bool) {
        self.0.retain(|_, event| runs(event.node));
    }
}

/// Who waits for whom.
pub(super) struct Dependencies {
    /// By node: who waits for it, and for a use of which cell.
    after: Lists<(Node, u32)>,
    /// Whether nodes wait only for those recorded before them.
    forward: bool,
}

impl Dependencies {
    /// From events in order. `nodes`: how many there are.
    pub(super) fn new(events: &Events, nodes: usize) -> Self {
        // 1. The users of one time wait for those of the time before.
        let mut edges: Vec<(Node, (Node, u32))> = Vec::with_capacity(events.len());
        let mut forward = true;
        for cell in 0..events.cells() {
            let events = events.of(cell);
            // Where those of the time before begin, and those of this time.
            let (mut earlier, mut same) = (0, 0);
            for (place, to) in events.iter().enumerate().skip(1) {
                if events[same].time != to.time {
                    (earlier, same) = (same, place);
                }
                for from in events[earlier..same].iter().filter(|from| from.node != to.node) {
                    forward &= from.node < to.node;
                    edges.push((from.node, (to.node, cell)));
                }
            }
        }

        // 2. By node, each once, for the first cell that asks for it.
        let mut after = Lists::new(nodes, edges.iter().map(|&(from, edge)| (from as usize, edge)));
        let mut doubled = false;
        for node in 0..nodes {
            let after = after.of_mut(node);
            if after.len() > 1 {
                after.sort_unstable();
                doubled |= after.windows(2).any(|pair| pair[0].0 == pair[1].0);
            }
        }
        if doubled {
            after.retain(|last, (to, _)| last.is_none_or(|(last, _)| last != to));
        }
        Self { after, forward }
    }

    /// Who waits for a node, and for a use of which cell.
    pub(super) fn after(&self, node: Node) -> &[(Node, u32)] {
        self.after.of(node as usize)
    }

    /// How many nodes each node waits for.
    pub(super) fn counts(&self) -> Vec<u32> {
        let mut counts = vec![0; self.after.count()];
        for (to, _) in self.after.all() {
            counts[*to as usize] += 1;
        }
        counts
    }

    /// Nodes that wait for one another in a circle, each with the cell over which the next one waits for it.
    pub(super) fn cycle(&self) -> Option<Vec<(Node, u32)>> {
        if self.forward {
            return None;
        }
        let mut waits = self.counts();
        let mut ready: Vec<Node> = (0..waits.len() as Node).filter(|&node| waits[node as usize] == 0).collect();
        while let Some(node) = ready.pop() {
            for &(to, _) in self.after(node) {
                waits[to as usize] -= 1;
                if waits[to as usize] == 0 {
                    ready.push(to);
                }
            }
        }
        // Every node left waits for another one left: going back from any of them runs into a circle.
        let start = waits.iter().position(|&count| count > 0)? as Node;
        let mut path: Vec<(Node, u32)> = vec![(start, 0)];
        loop {
            let (node, _) = *path.last()?;
            let left = (0..waits.len() as Node).filter(|&from| waits[from as usize] > 0);
            let mut edges = left.flat_map(|from| self.after(from).iter().map(move |&(to, cell)| (from, to, cell)));
            let (from, _, cell) = edges.find(|&(_, to, _)| to == node)?;
            if let Some(first) = path.iter().position(|&(known, _)| known == from) {
                let mut circle: Vec<_> = path.drain(first + 1..).rev().collect();
                circle.push((from, cell));
                return Some(circle);
            }
            path.push((from, cell));
        }
    }
}
