//! Every technique of the registry has all that the house asks of one, and nothing lies about that is not in it.
#![allow(missing_docs, clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use shadowgraph::shader::generated;
use shadowgraph::techniques::registry::{TECHNIQUES, Technique};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// What a technique lacks, a sentence each.
fn lacks(technique: &Technique) -> Vec<String> {
    let Technique { family, name, summary } = technique;
    let root = root();
    let mut lacks = Vec::new();
    let mut ask = |there: bool, what: String| {
        if !there {
            lacks.push(format!("{family}/{name} lacks {what}"));
        }
    };
    ask(!summary.is_empty(), "a summary".into());
    let host = format!("engine/src/techniques/{family}/{name}/mod.rs");
    ask(root.join(&host).is_file(), host);
    let shaders = format!("{family}/{name}/");
    let any = generated::ALL.iter().any(|shader| shader.file.starts_with(&shaders));
    ask(any, format!("a shader in shaders_glsl/{shaders}"));

    let test = format!("tests/tests/technique_{family}_{name}.rs");
    let text = fs::read_to_string(root.join(&test)).unwrap_or_default();
    ask(!text.is_empty(), test.clone());
    for what in ["agrees_with_its_reference", "with_a_seeded_mistake_is_caught"] {
        ask(
            text.contains(&format!("fn {family}_{name}_{what}()")),
            format!("the test {family}_{name}_{what} in {test}"),
        );
    }

    let page = format!("docs/src/techniques/{family}/{name}.md");
    let text = fs::read_to_string(root.join(&page)).unwrap_or_default();
    ask(!text.is_empty(), page.clone());
    let figures = text.split_once("<!-- figures:").and_then(|(_, rest)| rest.split_once("<!-- end of figures -->"));
    let rows = figures.map_or(0, |(block, _)| block.lines().filter(|line| line.starts_with('|')).count());
    ask(rows > 2, format!("figures in {page}: run its test with SHADOWGRAPH_FIGURES=write"));
    let contents = fs::read_to_string(root.join("docs/src/SUMMARY.md")).unwrap();
    ask(contents.contains(&format!("techniques/{family}/{name}.md")), "a line in docs/src/SUMMARY.md".into());
    lacks
}

#[test]
fn every_technique_is_whole() {
    let lacks: Vec<_> = TECHNIQUES.iter().flat_map(lacks).collect();
    assert!(!TECHNIQUES.is_empty());
    assert!(lacks.is_empty(), "{}", lacks.join("\n"));
}

#[test]
fn a_technique_that_is_not_there_lacks_everything() {
    let nothing = Technique { family: "no", name: "thing", summary: "" };
    assert_eq!(lacks(&nothing).len(), 9, "{:?}", lacks(&nothing));
}

#[test]
fn every_folder_of_a_technique_is_in_the_registry() {
    let known: BTreeSet<_> = TECHNIQUES.iter().map(|t| format!("{}/{}", t.family, t.name)).collect();
    assert_eq!(known.len(), TECHNIQUES.len(), "a technique is in the registry twice");
    let folders = |path: &Path| -> Vec<String> {
        let entries = fs::read_dir(path).unwrap().map(|entry| entry.unwrap());
        let folders = entries.filter(|entry| entry.path().is_dir());
        folders.map(|entry| entry.file_name().into_string().unwrap()).collect()
    };
    let mut found = 0;
    for base in ["engine/src/techniques", "shaders_glsl"] {
        for family in folders(&root().join(base)).iter().filter(|family| *family != "common") {
            for name in folders(&root().join(base).join(family)) {
                found += 1;
                let technique = format!("{family}/{name}");
                assert!(known.contains(&technique), "{base}/{technique} is not in the registry");
            }
        }
    }
    assert!(found >= 2 * TECHNIQUES.len(), "{found} folders for {} techniques", TECHNIQUES.len());
    assert!(TECHNIQUES.is_sorted_by_key(|t| (t.family, t.name)), "the registry is not sorted");
}
