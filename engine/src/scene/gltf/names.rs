//! Names that occur once.

use std::collections::{HashMap, HashSet};

/// Hands out every name once: the second `lamp` becomes `lamp_2`.
#[derive(Default)]
pub struct Names {
    used: HashSet<String>,
    next: HashMap<String, u64>,
}

impl Names {
    /// `wanted` itself where it is free, with a number where it is not.
    pub fn unique(&mut self, wanted: &str) -> String {
        if self.used.insert(wanted.to_owned()) {
            return wanted.to_owned();
        }
        let next = self.next.entry(wanted.to_owned()).or_insert(2);
        loop {
            let name = format!("{wanted}_{next}");
            *next += 1;
            if self.used.insert(name.clone()) {
                return name;
            }
        }
    }
}

/// The first name that is not empty, without control characters.
pub fn first_name<'a>(choices: impl IntoIterator<Item = Option<&'a String>>, otherwise: &str) -> String {
    let name = choices.into_iter().flatten().map(|name| clean(name)).find(|name| !name.is_empty());
    name.unwrap_or_else(|| otherwise.to_owned())
}

/// A light's name becomes part of layer names, where a dot has a meaning and length is limited: 255 bytes to a channel's.
pub fn layer_name(name: &str) -> String {
    const MOST: usize = 64;
    let end = (0..=MOST.min(name.len())).rev().find(|&end| name.is_char_boundary(end)).unwrap_or(0);
    name[..end].replace('.', "_")
}

fn clean(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).collect::<String>().trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_never_meets_a_given_name() {
        let mut names = Names::default();
        let given = ["lamp", "lamp_2", "lamp", "lamp", "lamp_2"].map(|name| names.unique(name));
        assert_eq!(given, ["lamp", "lamp_2", "lamp_3", "lamp_4", "lamp_2_2"]);
    }

    #[test]
    fn light_names_have_no_dots() {
        assert_eq!(layer_name("lamp.001.n"), "lamp_001_n");
    }
}
