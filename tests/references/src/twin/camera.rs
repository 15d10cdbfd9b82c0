//! A ray caster at pixel centres: what a rasteriser that samples there must find.

use std::ops::ControlFlow;

use glam::{DMat4, DVec3, DVec4};
use shadowgraph::scene::View;

use super::scene::{Footprint, Hit, Line, Ray, Rule, Scene};
use super::shadow::Receiver;
use super::surface::Surface;
use crate::parallel;

/// Rays of a view.
pub struct Camera {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Distance of the near plane, metres.
    pub near: f64,
    /// Distance of the far plane; may be infinite.
    pub far: f64,
    world_from_view: DMat4,
    view_from_clip: DMat4,
    perspective: bool,
}

/// What a pixel centre sees.
#[derive(Clone, Debug)]
pub struct Pixel {
    /// Distance along the view axis, metres; infinite where there is no surface.
    pub z: f64,
    /// The first opaque surface.
    pub surface: Option<Surface>,
    /// Rounding may decide what a device sees here: see [`Tolerance`].
    pub near_edge: bool,
}

/// The first opaque surfaces of a view.
pub struct Picture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Rows from the top.
    pub pixels: Vec<Pixel>,
}

/// When a pixel is near an edge: one of eight rays at this distance around its centre sees another triangle; or an edge
/// of the triangle seen passes at that distance; or another surface lies this near in depth; or the alpha of a `MASK`
/// surface, seen or looked through, is this near its cutoff.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Pixels. Vulkan guarantees 4 bits of sub-pixel precision, common devices have 8.
    pub pixels: f64,
    /// Relative.
    pub depth: f64,
    /// Absolute.
    pub alpha: f64,
}

impl Default for Tolerance {
    /// A sixteenth of a pixel, 1e-5 and 0.02.
    fn default() -> Self {
        Self { pixels: 1.0 / 16.0, depth: 1e-5, alpha: 0.02 }
    }
}

impl Camera {
    /// The rays of a view.
    pub fn new(view: &View) -> Self {
        let clip_from_view = view.clip_from_view.as_dmat4();
        let view_from_clip = clip_from_view.inverse();
        let distance = |clip_z: f64| {
            let p = view_from_clip * DVec4::new(0.0, 0.0, clip_z, 1.0);
            if p.w.abs() < 1e-12 { f64::INFINITY } else { -p.z / p.w }
        };
        // Reversed depth: 1 on the near plane, 0 on the far plane.
        Self {
            size: view.size,
            near: distance(1.0),
            far: distance(0.0),
            world_from_view: view.world_from_view.as_dmat4(),
            view_from_clip,
            perspective: clip_from_view.w_axis.w == 0.0,
        }
    }

    /// The line through a point of the picture in pixels, (0, 0) at the upper left corner. Its parameter is the
    /// distance along the view axis.
    pub fn line(&self, x: f64, y: f64) -> Line {
        let [width, height] = self.size.map(f64::from);
        let on_near = DVec4::new(2.0 * x / width - 1.0, 2.0 * y / height - 1.0, 1.0, 1.0);
        let p = self.view_from_clip * on_near;
        let p = p.truncate() / p.w;
        let (origin, direction) =
            if self.perspective { (DVec3::ZERO, p / -p.z) } else { (DVec3::new(p.x, p.y, 0.0), DVec3::NEG_Z) };
        Line {
            origin: self.world_from_view.transform_point3(origin),
            direction: self.world_from_view.transform_vector3(direction),
        }
    }

    /// The ray through a point of pixel (x, y), `offset` pixels from its centre.
    pub fn ray(&self, x: u32, y: u32, offset: [f64; 2]) -> Ray {
        let (left, top) = (f64::from(x & !1) + 0.5, f64::from(y & !1) + 0.5);
        Ray {
            line: self.line(f64::from(x) + 0.5 + offset[0], f64::from(y) + 0.5 + offset[1]),
            near: self.near,
            far: self.far,
            footprint: Footprint::Quad(
                [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|d| self.line(left + d[0], top + d[1])),
            ),
        }
    }

    /// Unit vector from a point in world space to the viewer.
    pub fn toward_viewer(&self, position: DVec3) -> DVec3 {
        if self.perspective {
            (self.world_from_view.w_axis.truncate() - position).normalize()
        } else {
            self.world_from_view.z_axis.truncate().normalize()
        }
    }
}

/// Casts a ray through every pixel centre.
pub fn cast(scene: &Scene, view: &View, tolerance: Tolerance) -> Picture {
    let camera = Camera::new(view);
    let [width, height] = view.size;
    let pixels = parallel::rows(height as usize, |y| {
        (0..width).map(|x| pixel(scene, &camera, x, y as u32, tolerance)).collect()
    });
    Picture { size: view.size, pixels }
}

fn pixel(scene: &Scene, camera: &Camera, x: u32, y: u32, tolerance: Tolerance) -> Pixel {
    let ray = camera.ray(x, y, [0.0; 2]);
    let hit = scene.closest(&ray, Rule::CAMERA);
    Pixel {
        z: hit.map_or(f64::INFINITY, |h| h.t),
        near_edge: near_edge(scene, camera, &ray, hit.as_ref(), [x, y], tolerance),
        surface: hit.map(|h| scene.surface(&ray, &h)),
    }
}

fn near_edge(
    scene: &Scene,
    camera: &Camera,
    ray: &Ray,
    hit: Option<&Hit>,
    [x, y]: [u32; 2],
    tolerance: Tolerance,
) -> bool {
    // 1. An edge of the triangle itself: the distance to the line where its volume is zero
    if let (Some(hit), Footprint::Quad(quad)) = (hit, &ray.footprint) {
        let triangle = &scene.triangles[hit.triangle as usize];
        let at = triangle.edge_volumes(&ray.line);
        let [start, right, below] = quad.map(|line| triangle.edge_volumes(&line));
        let (dx, dy) = (right - start, below - start);
        if (0..3).any(|i| at[i].abs() < tolerance.pixels * dx[i].hypot(dy[i])) {
            return true;
        }
    }

    // 2. Another surface as near, or alpha that rounding may turn
    let far = hit.map_or(ray.far, |h| h.t * (1.0 + tolerance.depth));
    let near = if scene.has_masks() { ray.near } else { hit.map_or(far, |h| h.t * (1.0 - tolerance.depth)) };
    let mut contested = false;
    scene.each(&Ray { near, far, ..*ray }, Rule::CAMERA, |other, _| {
        let same = hit.is_some_and(|h| h.triangle == other.triangle);
        let as_near = hit.is_some_and(|h| (other.t / h.t - 1.0).abs() <= tolerance.depth);
        contested = other.alpha_excess.abs() < tolerance.alpha || (!same && as_near && other.alpha_excess >= 0.0);
        if contested { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    if contested {
        return true;
    }

    // 3. Other triangles around, in directions that no axis or diagonal has
    let triangle = hit.map(|h| h.triangle);
    (0..8).any(|k| {
        let (sin, cos) = ((f64::from(k) + 0.25) * std::f64::consts::FRAC_PI_4).sin_cos();
        let probe = camera.ray(x, y, [tolerance.pixels * cos, tolerance.pixels * sin]);
        scene.closest(&probe, Rule::CAMERA).map(|h| h.triangle) != triangle
    })
}

impl Picture {
    /// The pixel in column x and row y.
    pub fn at(&self, x: u32, y: u32) -> &Pixel {
        &self.pixels[(y * self.size[0] + x) as usize]
    }

    /// The points seen, to ask what a light sees of them. `texel` gives the width of a shadow-map texel at a pixel, in
    /// metres.
    pub fn receivers(&self, texel: impl Fn(&Pixel) -> f64) -> Vec<Option<Receiver>> {
        let receiver = |pixel: &Pixel| {
            let surface = pixel.surface.as_ref()?;
            Some(Receiver { position: surface.position, normal: surface.flat_normal, texel: texel(pixel) })
        };
        self.pixels.iter().map(receiver).collect()
    }
}
