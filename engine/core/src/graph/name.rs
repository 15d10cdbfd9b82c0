//! Names of passes and resources.

use std::borrow::Cow;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::ops::Deref;
use std::sync::OnceLock;

use rustc_hash::FxHashSet;
use smallvec::SmallVec;

/// Name of a pass or a resource: text, or text and a number for one of many (`("blur", 3)` is `blur 3`). It becomes one
/// text where somebody reads it: a frame that nobody looks into makes none.
#[derive(Clone, Default)]
pub struct Name {
    base: Cow<'static, str>,
    number: Option<u32>,
    /// Of one with a number.
    text: OnceLock<Box<str>>,
}

impl Name {
    /// As one text.
    pub fn as_str(&self) -> &str {
        self
    }

    /// Text and number, alike for names that read alike: `("blur", 3)` for `blur 3`.
    fn parts(&self) -> (&str, Option<u32>) {
        let base = &*self.base;
        if self.number.is_some() || !base.ends_with(|last: char| last.is_ascii_digit()) {
            return (base, self.number);
        }
        let split = base.rsplit_once(' ').filter(|(_, digits)| *digits == "0" || !digits.starts_with(['0', '+']));
        let number = split.and_then(|(text, digits)| Some((text, digits.parse().ok()?)));
        number.map_or((base, None), |(text, number)| (text, Some(number)))
    }
}

/// Whether no two names read alike. Names with numbers that ascend, as loops make them, are told apart without a look
/// at their text; the others are looked up.
pub(super) fn are_distinct<'a>(names: impl Iterator<Item = &'a Name> + Clone) -> bool {
    ascend(names.clone()) || {
        let mut known = FxHashSet::default();
        known.reserve(names.size_hint().0);
        names.into_iter().all(|name| known.insert(name.parts()))
    }
}

/// How many different texts are looked at for numbers that ascend.
const SERIES: usize = 8;

/// Whether it is plain to see that no two names read alike: numbers ascend behind each text, and names without a number
/// do not end in a digit.
fn ascend<'a>(names: impl Iterator<Item = &'a Name>) -> bool {
    let mut series: SmallVec<[(&str, u32); SERIES]> = SmallVec::new();
    let mut plain: FxHashSet<&str> = FxHashSet::default();
    for name in names {
        let base: &str = &name.base;
        let Some(number) = name.number else {
            if base.ends_with(|last: char| last.is_ascii_digit()) || !plain.insert(base) {
                return false;
            }
            continue;
        };
        match series.iter().position(|(known, _)| std::ptr::eq::<str>(*known, base)) {
            Some(place) if series[place].1 < number => series[place].1 = number,
            None if series.len() < SERIES && series.iter().all(|(known, _)| *known != base) => {
                series.push((base, number));
            }
            _ => return false,
        }
    }
    true
}

impl From<&str> for Name {
    fn from(text: &str) -> Self {
        String::from(text).into()
    }
}

impl From<&String> for Name {
    fn from(text: &String) -> Self {
        text.clone().into()
    }
}

impl From<String> for Name {
    fn from(text: String) -> Self {
        Self { base: Cow::Owned(text), ..Self::default() }
    }
}

impl From<(&'static str, u32)> for Name {
    fn from((text, number): (&'static str, u32)) -> Self {
        Self { base: Cow::Borrowed(text), number: Some(number), ..Self::default() }
    }
}

impl Deref for Name {
    type Target = str;

    fn deref(&self) -> &str {
        match self.number {
            None => &self.base,
            Some(number) => self.text.get_or_init(|| format!("{} {number}", self.base).into()),
        }
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.number {
            None => f.pad(&self.base),
            Some(_) => f.pad(self),
        }
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fmt::Debug::fmt(&**self, f)
    }
}

impl PartialEq for Name {
    fn eq(&self, other: &Self) -> bool {
        let same_text = || std::ptr::eq::<str>(&*self.base, &*other.base) || *self.base == *other.base;
        (self.number == other.number && same_text()) || self.parts() == other.parts()
    }
}

impl Eq for Name {}

impl PartialEq<str> for Name {
    fn eq(&self, other: &str) -> bool {
        **self == *other
    }
}

impl PartialEq<&str> for Name {
    fn eq(&self, other: &&str) -> bool {
        **self == **other
    }
}

impl PartialEq<String> for Name {
    fn eq(&self, other: &String) -> bool {
        **self == **other
    }
}

impl Hash for Name {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.parts().hash(state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_read_alike_are_equal() {
        let alike = [("blur", 3, "blur 3"), ("blur", 0, "blur 0"), ("a 1", 20, "a 1 20"), ("", 7, " 7")];
        for (base, number, text) in alike {
            assert_eq!(Name::from((base, number)), Name::from(text));
            assert_eq!(Name::from((base, number)).to_string(), text);
        }
        for (base, number, text) in
            [("blur", 3, "blur 03"), ("blur", 3, "blur +3"), ("blur", 3, "blur"), ("a", 1, "a1")]
        {
            assert_ne!(Name::from((base, number)), Name::from(text));
        }
        assert_eq!(Name::from("blur 99999999999"), Name::from(String::from("blur 99999999999")));
    }

    #[test]
    fn names_that_read_alike_are_found() {
        let (blur, text) = (|number| Name::from(("blur", number)), |text: &str| Name::from(text));
        for distinct in [
            vec![blur(0), blur(3), text("blur"), Name::from(("add", 0)), blur(4)],
            vec![blur(3), blur(0), text("blur 4"), text("blur 03")],
            (0..20).map(|number| text(&format!("pass {number}"))).collect(),
        ] {
            assert!(are_distinct(distinct.iter()), "{distinct:?}");
        }
        let other = Name { base: Cow::Owned("blur".into()), number: Some(5), text: OnceLock::new() };
        for alike in [
            vec![blur(0), blur(3), blur(3)],
            vec![blur(3), blur(4), blur(3)],
            vec![blur(3), text("blur 3")],
            vec![text("blur 3"), blur(3)],
            vec![text("blur"), blur(3), text("blur")],
            vec![blur(5), blur(6), other],
        ] {
            assert!(!are_distinct(alike.iter()), "{alike:?}");
        }
    }
}
