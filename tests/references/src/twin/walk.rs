//! Which voxels a segment passes, in whole numbers.
//!
//! - Ends are given in parts of a voxel, [`PARTS`] an axis; coordinates in voxels are cut off to parts.
//! - A voxel is half open: it holds its lower faces. A segment, ends included, passes a voxel where a point of it is in there.
//! - What a ray marcher is asked: whether a set voxel is passed other than those that hold the two ends.

use glam::Vec3;
use shadowgraph::techniques::voxel::Grid;

/// Of a voxel, along an axis.
pub const PARTS: i64 = 4096;

/// A segment within a grid, in parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Where it begins.
    pub from: [i64; 3],
    /// Where it ends.
    pub to: [i64; 3],
}

/// Where a plane is met on the way from one end to the other: `.0 / .1`, the latter positive.
type Place = (i128, i128);

fn is_before(a: Place, b: Place) -> bool {
    a.0 * b.1 < b.0 * a.1
}

impl Segment {
    /// Whether it passes a voxel, by definition: some place on the way is in it on every axis.
    pub fn passes(&self, voxel: [i64; 3]) -> bool {
        // On every axis the place is at or behind `low`, and before or at `high`, as `closed` says of each.
        let (mut low, mut low_closed): (Place, bool) = ((0, 1), true);
        let (mut high, mut high_closed): (Place, bool) = ((1, 1), true);
        for ((from, to), voxel) in self.from.into_iter().zip(self.to).zip(voxel) {
            let way = to - from;
            let [lower, upper] = [voxel * PARTS, (voxel + 1) * PARTS];
            if way == 0 {
                if from < lower || from >= upper {
                    return false;
                }
                continue;
            }
            let at = |plane: i64| (i128::from((plane - from) * way.signum()), i128::from(way.abs()));
            // Upwards the lower face is in the voxel; downwards it is the last of it.
            let (enter, leave, enters_closed) =
                if way > 0 { (at(lower), at(upper), true) } else { (at(upper), at(lower), false) };
            if !is_before(enter, low) {
                low_closed = enters_closed && (low_closed || is_before(low, enter));
                low = enter;
            }
            if !is_before(high, leave) {
                high_closed = !enters_closed && (high_closed || is_before(leave, high));
                high = leave;
            }
        }
        is_before(low, high) || (!is_before(high, low) && low_closed && high_closed)
    }

    /// All voxels it passes, in order.
    pub fn passed(&self) -> Vec<[i64; 3]> {
        // Planes on the way. At one place, those that are met upwards come first and together, for what they bound holds
        // them; then those met downwards.
        let mut planes: Vec<(Place, bool, usize)> = Vec::new();
        let mut voxel = self.from.map(|part| part.div_euclid(PARTS));
        for (axis, (from, to)) in self.from.into_iter().zip(self.to).enumerate() {
            let (way, last) = (to - from, to.div_euclid(PARTS));
            let met = |plane: i64| (i128::from((plane * PARTS - from) * way.signum()), i128::from(way.abs()));
            if way > 0 {
                planes.extend((from.div_euclid(PARTS) + 1..=last).map(|plane| (met(plane), false, axis)));
            } else {
                planes.extend((last + 1..=from.div_euclid(PARTS)).map(|plane| (met(plane), true, axis)));
            }
        }
        planes.sort_by(|a, b| (a.0.0 * b.0.1).cmp(&(b.0.0 * a.0.1)).then(a.1.cmp(&b.1)));
        let mut passed = vec![voxel];
        for together in planes.chunk_by(|a, b| !is_before(a.0, b.0) && a.1 == b.1) {
            for &(_, downwards, axis) in together {
                voxel[axis] += if downwards { -1 } else { 1 };
            }
            passed.push(voxel);
        }
        passed
    }
}

/// The part of a segment in world space that is in a grid; `None` where none is. In single precision, as a device has it.
fn within(grid: &Grid, [origin, end]: [Vec3; 2]) -> Option<Segment> {
    let size = grid.size().map(|n| n as f32);
    let [from, to] = [origin, end].map(|p| (p - grid.min()) / grid.edge());
    let way = to - from;
    let reach = way.abs().element_sum() + from.abs().element_sum();
    if !reach.is_finite() || reach >= 1e30 {
        return None;
    }
    let (mut first, mut last) = (0.0_f32, 1.0_f32);
    for axis in 0..3 {
        if way[axis] == 0.0 {
            if from[axis] < 0.0 || from[axis] >= size[axis] {
                return None;
            }
        } else {
            let [a, b] = [-from[axis] / way[axis], (size[axis] - from[axis]) / way[axis]];
            (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
        }
    }
    if first > last {
        return None;
    }
    let parts =
        |p: Vec3| [0, 1, 2].map(|axis| (p[axis] * PARTS as f32).clamp(0.0, size[axis] * PARTS as f32 - 1.0) as i64);
    let from_part = if first > 0.0 { from + way * first } else { from };
    let to_part = if last < 1.0 { from + way * last } else { to };
    Some(Segment { from: parts(from_part), to: parts(to_part) })
}

/// Whether a set voxel lies between two points in world space, other than those that hold them.
pub fn is_blocked(grid: &Grid, is_set: impl Fn([u32; 3]) -> bool, ends: [Vec3; 2]) -> bool {
    let Some(segment) = within(grid, ends) else { return false };
    let holds = |point: Vec3, part: [i64; 3]| {
        let p = (point - grid.min()) / grid.edge();
        let inside = (0..3).all(|axis| p[axis] >= 0.0 && p[axis] < grid.size()[axis] as f32);
        inside.then(|| part.map(|part| part / PARTS))
    };
    let own = [holds(ends[0], segment.from), holds(ends[1], segment.to)];
    segment.passed().into_iter().any(|voxel| !own.contains(&Some(voxel)) && is_set(voxel.map(|i| i as u32)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Coordinates on planes, a part beside them, and in between, so that segments run through edges and corners.
    fn coordinate() -> impl Strategy<Value = i64> {
        (0..6_i64, prop_oneof![Just(0), Just(1), Just(PARTS - 1), Just(PARTS / 2), 0..PARTS])
            .prop_map(|(voxel, part)| voxel * PARTS + part)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn what_is_passed_is_what_the_definition_says(
            from in [coordinate(), coordinate(), coordinate()],
            to in [coordinate(), coordinate(), coordinate()],
        ) {
            let segment = Segment { from, to };
            let passed = segment.passed();
            let mut found = 0;
            for index in 0..216 {
                let voxel = [index % 6, index / 6 % 6, index / 36];
                prop_assert_eq!(passed.contains(&voxel), segment.passes(voxel), "{:?}", voxel);
                found += usize::from(segment.passes(voxel));
            }
            prop_assert_eq!(found, passed.len());
            let mut back = Segment { from: to, to: from }.passed();
            back.reverse();
            prop_assert_eq!(passed, back);
        }
    }
}
