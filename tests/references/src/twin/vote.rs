//! Solids whose surfaces are not closed, by a vote of the three lines through each voxel's centre.
//!
//! - A line leaks where its crossings do not cancel out, or by the even-odd rule are odd in number.
//! - A voxel's lines say whether it is inside. The majority of those that do not leak decides; where these are at odds, or
//!   all leak, the majority of all three.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::voxel::rows;

/// What the lines of a grid say.
pub struct Voted {
    /// `[z][y][x]`.
    pub inside: Vec<bool>,
    /// Lines along x, y and z that leak.
    pub leaks: [usize; 3],
    /// Lines along x, y and z that pass an open edge so near that rounding decides whether they leak.
    pub uncertain: [usize; 3],
    /// Voxels on such a line, `[z][y][x]`.
    pub doubtful: Vec<bool>,
}

/// Asks all lines. `triangles` in grid coordinates; `near`: what rounding may do to them, in voxels.
pub fn vote(triangles: &[[DVec3; 3]], size: [u32; 3], even_odd: bool, near: f64) -> Voted {
    let says = |winding: i32| if even_odd { winding % 2 != 0 } else { winding != 0 };
    let open = open_edges(triangles);
    let count = size.iter().map(|&n| n as usize).product();
    let (mut votes, mut doubtful) = (vec![0; count], vec![false; count]);
    let (mut leaks, mut uncertain) = ([0; 3], [0; 3]);
    for axis in 0..3 {
        // Turned so that the axis comes first; `to` are the world's axes.
        let to = [axis, (axis + 1) % 3, (axis + 2) % 3];
        let turn = |p: &DVec3| DVec3::from(to.map(|axis| p[axis]));
        let turned: Vec<_> = triangles.iter().map(|corners| corners.each_ref().map(turn)).collect();
        let [nx, ny, nz] = to.map(|axis| size[axis] as usize);
        let (windings, sums) = rows(&turned, [nx, ny, nz].map(|n| n as u32));
        let mut doubts = vec![false; ny * nz];
        for edge in &open {
            mark(&mut doubts, [ny, nz], edge.map(|p| DVec2::new(p[to[1]], p[to[2]])), near);
        }
        leaks[axis] = sums.iter().filter(|&&sum| says(sum)).count();
        uncertain[axis] = doubts.iter().filter(|&&doubt| doubt).count();
        for (index, &winding) in windings.iter().enumerate() {
            let row = index / nx;
            let mut place = [0; 3];
            [place[to[0]], place[to[1]], place[to[2]]] = [index % nx, row % ny, row / ny];
            let own = (place[2] * size[1] as usize + place[1]) * size[0] as usize + place[0];
            let weight = if says(sums[row]) { 1 } else { 3 };
            votes[own] += if says(winding) { weight } else { -weight };
            doubtful[own] |= doubts[row];
        }
    }
    Voted { inside: votes.into_iter().map(|votes| votes > 0).collect(), leaks, uncertain, doubtful }
}

/// Edges that triangles do not share in opposite directions, as often as each.
fn open_edges(triangles: &[[DVec3; 3]]) -> Vec<[DVec3; 2]> {
    let key = |p: DVec3| p.to_array().map(|c| (c + 0.0).to_bits());
    let mut open: HashMap<_, ([DVec3; 2], i32)> = HashMap::new();
    for corners in triangles {
        for [a, b] in [0, 1, 2].map(|i| [corners[i], corners[(i + 1) % 3]]) {
            let (forwards, edge) = if key(a) < key(b) { (1, [a, b]) } else { (-1, [b, a]) };
            open.entry(edge.map(key)).or_insert((edge, 0)).1 += forwards;
        }
    }
    open.into_values().filter(|&(_, count)| count != 0).map(|(edge, _)| edge).collect()
}

/// Marks the lines that pass an edge nearer than `near`.
fn mark(lines: &mut [bool], [ny, nz]: [usize; 2], [a, b]: [DVec2; 2], near: f64) {
    let range = |axis: usize, n: usize| {
        let first = (a[axis].min(b[axis]) - near - 0.5).ceil().clamp(0.0, n as f64) as usize;
        first..(a[axis].max(b[axis]) + near + 0.5).floor().clamp(0.0, n as f64) as usize
    };
    for (z, y) in range(1, nz).flat_map(|z| range(0, ny).map(move |y| (z, y))) {
        let p = DVec2::new(y as f64, z as f64) + 0.5 - a;
        let edge = b - a;
        let along = if edge == DVec2::ZERO { 0.0 } else { (p.dot(edge) / edge.length_squared()).clamp(0.0, 1.0) };
        lines[z * ny + y] |= p.distance(edge * along) <= near;
    }
}
