//! Answers that were found before, for questions that are asked again and again.

use std::hash::{BuildHasher, Hash};

use rustc_hash::FxBuildHasher;

/// How many answers are kept: a new one takes the place of an old one.
const KEPT: usize = 32;

/// A few answers by what was asked.
pub(super) struct Memo<K, V>([Option<(K, V)>; KEPT]);

impl<K: Copy + Eq + Hash, V: Copy> Memo<K, V> {
    pub(super) fn new() -> Self {
        Self([None; KEPT])
    }

    /// The answer: the kept one, or what `find` finds, which is kept where it says so.
    pub(super) fn get(&mut self, key: K, find: impl FnOnce() -> (V, bool)) -> V {
        let place = &mut self.0[FxBuildHasher.hash_one(key) as usize % KEPT];
        match place {
            Some((known, value)) if *known == key => *value,
            _ => {
                let (value, keep) = find();
                if keep {
                    *place = Some((key, value));
                }
                value
            }
        }
    }
}
