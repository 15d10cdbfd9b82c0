//! Voxels by the processor alone, on all cores: each thread takes its share of the triangles and a grid of its own, and
//! the grids are put together at the end. Columns of bits run along z.

use std::thread;

use glam::{DVec2, DVec3};

use crate::sphere::Sphere;

/// Bits of a cube of voxels, 64 of a column a word: voxel (i, j, k) is bit k % 64 of word (j · size + i) · words + k / 64.
#[derive(Clone)]
pub struct Bits {
    size: usize,
    words: usize,
    bits: Vec<u64>,
}

impl Bits {
    fn new(size: usize) -> Self {
        let words = size.div_ceil(64);
        Self { size, words, bits: vec![0; size * size * words] }
    }

    fn word(&mut self, [i, j, k]: [usize; 3]) -> &mut u64 {
        &mut self.bits[(j * self.size + i) * self.words + k / 64]
    }

    pub fn count(&self) -> u64 {
        self.bits.iter().map(|word| u64::from(word.count_ones())).sum()
    }
}

/// Where the voxels are: the same cube as [`shadowgraph::techniques::voxel::Grid::around`] makes.
#[derive(Clone, Copy)]
pub struct Cube {
    pub min: DVec3,
    pub edge: f64,
    pub size: usize,
}

/// The corners of a triangle in voxels.
fn corners(sphere: &Sphere, triangle: &[u32; 3], cube: &Cube) -> [DVec3; 3] {
    triangle.map(|index| {
        let corner = sphere.corners[index as usize].map(f64::from);
        (DVec3::from(corner) - cube.min) / cube.edge
    })
}

/// Each thread's share of the triangles, into a grid of its own.
fn shares(sphere: &Sphere, cube: &Cube, draw: impl Fn(&mut Bits, [DVec3; 3]) + Sync) -> Vec<Bits> {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let share = sphere.triangles.len().div_ceil(threads).max(1);
    thread::scope(|scope| {
        let draw = &draw;
        let run = |triangles: &[[u32; 3]]| {
            let mut bits = Bits::new(cube.size);
            triangles.iter().for_each(|triangle| draw(&mut bits, corners(sphere, triangle, cube)));
            bits
        };
        let spawned: Vec<_> = sphere.triangles.chunks(share).map(|part| scope.spawn(move || run(part))).collect();
        spawned.into_iter().map(|thread| thread.join().expect("a thread panicked")).collect()
    })
}

/// Put together word by word, on all cores, column by column where `finish` wants.
fn together(parts: Vec<Bits>, join: fn(u64, u64) -> u64, finish: fn(&mut [u64])) -> Bits {
    let mut parts = parts.into_iter();
    let mut all = parts.next().expect("there is a thread");
    let rest: Vec<Bits> = parts.collect();
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let columns = (all.size * all.size).div_ceil(threads) * all.words;
    thread::scope(|scope| {
        for (share, bits) in all.bits.chunks_mut(columns).enumerate() {
            let rest = &rest;
            scope.spawn(move || {
                for part in rest {
                    let first = share * columns;
                    let from = &part.bits[first..first + bits.len()];
                    bits.iter_mut().zip(from).for_each(|(word, other)| *word = join(*word, *other));
                }
                bits.chunks_mut(rest.first().map_or(1, |part| part.words)).for_each(finish);
            });
        }
    });
    all
}

/// Whether a column's centre is inside a triangle seen along z, edges belonging to one of the two that share them.
fn covers(edges: &[(DVec2, DVec2); 3], at: DVec2) -> bool {
    edges.iter().all(|&(from, along)| {
        let side = along.perp_dot(at - from);
        side > 0.0 || (side == 0.0 && (along.y > 0.0 || (along.y == 0.0 && along.x < 0.0)))
    })
}

/// Voxels whose centres are inside: a bit where each column crosses a triangle, then XOR along the columns.
pub fn solid(sphere: &Sphere, cube: &Cube) -> Bits {
    let parts = shares(sphere, cube, |bits, [a, mut b, mut c]| {
        let size = bits.size as f64;
        let normal = (b - a).cross(c - a);
        if normal.z == 0.0 {
            return;
        }
        if normal.z < 0.0 {
            (b, c) = (c, b);
        }
        let [a2, b2, c2] = [a, b, c].map(DVec3::truncate);
        let edges = [(a2, b2 - a2), (b2, c2 - b2), (c2, a2 - c2)];
        let (least, most) = (a2.min(b2).min(c2), a2.max(b2).max(c2));
        let range = |least: f64, most: f64| {
            let [first, end] = [(least - 0.5).ceil(), (most - 0.5).floor() + 1.0];
            first.clamp(0.0, size) as usize..end.clamp(0.0, size) as usize
        };
        for j in range(least.y, most.y) {
            for i in range(least.x, most.x) {
                let at = DVec2::new(i as f64 + 0.5, j as f64 + 0.5);
                if covers(&edges, at) {
                    let depth = a.z - (normal.x * (at.x - a.x) + normal.y * (at.y - a.y)) / normal.z;
                    let k = (depth - 0.5).ceil().max(0.0) as usize;
                    if k < bits.size {
                        *bits.word([i, j, k]) ^= 1 << (k % 64);
                    }
                }
            }
        }
    });
    together(
        parts,
        |a, b| a ^ b,
        |column| {
            let mut before = 0;
            for word in column {
                let mut w = *word;
                for shift in [1, 2, 4, 8, 16, 32] {
                    w ^= w << shift;
                }
                *word = w ^ before;
                before = if *word >> 63 == 1 { !0 } else { 0 };
            }
        },
    )
}

/// Voxels that a triangle touches, by separating axes (Schwarz and Seidel 2010, with the plane's test on differences).
pub fn conservative(sphere: &Sphere, cube: &Cube) -> Bits {
    let parts = shares(sphere, cube, |bits, corners| {
        let size = bits.size as f64;
        let [a, b, c] = corners;
        let (least, most) = (a.min(b).min(c), a.max(b).max(c));
        let normal = (b - a).cross(c - a);
        // The corner of a box that is furthest along the normal, and the opposite one.
        let reach = DVec3::ONE * 0.5;
        let radius = normal.abs().dot(reach);
        let edges = [b - a, c - b, a - c];
        // Two-dimensional edges in the planes xy, yz and zx.
        let planes = [(0, 1, normal.z), (1, 2, normal.x), (2, 0, normal.y)];
        let lines: Vec<(usize, usize, f64, f64, f64)> = planes
            .iter()
            .flat_map(|&(u, v, facing)| {
                let sign = if facing >= 0.0 { 1.0 } else { -1.0 };
                (0..3).map(move |i| {
                    let (edge, from) = (edges[i], corners[i]);
                    let (nu, nv) = (-edge[v] * sign, edge[u] * sign);
                    let offset = -(nu * from[u] + nv * from[v]) + nu.max(0.0) + nv.max(0.0);
                    (u, v, nu, nv, offset)
                })
            })
            .collect();
        let range = |axis: usize| {
            let [first, end] = [least[axis].floor(), most[axis].floor() + 1.0];
            first.clamp(0.0, size) as usize..end.clamp(0.0, size) as usize
        };
        for j in range(1) {
            for i in range(0) {
                for k in range(2) {
                    let low = DVec3::new(i as f64, j as f64, k as f64);
                    let inside = normal.dot(low + reach - a).abs() <= radius
                        && lines.iter().all(|&(u, v, nu, nv, offset)| nu * low[u] + nv * low[v] + offset >= 0.0);
                    if inside {
                        *bits.word([i, j, k]) |= 1 << (k % 64);
                    }
                }
            }
        }
    });
    together(parts, |a, b| a | b, |_| {})
}
