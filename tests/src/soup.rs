//! Soups of blended triangles whose vertices lie on the grid of 1/256 pixel.

use glam::{DVec3, DVec4, Mat4, Vec3, Vec4};
use shadowgraph::scene::{AlphaMode, Material, Scene, View};

use crate::compare::Comparison;
use crate::figures::Check;
pub use crate::kitchen::{Found, Kitchen, beside_exact};
use crate::tiny;
use crate::twin::layers::{self, Covered, Fragment, GRID, Seen, close_call, composite, composite_samples};

/// What lies behind everything, premultiplied.
pub const BACKGROUND: [f32; 4] = [0.1, 0.4, 0.2, 1.0];

/// Depth of the opaque rectangle.
pub const OPAQUE: f32 = 0.25;

/// How near in depth two fragments may be before rounding may decide.
pub const DEPTH_MARGIN: f64 = 1e-6;

/// Triangles over a picture, before a background whose left half has an opaque rectangle.
#[derive(Clone)]
pub struct Soup {
    /// For reports.
    pub name: String,
    /// A power of two each: then vertices stay on the grid.
    pub size: [u32; 2],
    /// Their keys are their numbers; colours are not premultiplied.
    pub triangles: Vec<Flat>,
    /// Triangles an object.
    pub per_object: usize,
    /// What the objects are made of, in turn.
    pub materials: Vec<Kind>,
    /// How far to the right the opaque rectangle leans over the picture's height, in 1/256 pixel.
    pub lean: i64,
}

/// What a triangle's colour means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Not premultiplied.
    Blend,
    /// Not premultiplied; most light that it does not hide passes and is multiplied by the colour.
    Glass,
    /// Premultiplied.
    Premultiplied,
    /// Not premultiplied, and added.
    Add,
}

/// Of glass.
const TRANSMISSION: f32 = 0.75;

/// A triangle of one colour.
#[derive(Clone, Copy, Debug)]
pub struct Flat {
    /// In 1/256 pixel.
    pub corners: [[i64; 2]; 3],
    /// At the vertices.
    pub depth: [f32; 3],
    /// Not premultiplied.
    pub color: [f32; 4],
}

/// Numbers from a seed (Marsaglia 2003, "Xorshift RNGs").
pub struct Random(u64);

impl Random {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// Below `end`.
    pub fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % end
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f32 {
        self.below(1 << 24) as f32 / (1 << 24) as f32
    }

    /// A colour whose alpha is a whole number of 255ths.
    pub fn color(&mut self) -> [f32; 4] {
        [self.unit(), self.unit(), self.unit(), (1 + self.below(255)) as f32 / 255.0]
    }

    /// In any order.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        (1..items.len()).rev().for_each(|i| items.swap(i, self.below(i as u64 + 1) as usize));
    }
}

impl Soup {
    /// Triangles anywhere, at slopes of depth, and `wide` rectangles over nearly the whole picture at a depth each.
    pub fn random(seed: u64, size: [u32; 2], triangles: usize, wide: usize) -> Self {
        let mut random = Random::new(seed);
        let far = size.map(|side| i64::from(side) * GRID);
        let mut all = Vec::new();
        for _ in 0..triangles {
            let corners = [(); 3].map(|()| far.map(|far| random.below(far as u64 + 1) as i64));
            let depth = [(); 3].map(|()| 0.05 + 0.9 * random.unit());
            all.push(Flat { corners, depth, color: random.color() });
        }
        for _ in 0..wide {
            let mut inset = || random.below(2 * GRID as u64) as i64;
            let [left, top, right, bottom] = [inset(), inset(), far[0] - inset(), far[1] - inset()];
            let (depth, color) = (0.05 + 0.9 * random.unit(), random.color());
            all.extend(rectangle([left, top], [right, bottom], [depth; 4], color));
        }
        random.shuffle(&mut all);
        let name = format!("soup of {triangles} triangles and {wide} rectangles");
        Self { name, size, triangles: all, per_object: 1, materials: vec![Kind::Blend], lean: 0 }
    }

    /// Triangles for pictures.
    pub fn shown() -> Self {
        Self::random(31, [512, 256], 24, 0)
    }

    /// Planes that cut through each other, in both directions.
    pub fn interpenetrating(size: [u32; 2], planes: usize) -> Self {
        let mut random = Random::new(7);
        let far = size.map(|side| i64::from(side) * GRID);
        let mut all = Vec::new();
        for plane in 0..planes {
            let (a, b) = (0.3 + 0.6 * random.unit(), 0.3 + 0.6 * random.unit());
            let depth = if plane % 2 == 0 { [a, b, a, b] } else { [a, a, b, b] };
            all.extend(rectangle([0, 0], far, depth, random.color()));
        }
        Self {
            name: format!("{planes} planes through each other"),
            size,
            triangles: all,
            per_object: 2,
            materials: vec![Kind::Blend],
            lean: 0,
        }
    }

    /// Layers over the whole picture, in any order.
    pub fn full_screen(seed: u64, size: [u32; 2], layers: usize, alpha: f32) -> Self {
        let mut random = Random::new(seed);
        let far = size.map(|side| i64::from(side) * GRID);
        let mut all = Vec::new();
        for _ in 0..layers {
            let [r, g, b, _] = random.color();
            all.extend(rectangle([0, 0], far, [0.3 + 0.6 * random.unit(); 4], [r, g, b, alpha]));
        }
        let name = format!("{layers} full-screen layers at {}×{}", size[0], size[1]);
        Self { name, size, triangles: all, per_object: 1000, materials: vec![Kind::Blend], lean: 0 }
    }

    /// Rectangles all at one depth, several an object.
    pub fn coplanar(size: [u32; 2], stack: usize) -> Self {
        let mut random = Random::new(9);
        let far = size.map(|side| i64::from(side) * GRID);
        let mut all = Vec::new();
        for _ in 0..stack {
            let mut inset = |far: i64| random.below(far as u64 / 2) as i64;
            let (low, high) = ([inset(far[0]), inset(far[1])], [far[0] - inset(far[0]), far[1] - inset(far[1])]);
            all.extend(rectangle(low, high, [0.5; 4], random.color()));
        }
        Self {
            name: format!("{stack} rectangles at one depth"),
            size,
            triangles: all,
            per_object: 6,
            materials: vec![Kind::Blend],
            lean: 0,
        }
    }

    /// With alphas of any value.
    pub fn with_any_alpha(mut self) -> Self {
        let mut random = Random::new(11);
        self.triangles.iter_mut().for_each(|triangle| triangle.color[3] = random.unit());
        self
    }

    /// With alphas so low that the farthest of many layers is still to be seen, at depths that steps of floats tell
    /// apart.
    pub fn thin(mut self, alpha: f32) -> Self {
        self.triangles.iter_mut().for_each(|triangle| triangle.color[3] = alpha);
        self
    }

    /// Of these materials in turn.
    pub fn made_of(mut self, materials: &[Kind]) -> Self {
        self.materials = materials.to_vec();
        self.name += &format!(", {materials:?}");
        self
    }

    /// With so many triangles an object.
    pub fn in_objects_of(mut self, triangles: usize) -> Self {
        self.per_object = triangles;
        self
    }

    /// Before an opaque rectangle that leans to the right by about so many pixels, so that its edges cut through them.
    pub fn leaning(mut self, pixels: i64) -> Self {
        self.lean = pixels * GRID + GRID / 16 * 3;
        self
    }

    /// With vertices on the grid of a device that has so many bits below the pixel.
    pub fn on_grid(mut self, bits: u32) -> Self {
        let step = GRID >> bits.min(8);
        let corners = self.triangles.iter_mut().flat_map(|t| t.corners.iter_mut().flatten());
        corners.for_each(|x| *x = *x / step * step);
        self
    }

    /// The scene.
    pub fn scene(&self) -> Scene {
        let mut scene = tiny::empty();
        scene.materials[0].unlit = true;
        for kind in &self.materials {
            scene.materials.push(Material {
                name: format!("{kind:?}"),
                metallic: 0.0,
                transmission: if *kind == Kind::Glass { TRANSMISSION } else { 0.0 },
                alpha_mode: match kind {
                    Kind::Blend | Kind::Glass => AlphaMode::Blend,
                    Kind::Premultiplied => AlphaMode::Premultiplied,
                    Kind::Add => AlphaMode::Add,
                },
                double_sided: true,
                unlit: true,
                ..Material::default()
            });
        }
        let at = |[x, y]: [i64; 2], depth| Vec3::new(x as f32 / GRID as f32, y as f32 / GRID as f32, depth);
        for (index, object) in self.triangles.chunks(self.per_object).enumerate() {
            let corners: Vec<_> =
                object.iter().map(|t| [0, 1, 2].map(|corner| at(t.corners[corner], t.depth[corner]))).collect();
            let mut primitive = tiny::triangles(&corners, 1 + index % self.materials.len());
            let colors = object.iter().flat_map(|t| [Vec4::from(t.color); 3]);
            primitive.colors = colors.collect();
            tiny::add(&mut scene, primitive, Mat4::IDENTITY);
        }
        let [width, height] = self.size.map(|side| side as f32);
        let corner = Vec3::new(0.0, 0.0, OPAQUE);
        let down = Vec3::new(self.lean as f32 / GRID as f32, height, 0.0);
        // Double-sided, as the view turns y around.
        scene.materials[0].double_sided = true;
        tiny::add(&mut scene, tiny::quad(corner, Vec3::X * width / 2.0, down, 0), Mat4::IDENTITY);
        scene.name = self.name.clone();
        scene
    }

    /// World space is the picture: pixels and depth. The distance along the view axis is 1 - depth.
    pub fn view(&self) -> View {
        let [width, height] = self.size.map(|side| side as f32);
        let clip_from_view = Mat4::from_cols(
            Vec4::new(2.0 / width, 0.0, 0.0, 0.0),
            Vec4::new(0.0, 2.0 / height, 0.0, 0.0),
            Vec4::new(0.0, 0.0, 1.0, 0.0),
            Vec4::new(-1.0, -1.0, 1.0, 1.0),
        );
        let world_from_view = Mat4::from_translation(Vec3::Z);
        View { size: self.size, world_from_view, view_from_world: world_from_view.inverse(), clip_from_view }
    }

    /// The triangles as the twin has them.
    fn twins(&self) -> Vec<layers::Triangle> {
        let triangle = |(key, t): (usize, &Flat)| {
            let color = DVec4::from(t.color.map(f64::from));
            let (rgb, a) = (color.truncate(), color.w);
            let (rgb, through) = match self.materials[key / self.per_object % self.materials.len()] {
                Kind::Blend => (rgb * a, layers::through_alpha(a)),
                Kind::Glass => {
                    let passing = f64::from(TRANSMISSION);
                    (rgb * a * (1.0 - passing), DVec3::ONE - a * (DVec3::ONE - rgb * passing))
                }
                Kind::Premultiplied => (rgb, layers::through_alpha(a)),
                Kind::Add => (rgb * a, DVec3::ONE),
            };
            layers::Triangle {
                corners: t.corners,
                depth: t.depth.map(f64::from),
                color: rgb.extend(1.0 - through.element_sum() / 3.0),
                through,
                key: key as u32,
            }
        };
        self.triangles.iter().enumerate().map(triangle).collect()
    }

    /// What the twin has in each pixel, sorted: all that is before the opaque rectangle.
    pub fn fragments(&self) -> Vec<Vec<Fragment>> {
        let mut pixels = layers::rasterise(self.size, &self.twins());
        for (i, fragments) in pixels.iter_mut().enumerate() {
            let opaque = self.opaque_at(i);
            fragments.retain(|fragment| fragment.depth > opaque);
            layers::sort(fragments);
        }
        pixels
    }

    /// The same of several samples a pixel: what is seen at any of them. `None` where rounding of depth may decide what is
    /// seen, or which of two is nearer.
    pub fn seen(&self, samples: u32) -> Vec<Option<Vec<Seen>>> {
        let locations = layers::sample_locations(samples);
        let width = i64::from(self.size[0]);
        let pixel = |(i, covered): (i64, Vec<Covered>)| {
            let opaque = |sample: u32| {
                let [x, y] = locations[sample as usize];
                self.opaque_at_place([i % width * GRID + x, i / width * GRID + y])
            };
            let all = covered.iter().flat_map(|covered| &covered.samples);
            let sure = all.clone().all(|&(sample, depth)| (depth - opaque(sample)).abs() > DEPTH_MARGIN);
            let mut seen: Vec<_> = covered
                .iter()
                .map(|Covered { fragment, samples }| {
                    let before = samples.iter().filter(|&&(sample, depth)| depth > opaque(sample));
                    Seen { fragment: *fragment, samples: before.map(|(sample, _)| 1 << sample).sum() }
                })
                .filter(|seen| seen.samples != 0)
                .collect();
            seen.sort_by(|a, b| {
                b.fragment.depth.total_cmp(&a.fragment.depth).then(b.fragment.key.cmp(&a.fragment.key))
            });
            // Only fragments that share a sample have an order.
            let close = (0..samples).any(|sample| {
                let own = seen.iter().filter(|seen| seen.samples >> sample & 1 == 1).map(|seen| seen.fragment);
                close_call(&own.collect::<Vec<_>>(), DEPTH_MARGIN)
            });
            (sure && !close).then_some(seen)
        };
        (0..).zip(layers::rasterise_samples(self.size, &self.twins(), samples)).map(pixel).collect()
    }

    /// Whether the fragments are all that a device must have, whatever it rounds.
    pub fn sure(&self, pixel: usize, all: &[Fragment]) -> bool {
        let opaque = self.opaque_at(pixel);
        all.iter().all(|f| (f.depth - opaque).abs() > DEPTH_MARGIN)
    }

    /// A picture against the exact composite: the largest difference of a component.
    pub fn compare(&self, found: &[[f32; 4]], tolerance: f64, what: &str) -> Check {
        let expect = |sorted: &[Fragment]| composite(sorted, background());
        self.compare_with(found, tolerance, what, |_, sorted| {
            (!close_call(sorted, DEPTH_MARGIN)).then(|| expect(sorted))
        })
    }

    /// A picture of several samples a pixel against their exact composites' mean.
    pub fn compare_samples(&self, found: &[[f32; 4]], samples: u32, tolerance: f64, what: &str) -> Check {
        let mut comparison = Comparison::new(format!("{}: {what}", self.name), self.size, tolerance);
        for (i, seen) in self.seen(samples).into_iter().enumerate() {
            match seen {
                Some(seen) => {
                    let expected = composite_samples(&seen, samples, background());
                    comparison.error(i, (DVec4::from(found[i].map(f64::from)) - expected).abs().max_element());
                }
                None => comparison.leave_out(i, "near in depth"),
            }
        }
        Check::new(comparison, 1.0, 0.1)
    }

    /// A picture against what `expect` makes of each pixel's fragments; `None` where rounding of depth may decide.
    pub fn compare_with(
        &self,
        found: &[[f32; 4]],
        tolerance: f64,
        what: &str,
        expect: impl Fn(usize, &[Fragment]) -> Option<DVec4>,
    ) -> Check {
        let mut comparison = Comparison::new(format!("{}: {what}", self.name), self.size, tolerance);
        for (i, sorted) in self.fragments().iter().enumerate() {
            match expect(i, sorted).filter(|_| self.sure(i, sorted)) {
                Some(expected) => {
                    let found = DVec4::from(found[i].map(f64::from));
                    comparison.error(i, (found - expected).abs().max_element());
                }
                None => comparison.leave_out(i, "near in depth"),
            }
        }
        Check::new(comparison, 1.0, 0.1)
    }

    /// Opaque depth at a pixel's centre.
    pub fn opaque_at(&self, pixel: usize) -> f64 {
        let [x, y] = [pixel as i64 % i64::from(self.size[0]), pixel as i64 / i64::from(self.size[0])];
        self.opaque_at_place([x, y].map(|side| side * GRID + GRID / 2))
    }

    /// Opaque depth at a place, in 1/256 pixel: the rectangle's left edge is part of it.
    fn opaque_at_place(&self, [x, y]: [i64; 2]) -> f64 {
        let [width, height] = self.size.map(|side| i64::from(side) * GRID);
        let across = x * height - y * self.lean;
        if (0..width / 2 * height).contains(&across) { f64::from(OPAQUE) } else { 0.0 }
    }
}

/// What lies behind everything, premultiplied.
pub fn background() -> DVec4 {
    DVec4::from(BACKGROUND.map(f64::from))
}

/// Two triangles; depths at the upper left, upper right, lower left and lower right corner.
pub fn rectangle([left, top]: [i64; 2], [right, bottom]: [i64; 2], d: [f32; 4], color: [f32; 4]) -> [Flat; 2] {
    let upper = Flat { corners: [[left, top], [right, top], [left, bottom]], depth: [d[0], d[1], d[2]], color };
    let lower = Flat { corners: [[right, top], [right, bottom], [left, bottom]], depth: [d[1], d[3], d[2]], color };
    [upper, lower]
}
