//! `bench`: measures how long things take.

mod abuffer;
mod capture;
mod graph;
mod rays;
mod voxelize;
mod write;

use std::time::Duration;

use clap::ValueEnum;
use serde::Serialize;

use crate::cli::{BenchArguments, BenchName};
use crate::failure::{Failure, Result};
use crate::output::print;

/// One figure.
#[derive(Debug, Serialize)]
pub struct Measurement {
    /// Which benchmark.
    pub bench: &'static str,
    /// Which of its cases.
    pub case: String,
    /// What was measured.
    pub metric: String,
    /// The figure.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// Runs one benchmark, or all, and prints each figure as it comes.
pub fn run(arguments: &BenchArguments) -> Result<()> {
    let mut tell = |measurement: Measurement| print(line(&measurement, arguments.json)?);
    for &name in BenchName::value_variants() {
        if arguments.name.is_none_or(|wanted| wanted == name) {
            match name {
                BenchName::Abuffer => abuffer::run(arguments, &mut tell)?,
                BenchName::Capture => capture::run(arguments, &mut tell)?,
                BenchName::Graph => graph::run(arguments, &mut tell)?,
                BenchName::Write => write::run(arguments, &mut tell)?,
                BenchName::Voxelize => voxelize::run(arguments, &mut tell)?,
            }
        }
    }
    Ok(())
}

impl BenchArguments {
    /// Whether a case is asked for.
    fn wants(&self, case: &str) -> bool {
        case.contains(&self.case)
    }
}

fn line(measurement: &Measurement, json: bool) -> Result<String> {
    if json {
        return serde_json::to_string(measurement).map_err(Failure::failed);
    }
    let Measurement { bench, case, metric, value, unit } = measurement;
    Ok(format!("{bench:<8} {case:<12} {metric:<24} {value:>10.3} {unit}"))
}

/// The middle one, or the mean of the two in the middle; 0 of nothing.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => (values[n / 2 - 1] + values[n / 2]) / 2.0,
    }
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(vec![]), 0.0);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 3.0, 2.0]), 2.5);
    }

    #[test]
    fn json_has_the_five_fields_in_order() {
        let measurement =
            Measurement { bench: "capture", case: "warm".into(), metric: "total".into(), value: 1.5, unit: "ms" };
        let json = r#"{"bench":"capture","case":"warm","metric":"total","value":1.5,"unit":"ms"}"#;
        assert_eq!(line(&measurement, true).unwrap(), json);
        assert!(line(&measurement, false).unwrap().ends_with("1.500 ms"));
    }
}
