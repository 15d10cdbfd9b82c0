//! What passes ask the device to count.

use ash::vk;

use super::Executed;
use crate::gpu::{Commands, Feature, Gpu, QueryKind, QueryPool};
use crate::graph::description::PassId;
use crate::graph::record;
use crate::{Error, Result};

/// What a pass asks the device to count.
#[derive(Clone, Copy)]
pub(in crate::graph) struct Asked {
    pub(in crate::graph) pass: PassId,
    pub(in crate::graph) kind: QueryKind,
}

/// What the device has counted over a pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassCount {
    /// Name of the pass.
    pub pass: String,
    /// What was counted.
    pub counts: Counts,
}

/// What was counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Counts {
    /// Samples that passed all tests, over all draws.
    Samples(u64),
    /// Counters of the pipeline.
    Statistics(Vec<(vk::QueryPipelineStatisticFlags, u64)>),
}

/// The queries of a frame.
#[derive(Default)]
pub(super) struct Queries {
    pools: Vec<(Asked, String, QueryPool)>,
}

impl Queries {
    /// Of the passes that run.
    pub(super) fn new(gpu: &Gpu, asked: &[Asked], name: impl Fn(PassId) -> Option<String>) -> Result<Self> {
        let mut pools = Vec::new();
        for asked in asked {
            let Some(pass) = name(asked.pass) else { continue };
            if asked.kind == QueryKind::Occlusion {
                gpu.caps().require(&format!("pass `{pass}`"), &[Feature::OcclusionQueryPrecise])?;
            }
            let pool = gpu.query_pool(&format!("counts of {pass}"), asked.kind, 1)?;
            pools.push((*asked, pass, pool));
        }
        Ok(Self { pools })
    }

    pub(super) fn reset(&self) {
        self.pools.iter().for_each(|(.., pool)| pool.reset());
    }

    pub(super) fn begin(&self, device: &ash::Device, commands: &Commands, pass: PassId) {
        for (asked, _, pool) in self.pools.iter().filter(|(asked, ..)| asked.pass == pass) {
            record::begin_query(device, commands, pool, asked.kind == QueryKind::Occlusion);
        }
    }

    pub(super) fn end(&self, device: &ash::Device, commands: &Commands, pass: PassId) {
        for (.., pool) in self.pools.iter().rev().filter(|(asked, ..)| asked.pass == pass) {
            record::end_query(device, commands, pool);
        }
    }

    /// Once the device is done.
    pub(super) fn counts(&self) -> Result<Vec<PassCount>> {
        let count = |(asked, pass, pool): &(Asked, String, QueryPool)| {
            let values = pool.results()?.into_iter().next().flatten().unwrap_or_default();
            let counts = match asked.kind {
                QueryKind::Statistics(counters) => {
                    let bits = (0..32).map(|bit| vk::QueryPipelineStatisticFlags::from_raw(1 << bit));
                    Counts::Statistics(bits.filter(|bit| counters.contains(*bit)).zip(values).collect())
                }
                _ => Counts::Samples(values.first().copied().unwrap_or(0)),
            };
            Ok(PassCount { pass: pass.clone(), counts })
        };
        self.pools.iter().map(count).collect()
    }
}

impl Executed {
    /// Samples that passed all tests in a pass that counts them.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the pass did not run, or did not count them.
    pub fn samples(&self, pass: &str) -> Result<u64> {
        let found = self.counts.iter().find_map(|count| match count.counts {
            Counts::Samples(samples) if count.pass == pass => Some(samples),
            _ => None,
        });
        found.ok_or_else(|| self.nothing_counted(pass, "samples"))
    }

    /// A counter of the pipeline over a pass that counts it.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the pass did not run, or did not count it.
    pub fn statistic(&self, pass: &str, counter: vk::QueryPipelineStatisticFlags) -> Result<u64> {
        let mut counts = self.counts.iter().filter(|count| count.pass == pass);
        let found = counts.find_map(|count| match &count.counts {
            Counts::Statistics(all) => all.iter().find(|(known, _)| *known == counter).map(|(_, value)| *value),
            Counts::Samples(_) => None,
        });
        found.ok_or_else(|| self.nothing_counted(pass, &format!("{counter:?}")))
    }

    fn nothing_counted(&self, pass: &str, what: &str) -> Error {
        let known: Vec<_> = self.counts.iter().map(|count| count.pass.as_str()).collect();
        let known =
            if known.is_empty() { "no pass counts".into() } else { format!("these count: {}", known.join(", ")) };
        Error::invalid(format!("{what} of pass `{pass}`"), format!("were not counted; {known}"))
    }
}
