//! Every block must say `layout(scalar)`: checked in the text, where the line is known.

use crate::source::{ROOT, Tree};

/// A message for each block of each file that does not.
pub fn check(tree: &Tree) -> Vec<String> {
    tree.files.iter().flat_map(|(path, file)| check_file(path, &file.text)).collect()
}

fn check_file(path: &str, text: &str) -> Vec<String> {
    let code = without_comments(text);
    let mut problems = Vec::new();
    // A block is `qualifiers (uniform|buffer) Name { members } instance;`.
    for (open, _) in code.match_indices('{') {
        let start = code[..open].rfind([';', '{', '}']).map_or(0, |end| end + 1);
        let tokens: Vec<&str> = code[start..open]
            .split(|c: char| !c.is_alphanumeric() && c != '_')
            .filter(|token| !token.is_empty())
            .collect();
        let is_block = tokens.iter().any(|token| ["uniform", "buffer"].contains(token));
        if let Some(name) = tokens.last().filter(|_| is_block && !tokens.contains(&"scalar")) {
            let line = code[..open].matches('\n').count() + 1;
            problems
                .push(format!("{ROOT}/{path}:{line}: error: block {name}: say layout(scalar, …), as every block must"));
        }
    }
    problems
}

/// The text with comments and preprocessor lines blanked; lines stay where they are.
fn without_comments(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if c == '#' {
            directive(rest)
        } else {
            code.push(c);
            rest = &rest[c.len_utf8()..];
            continue;
        };
        code.extend(rest[..skipped].chars().filter(|c| *c == '\n'));
        rest = &rest[skipped..];
    }
    code
}

/// Length of a preprocessor line with its continuations.
fn directive(text: &str) -> usize {
    let mut end = 0;
    loop {
        end += text[end..].find('\n').unwrap_or(text.len() - end);
        if end == text.len() || !text[..end].ends_with('\\') {
            return end;
        }
        end += 1;
    }
}
