//! The order of passes and read-backs.
//!
//! Passes are taken one by one from those that wait for nobody any more. The best one comes at least one pass after
//! those it waited for, so that the device has something to do in between (the idea of Granite's render graph); then
//! the one that frees the most memory, or takes the least; then the one recorded first. Read-backs come when nothing
//! else can: at the end, or where a pass waits to write over what they copy.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::dependencies::{Dependencies, Node};
use crate::graph::description::{Description, ResourceId};

/// Passes that stand between a pass and the last one it waited for; more are no better.
const APART: usize = 1;

/// How many of the passes that could come next are looked at, in recorded order: bounds the cost of wide frames.
const WINDOW: usize = 64;

/// Every live node, in an order that satisfies the dependencies. `bytes`: by resource, what a transient takes, 0 for
/// others.
pub(super) fn order(description: &Description, dependencies: &Dependencies, live: &[bool], bytes: &[u64]) -> Vec<Node> {
    let passes = description.passes.len();
    let is_live = |node: Node| match (node as usize).checked_sub(passes) {
        None => live[node as usize],
        Some(root) => description.roots[root].read_back,
    };
    let mut waits = dependencies.counts();
    let nodes = 0..waits.len() as Node;
    let mut ready = Ready::new(nodes.filter(|&node| is_live(node) && waits[node as usize] == 0).collect());
    // By node: the first place in the order that is far enough from all it waited for.
    let mut apart = vec![0; waits.len()];
    // Where there is one choice at a time, nobody asks.
    let mut memory: Option<Memory> = None;
    let mut order = Vec::with_capacity(waits.len());
    while !ready.first.is_empty() {
        let best = match ready.first.len() {
            1 => 0,
            count => {
                let memory = memory.get_or_insert_with(|| Memory::new(description, is_live, bytes));
                memory.run(&order);
                let score = |&node: &Node| {
                    let is_pass = (node as usize) < passes;
                    let near = apart[node as usize].max(order.len()) - order.len();
                    (is_pass, Reverse(near), memory.gain(node), Reverse(node))
                };
                (0..count).max_by_key(|&index| score(&ready.first[index])).unwrap_or(0)
            }
        };
        let node = ready.take(best);
        for &(after, _) in dependencies.after(node) {
            let after = after as usize;
            apart[after] = order.len() + 1 + APART;
            waits[after] -= 1;
            if waits[after] == 0 && is_live(after as Node) {
                ready.add(after as Node);
            }
        }
        order.push(node);
    }
    order
}

/// What could come next.
struct Ready {
    /// The first ones recorded, ascending.
    first: Vec<Node>,
    /// Those behind them.
    rest: BinaryHeap<Reverse<Node>>,
}

impl Ready {
    /// `nodes`: ascending.
    fn new(nodes: Vec<Node>) -> Self {
        let (first, rest) = nodes.split_at(nodes.len().min(WINDOW));
        Self { first: first.to_vec(), rest: rest.iter().map(|&node| Reverse(node)).collect() }
    }

    fn take(&mut self, index: usize) -> Node {
        let node = self.first.remove(index);
        self.first.extend(self.rest.pop().map(|Reverse(node)| node));
        node
    }

    fn add(&mut self, node: Node) {
        let place = self.first.partition_point(|&other| other < node);
        if place == WINDOW {
            return self.rest.push(Reverse(node));
        }
        if self.first.len() == WINDOW {
            self.rest.extend(self.first.pop().map(Reverse));
        }
        self.first.insert(place, node);
    }
}

/// Which transients are alive.
struct Memory<'a> {
    bytes: &'a [u64],
    /// By node, then the total: where the resources that it uses begin, each once.
    first: Vec<u32>,
    used: Vec<ResourceId>,
    /// By resource: nodes that still use it. Kept roots count as one.
    left: Vec<u32>,
    alive: Vec<bool>,
    /// How many nodes have run.
    ran: usize,
}

impl<'a> Memory<'a> {
    fn new(description: &Description, is_live: impl Fn(Node) -> bool, bytes: &'a [u64]) -> Self {
        let resource =
            |version: crate::graph::description::VersionId| description.versions[version.0 as usize].resource;
        let mut left = vec![0; description.resources.len()];
        let passes = description.passes.len();
        let nodes = passes + description.roots.len();
        let (mut first, mut used) = (Vec::with_capacity(nodes + 1), Vec::with_capacity(nodes * 2));
        first.push(0);
        for node in 0..nodes {
            let from = used.len();
            let mut add = |version| {
                let id: ResourceId = resource(version);
                if bytes[id.0 as usize] > 0 && !used[from..].contains(&id) {
                    left[id.0 as usize] += 1;
                    used.push(id);
                }
            };
            match node.checked_sub(passes) {
                _ if !is_live(node as Node) => {}
                None => description.uses_of(&description.passes[node]).iter().for_each(|used| add(used.version)),
                Some(root) => add(description.roots[root].version),
            }
            first.push(used.len() as u32);
        }
        for root in description.roots.iter().filter(|root| !root.read_back) {
            left[resource(root.version).0 as usize] += 1;
        }
        Self { bytes, first, used, left, alive: vec![false; description.resources.len()], ran: 0 }
    }

    /// Bytes that running a node frees, less those it takes.
    fn gain(&self, node: Node) -> i128 {
        let change = |id: &ResourceId| {
            let index = id.0 as usize;
            let bytes = i128::from(self.bytes[index]);
            let freed = if self.left[index] == 1 { bytes } else { 0 };
            freed - if self.alive[index] { 0 } else { bytes }
        };
        self.of(node).iter().map(change).sum()
    }

    fn of(&self, node: Node) -> &[ResourceId] {
        &self.used[self.first[node as usize] as usize..self.first[node as usize + 1] as usize]
    }

    /// Runs the nodes of an order that have not run yet.
    fn run(&mut self, order: &[Node]) {
        for &node in &order[self.ran..] {
            for id in &self.used[self.first[node as usize] as usize..self.first[node as usize + 1] as usize] {
                self.alive[id.0 as usize] = true;
                self.left[id.0 as usize] -= 1;
            }
        }
        self.ran = order.len();
    }
}
