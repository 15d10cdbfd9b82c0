//! Adaptive transparency over the A-buffer's sorted lists.

use crate::graph::{Graph, ImageHandle};
use crate::scene::View;
use crate::techniques::transparency::OrderIndependent;
use crate::techniques::transparency::abuffer::{ABuffer, NodeFormat, SortedLists};
use crate::techniques::transparency::adaptive::Adaptive;
use crate::techniques::transparency::fragments::Fragments;

/// The two, connected.
#[derive(Clone, Copy, Debug)]
pub struct AdaptiveLists {
    /// What is made of the lists.
    pub adaptive: Adaptive,
    /// As [`ABuffer::exponent`].
    pub exponent: i32,
    /// As [`ABuffer::memory`].
    pub memory: u64,
}

impl OrderIndependent for AdaptiveLists {
    fn composite<'f>(
        &self,
        graph: &mut Graph<'f>,
        view: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> ImageHandle {
        let Self { adaptive, exponent, memory } = *self;
        let abuffer = ABuffer { format: NodeFormat::CompactTinted, exponent, memory, ..ABuffer::default() };
        let SortedLists { nodes, spans } = abuffer.sort(graph, "adaptive", depth, fragments, adaptive.most_layers());
        adaptive.record(graph, view, (&nodes, &spans), abuffer.unit(), color)
    }
}
