//! The chain, once a tool.

mod by_hand;
mod shadowgraph;
mod vk_graph;
mod vulkano_taskgraph;
mod wgpu;

use crate::measure::{Chain, Result};

/// A tool in one mode.
pub struct Case {
    pub name: &'static str,
    pub open: fn(passes: u32) -> Result<Box<dyn Chain>>,
}

pub const CASES: &[Case] = &[
    Case { name: "by hand, sets cached", open: |passes| Ok(Box::new(by_hand::ByHand::new(passes, false)?)) },
    Case { name: "by hand, sets each frame", open: |passes| Ok(Box::new(by_hand::ByHand::new(passes, true)?)) },
    Case { name: "shadowgraph, prepared", open: |passes| Ok(Box::new(shadowgraph::Prepared::new(passes)?)) },
    Case {
        name: "shadowgraph, described anew",
        open: |passes| Ok(Box::new(shadowgraph::Rebuilt::new(passes, false)?)),
    },
    Case { name: "shadowgraph, rebuilt", open: |passes| Ok(Box::new(shadowgraph::Rebuilt::new(passes, true)?)) },
    Case {
        name: "vulkano-taskgraph, compiled once",
        open: |passes| Ok(Box::new(vulkano_taskgraph::VulkanoTaskgraph::new(passes, false)?)),
    },
    Case {
        name: "vulkano-taskgraph, rebuilt",
        open: |passes| Ok(Box::new(vulkano_taskgraph::VulkanoTaskgraph::new(passes, true)?)),
    },
    Case { name: "wgpu, one pass", open: |passes| Ok(Box::new(wgpu::Wgpu::new(passes, true)?)) },
    Case { name: "wgpu, a pass each", open: |passes| Ok(Box::new(wgpu::Wgpu::new(passes, false)?)) },
    Case { name: "vk-graph, pool with room", open: |passes| Ok(Box::new(vk_graph::VkGraph::new(passes, false)?)) },
    Case { name: "vk-graph, two images by hand", open: |passes| Ok(Box::new(vk_graph::VkGraph::new(passes, true)?)) },
];
