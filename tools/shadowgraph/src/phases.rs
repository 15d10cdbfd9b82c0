//! A stopwatch for what a command spends its time on.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

/// When the program began, by both clocks.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    instant: Instant,
    /// For a parent process, which cannot compare an [`Instant`].
    unix: f64,
}

impl Start {
    /// Now.
    pub fn now() -> Self {
        Self { instant: Instant::now(), unix: unix_seconds() }
    }
}

/// Seconds since 1970.
pub fn unix_seconds() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64())
}

/// Phases of one run, each with its time. A phase that is timed twice has the sum.
#[derive(Debug)]
pub struct Phases {
    start: Start,
    times: Vec<(&'static str, Duration)>,
}

/// What a run says to the process that measures it: one line of JSON.
#[derive(Debug, Serialize, Deserialize)]
pub struct Report {
    /// When `main` began, in seconds since 1970.
    pub began: f64,
    /// From there to the end, in seconds.
    pub total: f64,
    /// Name and seconds, in the order they began.
    pub phases: Vec<(String, f64)>,
}

impl Phases {
    /// No phase yet.
    pub fn new(start: Start) -> Self {
        Self { start, times: Vec::new() }
    }

    /// Times what `work` does.
    pub fn time<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let began = Instant::now();
        let result = work();
        self.add(name, began.elapsed());
        result
    }

    /// Adds to a phase.
    pub fn add(&mut self, name: &'static str, time: Duration) {
        match self.times.iter_mut().find(|(n, _)| *n == name) {
            Some((_, sum)) => *sum += time,
            None => self.times.push((name, time)),
        }
    }

    /// All so far.
    pub fn report(&self) -> Report {
        Report {
            began: self.start.unix,
            total: self.start.instant.elapsed().as_secs_f64(),
            phases: self.times.iter().map(|(name, time)| (name.to_string(), time.as_secs_f64())).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_add_up_in_order() {
        let mut phases = Phases::new(Start::now());
        phases.add("device", Duration::from_millis(20));
        phases.add("loading", Duration::from_millis(30));
        phases.add("device", Duration::from_millis(5));
        let value = phases.time("writing", || 7);
        assert_eq!(value, 7);
        let report = phases.report();
        let names: Vec<_> = report.phases.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["device", "loading", "writing"]);
        assert_eq!(report.phases[0].1, 0.025);
    }
}
