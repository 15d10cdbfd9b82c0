//! Making a new technique from templates: its folders, its test, its page, its line in the registry.

use crate::failure::{Failure, Result};
use crate::workspace::{Workspace, make_folder, read, write};

/// The name of a technique.
#[derive(Debug, clap::Args)]
pub struct TechniqueName {
    /// The family: shadow, transparency, voxel, …
    pub family: String,
    /// The technique's name in its family, in `snake_case`.
    pub name: String,
}

const MODULE: &str = include_str!("../templates/mod.rs.txt");
const SHADER: &str = include_str!("../templates/shader.comp.txt");
const TEST: &str = include_str!("../templates/test.rs.txt");
const PAGE: &str = include_str!("../templates/page.md.txt");
const REGISTRY_LINE: &str = include_str!("../templates/registry_line.txt");

const REGISTRY: &str = "engine/src/techniques/registry.rs";
const FAMILIES: &str = "engine/src/techniques/mod.rs";
const SUMMARY: &str = "docs/src/SUMMARY.md";

/// Makes a technique, or nothing at all where its name is taken.
pub fn new_technique(workspace: &Workspace, name: &TechniqueName) -> Result<()> {
    check_name("family", &name.family)?;
    check_name("name", &name.name)?;
    let files = new_files(name);
    for (path, _) in &files {
        if workspace.path(path).exists() {
            return Err(Failure::Usage(format!("{}/{} is there already: {path}", name.family, name.name)));
        }
    }
    // All texts are made before the first is written.
    let edits = edited_files(workspace, name)?;
    for (path, text) in files.into_iter().chain(edits) {
        let path = workspace.path(&path);
        make_folder(path.parent().unwrap_or(&workspace.root))?;
        write(&path, &text)?;
        println!("{}", path.display());
    }
    Ok(())
}

/// The files that come from templates, by path.
fn new_files(name: &TechniqueName) -> Vec<(String, String)> {
    let TechniqueName { family, name: technique } = name;
    vec![
        (format!("engine/src/techniques/{family}/{technique}/mod.rs"), fill(MODULE, name)),
        (format!("shaders_glsl/{family}/{technique}/{technique}.comp"), fill(SHADER, name)),
        (format!("tests/tests/technique_{family}_{technique}.rs"), fill(TEST, name)),
        (format!("docs/src/techniques/{family}/{technique}.md"), fill(PAGE, name)),
    ]
}

/// The files that get a line, by path.
fn edited_files(workspace: &Workspace, name: &TechniqueName) -> Result<Vec<(String, String)>> {
    let TechniqueName { family, name: technique } = name;
    let family_module = format!("engine/src/techniques/{family}/mod.rs");
    let family_text = if workspace.path(&family_module).exists() {
        read(&workspace.path(&family_module))?
    } else {
        format!("//! Techniques of the family `{family}`.\n\n")
    };
    let edit = |path: &str, insert: &dyn Fn(&str) -> Option<String>| {
        let text = insert(&read(&workspace.path(path))?)
            .ok_or_else(|| Failure::Failed(format!("{path} has no place for a new technique: see the others in it")))?;
        Ok((path.to_owned(), text))
    };
    Ok(vec![
        (family_module.clone(), insert_module(&family_text, technique)),
        edit(FAMILIES, &|text| Some(insert_module(text, family)))?,
        edit(REGISTRY, &|text| insert_registration(text, name))?,
        edit(SUMMARY, &|text| Some(insert_page(text, name)))?,
    ])
}

/// A template with its blanks filled.
fn fill(template: &str, name: &TechniqueName) -> String {
    template
        .replace("{{family}}", &name.family)
        .replace("{{name}}", &name.name)
        .replace("{{Name}}", &camel_case(&name.name))
        .replace("{{title}}", &title(&name.name))
}

/// `percentage_closer` → `PercentageCloser`.
fn camel_case(name: &str) -> String {
    name.split('_').map(capitalised).collect()
}

/// `percentage_closer` → `Percentage closer`.
fn title(name: &str) -> String {
    capitalised(&name.replace('_', " "))
}

fn capitalised(word: &str) -> String {
    let mut characters = word.chars();
    characters.next().map(|first| first.to_ascii_uppercase()).into_iter().chain(characters).collect()
}

/// Names are `snake_case`, since they name folders and modules.
fn check_name(what: &str, name: &str) -> Result<()> {
    let is_word = |word: &str| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
    let is_snake_case = name.starts_with(|c: char| c.is_ascii_lowercase()) && name.split('_').all(is_word);
    if !is_snake_case || KEYWORDS.contains(&name) {
        return Err(Failure::Usage(format!(
            "the {what} {name:?} cannot name a module: use snake_case, such as shadow or percentage_closer"
        )));
    }
    Ok(())
}

const KEYWORDS: &[&str] = &[
    "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "crate", "do", "dyn", "else",
    "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop", "macro", "match", "mod",
    "move", "mut", "override", "priv", "pub", "ref", "registry", "return", "self", "static", "struct", "super",
    "trait", "true", "try", "type", "typeof", "unsafe", "unsized", "use", "virtual", "where", "while", "yield",
];

/// Adds `pub mod name;` among its like, in order, where it is missing.
fn insert_module(text: &str, name: &str) -> String {
    let line = format!("pub mod {name};");
    insert_sorted(text, &line, |line| line.starts_with("pub mod ") && line.ends_with(';'))
}

/// Adds the page's line to the table of contents, in order.
fn insert_page(text: &str, name: &TechniqueName) -> String {
    let TechniqueName { family, name } = name;
    let line = format!("- [{family}/{name}](techniques/{family}/{name}.md)");
    insert_sorted(text, &line, |line| line.starts_with("- [") && line.contains("](techniques/"))
}

/// Adds `line` before the first line of its kind that is greater, after the last of its kind, or at the end.
fn insert_sorted(text: &str, line: &str, is_of_kind: impl Fn(&str) -> bool) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    if lines.contains(&line) {
        return text.to_owned();
    }
    let kind = lines.iter().enumerate().filter(|(_, other)| is_of_kind(other));
    let greater = kind.clone().find(|(_, other)| **other > line).map(|(index, _)| index);
    let place = greater.or_else(|| kind.last().map(|(index, _)| index + 1)).unwrap_or(lines.len());
    lines.insert(place, line);
    lines.join("\n") + "\n"
}

/// Adds the technique to the registry's list, ordered by family and name; `None` where there is no list.
fn insert_registration(text: &str, name: &TechniqueName) -> Option<String> {
    let lines: Vec<&str> = text.lines().collect();
    let first = lines.iter().position(|line| line.contains("&[Technique] = &["))? + 1;
    let last = first + lines[first..].iter().position(|line| line.trim() == "];")?;
    let new = (name.family.as_str(), name.name.as_str());
    // An entry may take several lines; it begins where `Technique {` stands.
    let begins = (first..last).filter(|&index| lines[index].trim_start().starts_with("Technique {"));
    let greater = begins.clone().zip(begins.skip(1).chain([last])).find(|&(begin, end)| {
        let entry = lines[begin..end].join(" ");
        field(&entry, "family").zip(field(&entry, "name")).is_some_and(|entry| entry > new)
    });
    let place = greater.map_or(last, |(begin, _)| begin);
    let mut lines: Vec<String> = lines.into_iter().map(str::to_owned).collect();
    lines.insert(place, fill(REGISTRY_LINE, name).trim_end().to_owned());
    Some(lines.join("\n") + "\n")
}

/// The text of `key: "text"`.
fn field<'a>(entry: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = entry.split_once(&format!("{key}: \""))?;
    rest.split('"').next()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::fs;

    fn name(family: &str, name: &str) -> TechniqueName {
        TechniqueName { family: family.to_owned(), name: name.to_owned() }
    }

    const LIST: &str = "//! Doc.\npub static TECHNIQUES: &[Technique] = &[\n    \
        Technique { family: \"shadow\", name: \"cascaded\" },\n    Technique {\n        family: \"shadow\",\n        \
        name: \"spot\",\n    },\n    Technique { family: \"surface\", name: \"gbuffer\" },\n];\n";

    /// The families and names of a registry's text, in order.
    fn registered(text: &str) -> Vec<(String, String)> {
        let joined = text.replace('\n', " ");
        let entries = joined.split("Technique {").skip(1);
        entries.map(|entry| (field(entry, "family").unwrap().into(), field(entry, "name").unwrap().into())).collect()
    }

    #[test]
    fn names_are_snake_case() {
        for good in ["shadow", "percentage_closer", "cascades4"] {
            assert!(check_name("name", good).is_ok(), "{good}");
        }
        for bad in ["", "Shadow", "4cascades", "a__b", "_a", "a_", "a-b", "../a", "a/b", "mod", "ä"] {
            let failure = check_name("name", bad).unwrap_err();
            assert_eq!(failure.exit_code(), 2, "{bad}");
        }
    }

    #[test]
    fn registrations_are_sorted_by_family_and_name() {
        for (family, technique, place) in
            [("depth", "prepass", 0), ("shadow", "moment", 1), ("shadow", "variance", 2), ("voxel", "solid", 3)]
        {
            let text = insert_registration(LIST, &name(family, technique)).unwrap();
            let names = registered(&text);
            assert_eq!(names.len(), 4, "{text}");
            assert_eq!(names[place], (family.to_owned(), technique.to_owned()), "{text}");
            assert!(text.ends_with("];\n"), "{text}");
        }
    }

    #[test]
    fn a_registry_without_a_list_is_left_alone() {
        assert_eq!(insert_registration("pub mod shadow;\n", &name("a", "b")), None);
    }

    #[test]
    fn modules_are_inserted_once_and_in_order() {
        let text = "//! Doc.\n\npub mod cascaded;\npub mod spot;\n\nuse x;\n";
        let with = insert_module(text, "moment");
        assert_eq!(with, "//! Doc.\n\npub mod cascaded;\npub mod moment;\npub mod spot;\n\nuse x;\n");
        assert_eq!(insert_module(&with, "moment"), with);
        let last = insert_module(text, "variance");
        assert_eq!(last, "//! Doc.\n\npub mod cascaded;\npub mod spot;\npub mod variance;\n\nuse x;\n");
    }

    #[test]
    fn the_first_page_goes_to_the_end() {
        let text = insert_page("# Techniques\n\n", &name("shadow", "spot"));
        assert_eq!(text, "# Techniques\n\n- [shadow/spot](techniques/shadow/spot.md)\n");
    }

    #[test]
    fn templates_leave_no_blank() {
        for (path, text) in new_files(&name("shadow", "percentage_closer")) {
            assert!(!text.contains("{{"), "{path}: {text}");
            assert!(text.len() > 100, "{path}: {text}");
        }
    }

    /// A checkout with the files that a new technique edits.
    fn checkout(folder: &str) -> Workspace {
        let root = std::env::temp_dir().join(format!("shadowgraph-xtask-{}-{folder}", std::process::id()));
        let _ = fs::remove_dir_all(&root);
        for (path, text) in [(REGISTRY, LIST), (FAMILIES, "pub mod shadow;\n"), (SUMMARY, "# Techniques\n\n")] {
            make_folder(root.join(path).parent().unwrap()).unwrap();
            fs::write(root.join(path), text).unwrap();
        }
        Workspace { root }
    }

    #[test]
    fn a_technique_is_made_once() {
        let workspace = checkout("once");
        new_technique(&workspace, &name("voxel", "solid")).unwrap();
        for (path, _) in new_files(&name("voxel", "solid")) {
            assert!(workspace.path(&path).is_file(), "{path}");
        }
        assert_eq!(read(&workspace.path(FAMILIES)).unwrap(), "pub mod shadow;\npub mod voxel;\n");
        assert!(read(&workspace.path("engine/src/techniques/voxel/mod.rs")).unwrap().contains("pub mod solid;"));
        assert!(read(&workspace.path(SUMMARY)).unwrap().contains("(techniques/voxel/solid.md)"));

        let before = read(&workspace.path(REGISTRY)).unwrap();
        let failure = new_technique(&workspace, &name("voxel", "solid")).unwrap_err();
        assert_eq!(failure.exit_code(), 2);
        assert!(failure.to_string().contains("voxel/solid is there already"), "{failure}");
        assert_eq!(read(&workspace.path(REGISTRY)).unwrap(), before);
        fs::remove_dir_all(&workspace.root).unwrap();
    }

    #[test]
    fn nothing_is_written_where_the_registry_cannot_be_read() {
        let workspace = checkout("nothing");
        fs::write(workspace.path(REGISTRY), "no list").unwrap();
        assert!(new_technique(&workspace, &name("voxel", "solid")).is_err());
        assert!(!workspace.path("engine/src/techniques/voxel").exists());
        fs::remove_dir_all(&workspace.root).unwrap();
    }
}
