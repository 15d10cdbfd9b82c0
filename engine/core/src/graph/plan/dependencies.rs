//! Which pass must come before which: per cell, the users of an epoch stand between its writers and the next ones.

use super::versions::Versions;
use crate::graph::description::{Description, VersionId};

/// A pass or a read-back: passes by their id, then roots by theirs.
pub(super) type Node = u32;

/// One use of one cell.
#[derive(Clone, Copy)]
pub(super) struct Event {
    /// The cell.
    pub(super) cell: u32,
    /// Epoch `e` is written at `2 e - 1` and read at `2 e`. Who reads and writes over is only a writer.
    pub(super) time: u32,
    /// Who.
    pub(super) node: Node,
    /// The version it makes.
    pub(super) makes: Option<VersionId>,
}

/// Uses of all cells, by cell and time.
pub(super) fn events(description: &Description, versions: &Versions, live: &[bool]) -> Vec<Event> {
    let uses: usize = description.passes.iter().map(|pass| pass.uses.len()).sum();
    let mut events = Vec::with_capacity(uses + description.roots.len());
    let mut add = |node: Node, version: VersionId, makes: Option<VersionId>| {
        for slot in versions.cells.slots(version.0 as usize) {
            let time = 2 * versions.epoch[slot] + u32::from(makes.is_some());
            events.push(Event { cell: versions.cells.cell(slot), time, node, makes });
        }
    };
    for (index, pass) in description.passes.iter().enumerate().filter(|(index, _)| live[*index]) {
        for used in pass.uses.iter().filter(|used| versions.is_known(used.version)) {
            add(index as Node, used.version, used.makes.filter(|&made| versions.is_known(made)));
        }
    }
    let passes = description.passes.len() as Node;
    for (index, root) in description.roots.iter().enumerate() {
        if root.read_back && versions.is_known(root.version) {
            add(passes + index as Node, root.version, None);
        }
    }
    events.sort_by_key(|event| (event.cell, event.time));
    events
}

/// Who waits for whom.
pub(super) struct Dependencies {
    /// By node, then the total.
    first: Vec<u32>,
    /// Who waits for the node, and for a use of which cell.
    after: Vec<(Node, u32)>,
}

impl Dependencies {
    /// From events in order. `nodes`: how many there are.
    pub(super) fn new(events: &[Event], nodes: usize) -> Self {
        let mut edges: Vec<(Node, Node, u32)> = Vec::with_capacity(events.len());
        for cell in events.chunk_by(|a, b| a.cell == b.cell) {
            let mut sets = cell.chunk_by(|a, b| a.time == b.time);
            let Some(mut earlier) = sets.next() else { continue };
            for later in sets {
                for from in earlier {
                    let others = later.iter().filter(|to| to.node != from.node);
                    edges.extend(others.map(|to| (from.node, to.node, from.cell)));
                }
                earlier = later;
            }
        }
        edges.sort_unstable();
        edges.dedup_by_key(|(from, to, _)| (*from, *to));
        let mut first = vec![0; nodes + 1];
        for (from, ..) in &edges {
            first[*from as usize + 1] += 1;
        }
        for node in 0..nodes {
            first[node + 1] += first[node];
        }
        Self { first, after: edges.into_iter().map(|(_, to, cell)| (to, cell)).collect() }
    }

    /// Who waits for a node, and for a use of which cell.
    pub(super) fn after(&self, node: Node) -> &[(Node, u32)] {
        &self.after[self.first[node as usize] as usize..self.first[node as usize + 1] as usize]
    }

    /// How many nodes each node waits for.
    pub(super) fn counts(&self) -> Vec<u32> {
        let mut counts = vec![0; self.first.len() - 1];
        for (to, _) in &self.after {
            counts[*to as usize] += 1;
        }
        counts
    }

    /// Nodes that wait for one another in a circle, each with the cell over which the next one waits for it.
    pub(super) fn cycle(&self) -> Option<Vec<(Node, u32)>> {
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
