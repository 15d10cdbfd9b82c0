//! The report as one HTML page, which fetches nothing.
//!
//! The page is the JSON form, and a script that draws it. Names never become markup: the JSON is written without the
//! characters that could end its element, and the script sets text only.

use super::Report;

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
const SCRIPT: &str = concat!(include_str!("page/diagram.js"), "\n", include_str!("page/page.js"));

/// The report as a self-contained HTML page: a diagram of the passes with a map of memory under it, search, and lists.
///
/// # Errors
/// As [`Report::json`].
pub fn html(report: &Report) -> serde_json::Result<String> {
    let report = for_script(&serde_json::to_string(report)?);
    // The report comes last: what its names hold is not taken for a place to fill.
    Ok(PAGE.replacen("{{style}}", STYLE, 1).replacen("{{script}}", SCRIPT, 1).replacen("{{report}}", &report, 1))
}

/// JSON that can stand in a `script` element: outside of strings it has none of these characters, and in strings each
/// may be written as an escape.
fn for_script(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for character in json.chars() {
        match character {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => out += &format!("\\u{:04x}", u32::from(character)),
            other => out.push(other),
        }
    }
    out
}
