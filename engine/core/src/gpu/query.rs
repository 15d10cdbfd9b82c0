//! Timestamps, occlusion queries, pipeline statistics.

use std::sync::Arc;

use ash::vk;

use super::device::{Device, Garbage};
use super::{Feature, Gpu};
use crate::{Error, Result};

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
pub struct QueryPool(Arc<Inner>);

struct Inner {
    device: Arc<Device>,
    id: u64,
    name: String,
    kind: QueryKind,
    count: u32,
    pool: vk::QueryPool,
}

impl QueryPool {
    /// The Vulkan handle.
    pub fn raw(&self) -> vk::QueryPool {
        self.0.pool
    }

    /// What it counts.
    pub fn kind(&self) -> QueryKind {
        self.0.kind
    }

    /// Number of queries.
    pub fn len(&self) -> u32 {
        self.0.count
    }

    /// Whether it has no queries: never.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Values a query: 1, but for statistics.
    pub fn values(&self) -> usize {
        match self.0.kind {
            QueryKind::Statistics(counters) => counters.as_raw().count_ones() as usize,
            _ => 1,
        }
    }

    /// Forgets all results, from the host. The device must not be using the pool. Done once at its making.
    pub fn reset(&self) {
        // SAFETY: a live pool; host resets are on.
        unsafe { self.0.device.raw.reset_query_pool(self.0.pool, 0, self.0.count) };
    }

    /// Results, a query each; `None` where it has none yet. Does not wait.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`], [`crate::Error::Vulkan`].
    pub fn results(&self) -> Result<Vec<Option<Vec<u64>>>> {
        // Each query gives its values and a word that says whether they are there.
        let stride = self.values() + 1;
        let mut words = vec![0u64; stride * self.0.count as usize];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WITH_AVAILABILITY;
        // The C function, since the wrapper's element type fixes the stride.
        let call = self.0.device.raw.fp_v1_0().get_query_pool_results;
        // SAFETY: a live pool, a range of it, and memory of the stated size and stride.
        let answer = unsafe {
            call(
                self.0.device.raw.handle(),
                self.0.pool,
                0,
                self.0.count,
                size_of_val(&words[..]),
                words.as_mut_ptr().cast(),
                (stride * 8) as u64,
                flags,
            )
        };
        match answer {
            vk::Result::SUCCESS | vk::Result::NOT_READY => {}
            e => return Err(self.0.device.error("vkGetQueryPoolResults", &self.0.name, e)),
        }
        let one = |w: &[u64]| w.split_last().and_then(|(&there, values)| (there != 0).then(|| values.to_vec()));
        Ok(words.chunks_exact(stride).map(one).collect())
    }

    /// Timestamps in nanoseconds since an arbitrary moment, `None` where not written.
    ///
    /// # Errors
    /// As [`QueryPool::results`]; [`crate::Error::Invalid`] for a pool that holds none.
    pub fn nanoseconds(&self) -> Result<Vec<Option<f64>>> {
        if self.0.kind != QueryKind::Timestamp {
            return Err(Error::invalid(format!("query pool {:?}", self.0.name), "it holds no timestamps"));
        }
        let caps = &self.0.device.caps;
        let bits = caps.queue_families.get(caps.queue_family as usize).map_or(64, |f| f.timestamp_bits);
        let mask = u64::MAX.checked_shr(64u32.saturating_sub(bits)).unwrap_or(0);
        let period = f64::from(caps.limits.timestamp_period);
        Ok(self.results()?.into_iter().map(|r| r.map(|v| (v[0] & mask) as f64 * period)).collect())
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        self.device.forget(self.id);
        self.device.defer(Garbage::QueryPool(self.pool));
    }
}

impl Gpu {
    /// Makes a set of queries.
    ///
    /// # Errors
    /// [`crate::Error::Missing`] where the device lacks the kind; [`crate::Error::Invalid`] for none;
    /// [`crate::Error::Vulkan`].
    pub fn query_pool(&self, name: &str, kind: QueryKind, count: u32) -> Result<QueryPool> {
        let device = &self.device;
        let who = format!("query pool {name:?}");
        let mut info = vk::QueryPoolCreateInfo::default().query_count(count);
        match kind {
            QueryKind::Timestamp => {
                device.caps.require(&who, &[Feature::Timestamps])?;
                info = info.query_type(vk::QueryType::TIMESTAMP);
            }
            QueryKind::Occlusion => info = info.query_type(vk::QueryType::OCCLUSION),
            QueryKind::Statistics(counters) => {
                device.caps.require(&who, &[Feature::PipelineStatistics])?;
                info = info.query_type(vk::QueryType::PIPELINE_STATISTICS).pipeline_statistics(counters);
            }
        }
        if count == 0 || kind == QueryKind::Statistics(vk::QueryPipelineStatisticFlags::empty()) {
            return Err(Error::invalid(who, "it needs at least one query and one counter"));
        }
        // SAFETY: a valid structure; the kind's feature is on.
        let pool = unsafe { device.raw.create_query_pool(&info, None) };
        let pool = pool.map_err(|e| device.error("vkCreateQueryPool", name, e))?;
        device.name(pool, name);
        let made = QueryPool(Arc::new(Inner {
            id: device.register("query pool", name),
            device: device.clone(),
            name: name.into(),
            kind,
            count,
            pool,
        }));
        made.reset();
        Ok(made)
    }
}
