//! Timestamps, occlusion queries, pipeline statistics.

use ash::vk;

use super::Gpu;
use crate::Result;

/// What queries count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum QueryKind {
    /// Ticks of the device; see [`QueryPool::nanoseconds`].
    Timestamp,
    /// Samples that passed; exact where [`super::Feature::OcclusionQueryPrecise`] is there and the query was begun
    /// with `PRECISE`, else 0 or not 0.
    Occlusion,
    /// Counters of the pipeline, one value a bit in the order of the bits
    /// ([`super::Feature::PipelineStatistics`]).
    Statistics(vk::QueryPipelineStatisticFlags),
}

/// A set of queries.
#[derive(Clone)]
pub struct QueryPool {}

impl QueryPool {
    /// The Vulkan handle.
    pub fn raw(&self) -> vk::QueryPool {
        unimplemented!()
    }

    /// Number of queries.
    pub fn len(&self) -> u32 {
        unimplemented!()
    }

    /// Whether it has no queries: never.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Values a query: 1, but for statistics.
    pub fn values(&self) -> usize {
        unimplemented!()
    }

    /// Forgets all results, from the host. The device must not be using the pool. Done once at its making.
    pub fn reset(&self) {
        unimplemented!()
    }

    /// Results, a query each; `None` where it has none yet. Does not wait.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`], [`crate::Error::Vulkan`].
    pub fn results(&self) -> Result<Vec<Option<Vec<u64>>>> {
        unimplemented!()
    }

    /// Timestamps in nanoseconds since an arbitrary moment, `None` where not written.
    ///
    /// # Errors
    /// As [`QueryPool::results`]; [`crate::Error::Invalid`] for a pool that holds none.
    pub fn nanoseconds(&self) -> Result<Vec<Option<f64>>> {
        unimplemented!()
    }
}

impl Gpu {
    /// Makes a set of queries.
    ///
    /// # Errors
    /// [`crate::Error::Missing`] where the device lacks the kind; [`crate::Error::Vulkan`].
    pub fn query_pool(&self, _name: &str, _kind: QueryKind, _count: u32) -> Result<QueryPool> {
        unimplemented!()
    }
}
