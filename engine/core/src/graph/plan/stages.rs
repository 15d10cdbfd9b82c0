//! Sets of single pipeline stages, and which of them a dependency has without naming them: its first scope has what
//! comes before its stages in their pipeline, its second scope what comes behind them.

use ash::vk::PipelineStageFlags2 as Stages;

use crate::graph::description::Access;

/// Stages in the order that the graphics pipeline goes through them, then those outside of it.
const STAGES: [Stages; COUNT] = [
    Stages::DRAW_INDIRECT,
    Stages::INDEX_INPUT,
    Stages::VERTEX_ATTRIBUTE_INPUT,
    Stages::VERTEX_SHADER,
    Stages::TESSELLATION_CONTROL_SHADER,
    Stages::TESSELLATION_EVALUATION_SHADER,
    Stages::GEOMETRY_SHADER,
    Stages::EARLY_FRAGMENT_TESTS,
    Stages::FRAGMENT_SHADER,
    Stages::LATE_FRAGMENT_TESTS,
    Stages::COLOR_ATTACHMENT_OUTPUT,
    Stages::COMPUTE_SHADER,
    Stages::COPY,
    Stages::BLIT,
    Stages::RESOLVE,
    Stages::CLEAR,
    Stages::HOST,
    // Anything else: never taken to be ordered.
    Stages::NONE,
];

/// How many there are.
pub(super) const COUNT: usize = 18;

/// Where the compute pipeline's own stage stands. Before it stand those of graphics; the first is of both.
const COMPUTE: usize = 11;
const GRAPHICS: Set = (1 << COMPUTE) - 1;
const TRANSFER: Set = 0b1111 << 12;
const HOST: Set = 1 << 16;

/// Stages as bits of their places above.
pub(super) type Set = u32;

/// The single stages that a mask stands for.
pub(super) fn set(stages: Stages) -> Set {
    if stages.contains(Stages::ALL_COMMANDS) {
        // The host runs no commands.
        return ((1 << COUNT) - 1) & !HOST;
    }
    let mut set = if stages.contains(Stages::ALL_TRANSFER) { TRANSFER } else { 0 };
    for bit in bits((stages & !Stages::ALL_TRANSFER).as_raw()) {
        set |= 1 << PLACES[bit.trailing_zeros() as usize];
    }
    set
}

/// By number of a stage's bit: its place above.
const PLACES: [u8; 64] = {
    let mut places = [COUNT as u8 - 1; 64];
    let mut place = 0;
    while place < COUNT - 1 {
        places[STAGES[place].as_raw().trailing_zeros() as usize] = place as u8;
        place += 1;
    }
    places
};

/// Whether scopes hold all of other scopes.
pub(super) fn holds(a: &Access, b: &Access) -> bool {
    set(b.stages) & !set(a.stages) == 0 && a.mask.contains(b.mask)
}

/// The places of a set, ascending.
pub(super) fn members(set: Set) -> impl Iterator<Item = usize> {
    bits(set.into()).map(|bit| bit.trailing_zeros() as usize)
}

/// Single bits, ascending.
pub(super) fn bits(mut mask: u64) -> impl Iterator<Item = u64> {
    std::iter::from_fn(move || {
        let bit = mask & mask.wrapping_neg();
        mask ^= bit;
        (bit != 0).then_some(bit)
    })
}

/// With the stages that come before them in the pipeline: the first scope of a dependency has them too.
pub(super) fn with_earlier(set: Set) -> Set {
    let graphics = match (set & GRAPHICS).checked_ilog2() {
        Some(last) => (2 << last) - 1,
        None => 0,
    };
    set | graphics | (set >> COMPUTE & 1)
}

/// With the stages that come after them in the pipeline: the second scope of a dependency has them too.
pub(super) fn with_later(set: Set) -> Set {
    let graphics = set & GRAPHICS;
    let first = graphics & graphics.wrapping_neg();
    set | (GRAPHICS & first.wrapping_neg()) | (set & 1) << COMPUTE
}

/// The fewest stages whose first scope, where no memory is asked for, is that of all of these.
pub(super) fn latest(stages: Stages) -> Stages {
    fewest(stages, with_earlier)
}

/// The fewest stages whose second scope, where no memory is asked for, is that of all of these.
pub(super) fn earliest(stages: Stages) -> Stages {
    fewest(stages, with_later)
}

/// Leaves out each stage that the others reach.
fn fewest(stages: Stages, reach: impl Fn(Set) -> Set) -> Stages {
    let raw = stages.as_raw();
    if raw.is_power_of_two() || stages.contains(Stages::ALL_COMMANDS) {
        return stages;
    }
    bits(raw).map(Stages::from_raw).fold(stages, |left, stage| {
        let others = left & !stage;
        if reach(set(others)) & set(stage) == set(stage) { others } else { left }
    })
}

/// The stage at a place.
pub(super) fn single(place: usize) -> Stages {
    STAGES.get(place).copied().unwrap_or_default()
}

/// Stages of both, each once.
pub(super) fn both(a: Stages, b: Stages) -> Stages {
    let all = a | b;
    if all.contains(Stages::ALL_TRANSFER) {
        return all & !(Stages::COPY | Stages::BLIT | Stages::RESOLVE | Stages::CLEAR);
    }
    all
}

/// One of these stages.
pub(super) fn any(stages: Stages) -> Stages {
    bits(stages.as_raw()).next().map_or(Stages::NONE, Stages::from_raw)
}

/// These stages without those of a set.
pub(super) fn without(stages: Stages, done: Set) -> Stages {
    bits(stages.as_raw())
        .map(Stages::from_raw)
        .filter(|&stage| set(stage) & !done != 0)
        .fold(Stages::NONE, |left, stage| left | stage)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scopes_hold_earlier_and_later_stages_of_a_pipeline() {
        let (vertex, fragment, compute) = (Stages::VERTEX_SHADER, Stages::FRAGMENT_SHADER, Stages::COMPUTE_SHADER);
        let tests = Stages::EARLY_FRAGMENT_TESTS | Stages::LATE_FRAGMENT_TESTS;
        assert_eq!(latest(vertex | fragment | compute), fragment | compute);
        assert_eq!(earliest(vertex | fragment | compute), vertex | compute);
        assert_eq!(latest(tests), Stages::LATE_FRAGMENT_TESTS);
        assert_eq!(earliest(tests), Stages::EARLY_FRAGMENT_TESTS);
        assert_eq!(latest(Stages::DRAW_INDIRECT | compute), compute);
        assert_eq!(earliest(Stages::DRAW_INDIRECT | compute | fragment), Stages::DRAW_INDIRECT);
        assert_eq!(latest(Stages::COPY | Stages::BLIT), Stages::COPY | Stages::BLIT);
        assert_eq!(latest(Stages::COPY | Stages::ALL_TRANSFER), Stages::ALL_TRANSFER);
        assert_eq!(latest(Stages::NONE), Stages::NONE);
        assert_eq!(with_earlier(set(Stages::COPY)), set(Stages::COPY));
        assert_eq!(with_later(set(Stages::COLOR_ATTACHMENT_OUTPUT)), set(Stages::COLOR_ATTACHMENT_OUTPUT));
    }

    #[test]
    fn sets_hold_single_stages() {
        assert_eq!(set(Stages::ALL_TRANSFER), set(Stages::COPY | Stages::BLIT | Stages::RESOLVE | Stages::CLEAR));
        assert_eq!(set(Stages::ALL_COMMANDS) & set(Stages::HOST), 0);
        assert_eq!(set(Stages::MESH_SHADER_EXT), 1 << (COUNT - 1));
        assert_eq!(
            without(Stages::ALL_TRANSFER | Stages::HOST, set(Stages::COPY)),
            Stages::ALL_TRANSFER | Stages::HOST
        );
        assert_eq!(without(Stages::COPY | Stages::HOST, set(Stages::ALL_TRANSFER)), Stages::HOST);
        assert_eq!(any(Stages::COPY | Stages::HOST), Stages::HOST);
        assert_eq!(any(Stages::NONE), Stages::NONE);
    }
}
