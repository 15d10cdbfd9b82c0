//! Figures in the pages of the techniques: written by their tests, so that what a page says was measured.
//!
//! With `SHADOWGRAPH_FIGURES=write` in the environment a test replaces what its page has between the markers. Else it
//! checks that the page names the figures it has just found, so that none goes stale unseen. Values may differ from
//! driver to driver; names may not.

use std::fs;
use std::path::{Path, PathBuf};

use shadowgraph::capture::{PngOptions, write_png};
use shadowgraph::gpu::Gpu;

use crate::compare::{Comparison, Tally};
use crate::harness;
use crate::plot::LogPlot;

/// A row of a page.
#[derive(Clone, Debug)]
pub struct Figure {
    /// What was compared with what.
    pub what: String,
    /// What was found.
    pub value: String,
    /// What must be.
    pub bound: String,
}

/// A picture of a page: linear RGB, rows from the top.
pub struct Picture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Linear Rec. 709.
    pub pixels: Vec<[f32; 3]>,
    /// Factor before the tone curve.
    pub exposure: f32,
    /// What it shows.
    pub caption: String,
}

/// A comparison with what is asked of it.
pub struct Check {
    /// The errors.
    pub comparison: Comparison,
    /// Share of the compared values that must agree.
    pub least_agreement: f64,
    /// Share of the values that may be left out.
    pub most_left_out: f64,
}

impl Check {
    /// See [`Comparison::check`].
    pub fn new(comparison: Comparison, least_agreement: f64, most_left_out: f64) -> Self {
        Self { comparison, least_agreement, most_left_out }
    }

    /// Fails where the comparison does.
    pub fn demand(&self) -> Figure {
        self.figure(&self.comparison.check(self.least_agreement, self.most_left_out))
    }

    /// Whether the comparison fails: a seeded mistake makes it.
    pub fn fails(&self) -> bool {
        let tally = self.comparison.tally();
        let failure = tally.failure(self.least_agreement, self.most_left_out);
        println!("{tally}: {}", failure.as_deref().unwrap_or("passes"));
        tally.compared > 0 && failure.is_some()
    }

    fn figure(&self, tally: &Tally) -> Figure {
        let percent = |share: f64, digits: usize| format!("{:.digits$} %", share * 100.0);
        let mut value = format!("{} of {}", percent(tally.agreement(), 3), tally.compared);
        let mut bound = format!("{} within {}", percent(self.least_agreement, 1), number(tally.tolerance));
        if !tally.left_out.is_empty() {
            value += &format!(", {} left out", percent(tally.left_out_share(), 2));
            bound += &format!(", at most {} left out", percent(self.most_left_out, 0));
        }
        Figure { what: tally.name.clone(), value, bound }
    }
}

/// Demands every check, and gives their figures.
pub fn demand(checks: &[Check]) -> Vec<Figure> {
    checks.iter().map(Check::demand).collect()
}

fn number(value: f64) -> String {
    if value == 0.0 || (0.01..1e4).contains(&value) { format!("{value}") } else { format!("{value:e}") }
}

/// Prints the figures of a technique, and writes them into its page or checks that they are there: see the module.
pub fn publish(gpu: &Gpu, family: &str, name: &str, figures: &[Figure], picture: Option<&Picture>) {
    assert!(!figures.is_empty(), "{family}/{name} has no figures");
    for Figure { what, value, bound } in figures {
        println!("{family}/{name}: {what}: {value} (must be: {bound})");
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src/techniques").join(family);
    let page = folder.join(format!("{name}.md"));
    let by = format!("technique_{family}_{name}");
    let text = fs::read_to_string(&page).unwrap_or_else(|error| panic!("cannot read {}: {error}", page.display()));
    if harness::writes_figures() {
        assert!(harness::scenes().is_some(), "without the folder of scenes, rows of the pages would be lost");
        let picture = picture.map(|picture| (link(name, picture), write_picture(&folder, name, picture)));
        let block = block(&gpu.caps().title(), figures, picture.as_ref().map(|(link, _)| link.as_str()));
        let text = replaced(&text, &by, &block).unwrap_or_else(|why| panic!("{}: {why}", page.display()));
        fs::write(&page, text).unwrap_or_else(|error| panic!("cannot write {}: {error}", page.display()));
    } else if let Some(why) = stale(&text, &by, figures, harness::scenes().is_some()) {
        panic!("{}: {why}; run this test with SHADOWGRAPH_FIGURES=write", page.display());
    }
}

/// As [`publish`], into any page of the book, below `docs/src`, after the marker that says they are `written by` this
/// test. `source`: what the figures were found on.
pub fn publish_page(page: &str, test: &str, source: &str, figures: &[Figure]) {
    for Figure { what, value, bound } in figures {
        println!("{page}: {what}: {value} (must be: {bound})");
    }
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src").join(page);
    let text = fs::read_to_string(&page).unwrap_or_else(|error| panic!("cannot read {}: {error}", page.display()));
    if harness::writes_figures() {
        let text = replaced(&text, test, &block(source, figures, None))
            .unwrap_or_else(|why| panic!("{}: {why}", page.display()));
        fs::write(&page, text).unwrap_or_else(|error| panic!("cannot write {}: {error}", page.display()));
    } else if let Some(why) = stale(&text, test, figures, harness::scenes().is_some()) {
        panic!("{}: {why}; run this test with SHADOWGRAPH_FIGURES=write", page.display());
    }
}

/// With `SHADOWGRAPH_FIGURES=write`, writes a picture into the book: `NAME.png` in a folder below `docs/src`.
pub fn publish_picture(folder: &str, name: &str, picture: &Picture) {
    if harness::writes_figures() {
        write_picture(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src").join(folder), name, picture);
    }
}

/// With `SHADOWGRAPH_FIGURES=write`, writes a plot into the book: `NAME.svg` in a folder below `docs/src`.
pub fn publish_plot(folder: &str, name: &str, plot: &LogPlot) {
    if harness::writes_figures() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src").join(folder).join(format!("{name}.svg"));
        fs::write(&path, plot.svg()).unwrap_or_else(|error| panic!("cannot write {}: {error}", path.display()));
    }
}

fn link(name: &str, picture: &Picture) -> String {
    format!("![{}]({name}.png)\n\n*{}*\n\n", picture.caption, picture.caption)
}

fn write_picture(folder: &Path, name: &str, picture: &Picture) -> PathBuf {
    let path = folder.join(format!("{name}.png"));
    let pixels: Vec<_> = picture.pixels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
    let options = PngOptions { exposure: picture.exposure, ..PngOptions::default() };
    write_png(&path, picture.size, &pixels, &options).unwrap_or_else(|error| panic!("{error}"));
    path
}

fn block(device: &str, figures: &[Figure], link: Option<&str>) -> String {
    let mut block =
        format!("{}Found on {device}.\n\n| Compared | Agrees | Must |\n| --- | --- | --- |\n", link.unwrap_or(""));
    for Figure { what, value, bound } in figures {
        block += &format!("| {what} | {value} | {bound} |\n");
    }
    block
}

/// Where the figures that a test writes into a page begin and end.
fn span(page: &str, by: &str) -> Result<(usize, usize), String> {
    let marker = format!("<!-- figures: written by {by} -->\n");
    let start = page.find(&marker).ok_or_else(|| format!("no marker `{}`", marker.trim_end()))? + marker.len();
    let end = page[start..].find("<!-- end of figures -->").ok_or("no marker `<!-- end of figures -->`")?;
    Ok((start, start + end))
}

fn replaced(page: &str, by: &str, block: &str) -> Result<String, String> {
    let (start, end) = span(page, by)?;
    Ok(format!("{}\n{block}\n{}", &page[..start], &page[end..]))
}

/// How a page differs from the figures found. Without the folder of scenes some are not found: with it, `all` are.
fn stale(page: &str, by: &str, figures: &[Figure], all: bool) -> Option<String> {
    let (start, end) = match span(page, by) {
        Ok(span) => span,
        Err(why) => return Some(why),
    };
    let rows = page[start..end].lines().filter_map(|line| line.strip_prefix("| ")?.split(" | ").next()).skip(2);
    let rows: Vec<_> = rows.collect();
    if let Some(missing) = figures.iter().find(|figure| !rows.contains(&figure.what.as_str())) {
        return Some(format!("no figure `{}`", missing.what));
    }
    let known = |row: &&str| figures.iter().any(|figure| figure.what == **row);
    rows.iter().find(|row| all && !known(row)).map(|row| format!("figure `{row}` is found no more"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "# A page\n\n<!-- figures: written by x -->\n<!-- end of figures -->\nrest\n";

    fn figures(names: &[&str]) -> Vec<Figure> {
        names.iter().map(|n| Figure { what: n.to_string(), value: "1".into(), bound: "2".into() }).collect()
    }

    #[test]
    fn figures_replace_those_before_and_what_is_stale_is_found() {
        let first = replaced(PAGE, "x", &block("a device", &figures(&["old"]), None)).unwrap();
        let page =
            replaced(&first, "x", &block("a device", &figures(&["one", "two"]), Some("![a](b.png)\n\n"))).unwrap();
        assert!(page.contains("| one | 1 | 2 |\n| two | 1 | 2 |") && !page.contains("old"), "{page}");
        assert!(page.starts_with("# A page") && page.ends_with("rest\n") && page.contains("![a](b.png)"));
        assert_eq!(stale(&page, "x", &figures(&["one", "two"]), true), None);
        assert_eq!(stale(&page, "x", &figures(&["two"]), false), None);
        assert!(stale(&page, "x", &figures(&["two"]), true).unwrap().contains("`one` is found no more"));
        assert!(stale(&page, "x", &figures(&["two", "three"]), false).unwrap().contains("no figure `three`"));
        assert!(stale("nothing", "x", &figures(&["two"]), false).unwrap().contains("no marker"));
    }
}
