//! Random graphs against the hazard checker.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use shadowgraph::graph::plan::plan;
use shadowgraph::graph::report::text;
use shadowgraph_tests::hazard::{Recipe, check, recipes};

/// Random graphs, in the default run and with `SHADOWGRAPH_LONG=1`.
fn cases(few: u32, many: u32) -> Config {
    let long = std::env::var_os("SHADOWGRAPH_LONG").is_some_and(|value| value != "0");
    Config { cases: if long { many } else { few }, failure_persistence: None, ..Config::default() }
}

/// Plans each random graph and holds the plan against the rules.
fn sweep(config: Config, passes: usize) {
    let judge = |recipe: Recipe| {
        let (description, device) = (recipe.description(), recipe.device());
        let plan = plan(&description, &device).map_err(|errors| TestCaseError::fail(errors.to_string()))?;
        let wrong = check(&description, &plan, &device);
        prop_assert!(wrong.is_empty(), "\n{}\n{}", wrong.join("\n"), text(&description, &plan));
        Ok(())
    };
    TestRunner::new(config).run(&recipes(passes), judge).unwrap();
}

#[test]
fn random_graphs_have_no_hazard() {
    sweep(cases(2_000, 100_000), 24);
}

#[test]
fn large_random_graphs_have_no_hazard() {
    sweep(cases(20, 1_000), 200);
}
