//! Pictures of voxels, for the pages of their techniques.

use glam::Vec3;
use shadowgraph::techniques::voxel::Voxels;
use shadowgraph::techniques::voxel::attributes::VoxelAttributes;

use crate::figures::Picture;

type Color = [f32; 3];

const NOTHING: Color = [0.02, 0.02, 0.03];
const STONE: Color = [0.75, 0.68, 0.6];
/// Pixels along a side of a voxel, of grids that are not fine.
const SCALE: u32 = 3;

/// What `name` is of: voxels from the front, which glTF has at the greatest z, lit from the upper left.
pub fn front(name: &str, voxels: &Voxels) -> Picture {
    lit(name, voxels, |_| STONE)
}

/// The same in any colours.
pub fn lit(name: &str, voxels: &Voxels, color: impl Fn([u32; 3]) -> Color) -> Picture {
    let depths = Depths::of(voxels);
    let picture = pixels(voxels, |x, y, line| {
        let z = depths.at(x, y)?;
        let slope = |other: Option<u32>| (z as f32 - other.unwrap_or(0) as f32).clamp(-3.0, 3.0);
        let (left, up) = (slope(depths.at(x.wrapping_sub(1), y)), slope(depths.at(x, y + 1)));
        let normal = Vec3::new(-left, up, 1.6).normalize();
        let lit = line * (0.15 + 0.85 * normal.dot(Vec3::new(-0.4, 0.6, 0.7).normalize()).max(0.0));
        Some(color([x, y, z]).map(|c| c * lit))
    });
    let [n, ..] = voxels.grid().size();
    Picture { caption: format!("{name}: {n}³ voxels from the front"), ..picture }
}

/// What surfaces are like: albedo, lit, and normals as colours.
pub fn attributes(name: &str, found: &VoxelAttributes) -> Picture {
    let albedo = |voxel| found.get(voxel).map_or([0.0; 3], |own| (own.albedo * 1.8).to_array());
    let normal = |voxel| found.get(voxel).map_or([0.0; 3], |own| (0.4 * own.normal + 0.4).to_array());
    let depths = Depths::of(found.voxels());
    let flat = pixels(found.voxels(), |x, y, line| Some(normal([x, y, depths.at(x, y)?]).map(|c| line * c)));
    let [n, ..] = found.voxels().grid().size();
    beside(
        [lit(name, found.voxels(), albedo), flat],
        format!("{name}: {n}³ voxels in their albedo, and their mean normals"),
    )
}

/// A slice of voxels across z.
pub fn cut(voxels: &Voxels, z: u32) -> Picture {
    pixels(voxels, |x, y, line| voxels.get([x, y, z]).then(|| STONE.map(|c| c * line)))
}

/// Two pictures of one height side by side.
pub fn beside([left, right]: [Picture; 2], caption: String) -> Picture {
    let gap = 4 * SCALE;
    let width = left.size[0] + gap + right.size[0];
    let height = left.size[1].min(right.size[1]);
    let mut all = Vec::new();
    for row in 0..height {
        let of = |picture: &Picture| {
            let first = (row * picture.size[0]) as usize;
            picture.pixels[first..first + picture.size[0] as usize].to_vec()
        };
        all.extend([of(&left), vec![NOTHING; gap as usize], of(&right)].concat());
    }
    Picture { size: [width, height], pixels: all, exposure: left.exposure, caption }
}

/// A pixel, or several, a voxel seen from the front: what `color` says of its x and y, and how bright lines between voxels
/// are. Rows and columns around all that is set are left out.
fn pixels(voxels: &Voxels, color: impl Fn(u32, u32, f32) -> Option<Color>) -> Picture {
    let [nx, ny, _] = voxels.grid().size();
    let scale = if nx > 300 { 1 } else { SCALE };
    let (mut first, mut last) = ([nx, ny], [0, 0]);
    for [x, y, _] in voxels.set() {
        (first, last) = ([first[0].min(x), first[1].min(y)], [last[0].max(x), last[1].max(y)]);
    }
    let margin = |least: u32, most: u32, n: u32| [least.saturating_sub(2), (most + 3).min(n)];
    let [left, right] = margin(first[0].min(last[0]), last[0], nx);
    let [bottom, top] = margin(first[1].min(last[1]), last[1], ny);
    let size = [scale * (right - left), scale * (top - bottom)];
    let mut pixels = Vec::new();
    for row in 0..size[1] {
        for column in 0..size[0] {
            let (x, y) = (left + column / scale, top - 1 - row / scale);
            let line = if scale > 1 && (column % scale == 0 || row % scale == 0) { 0.8 } else { 1.0 };
            pixels.push(color(x, y, line).unwrap_or(NOTHING));
        }
    }
    Picture { size, pixels, exposure: 1.0, caption: String::new() }
}

/// The greatest z of set voxels, by x and y.
struct Depths {
    size: [u32; 2],
    depths: Vec<Option<u32>>,
}

impl Depths {
    fn of(voxels: &Voxels) -> Self {
        let [nx, ny, _] = voxels.grid().size();
        let mut depths = vec![None; (nx * ny) as usize];
        voxels.set().for_each(|[x, y, z]| depths[(y * nx + x) as usize] = Some(z));
        Self { size: [nx, ny], depths }
    }

    fn at(&self, x: u32, y: u32) -> Option<u32> {
        let inside = x < self.size[0] && y < self.size[1];
        inside.then(|| self.depths[(y * self.size[0] + x) as usize]).flatten()
    }
}
