//! How long passes take on the device.

use crate::Result;
use crate::gpu::{Commands, Feature, Gpu, QueryKind, QueryPool};
use crate::graph::record;

/// How long a pass took.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// Name of the pass.
    pub name: String,
    /// Seconds on the device.
    pub seconds: f64,
}

/// A timestamp before the first step and one after each, where the device has them: a software driver waits at each.
#[derive(Default)]
pub(super) struct Timer {
    pool: Option<QueryPool>,
}

impl Timer {
    pub(super) fn new(gpu: &Gpu, steps: usize) -> Result<Self> {
        if steps == 0 || !gpu.caps().has(Feature::Timestamps) {
            return Ok(Self { pool: None });
        }
        let pool = gpu.query_pool("pass times", QueryKind::Timestamp, steps as u32 + 1)?;
        Ok(Self { pool: Some(pool) })
    }

    pub(super) fn reset(&self) {
        self.pool.iter().for_each(QueryPool::reset);
    }

    /// Before the step of this number.
    pub(super) fn mark(&self, device: &ash::Device, commands: &Commands, index: usize) {
        if let Some(pool) = &self.pool {
            record::timestamp(device, commands, pool, index as u32);
        }
    }

    pub(super) fn times(&self, name: impl Fn(usize) -> String) -> Result<Vec<PassTime>> {
        let Some(pool) = &self.pool else { return Ok(Vec::new()) };
        let marks = pool.nanoseconds()?;
        let time = |(i, marks): (usize, &[Option<f64>])| match marks {
            [Some(start), Some(end)] => Some(PassTime { name: name(i), seconds: (end - start).max(0.0) * 1e-9 }),
            _ => None,
        };
        Ok(marks.windows(2).enumerate().filter_map(time).collect())
    }
}
