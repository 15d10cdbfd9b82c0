//! A courtyard with an arcade on four sides: fluted columns, a fountain, trees, cloth, and coloured glass.

mod arcade;
mod furniture;
mod garden;
mod patterns;
mod surfaces;
mod textile;
mod walls;

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Mat4, Vec3, vec3};

use self::surfaces::Surface;
use super::{random::Random, shapes::Shape};
use crate::scene::{Camera, Light, LightKind, Mesh, Object, Scene};

/// Width of a bay of the arcade, metres.
const BAY: f32 = 3.0;
/// From the arcade's axis to the outer wall.
const WALK: f32 = 3.2;
/// Height of the columns, where the arches spring.
const SPRING: f32 = 3.2;
/// Top of the arcade's wall.
const TOP: f32 = 5.0;
/// The court lies two steps lower than the walk.
const COURT: f32 = -0.3;

/// A mesh by its parts.
type Parts = Vec<(Surface, Shape)>;

/// A courtyard of 15 m × 18 m, x to the right, z towards the default camera; the walk's floor is at y = 0.
///
/// About 120,000 triangles are drawn. BLEND panes, MASK foliage and double-sided cloth are among them; a sun of
/// 80,000 lux, three spots and a point light shine on it.
pub fn courtyard() -> Scene {
    // 1. Materials and textures.
    let (materials, textures) = surfaces::materials();
    let mut stage = Stage { scene: Scene { name: "courtyard".into(), materials, textures, ..Scene::default() } };

    // 2. The building: four sides around the court.
    build(&mut stage);

    // 3. What stands, grows and hangs in it.
    furnish(&mut stage);
    plant(&mut stage);
    hang(&mut stage);

    // 4. Light and views.
    let mut scene = stage.scene;
    scene.lights = lights();
    scene.cameras = cameras();
    scene
}

/// A side of the court: its frame has x to the right seen from the court, z into the court, and the arcade at z = 0.
#[derive(Clone, Copy)]
struct Side {
    name: &'static str,
    /// Number of bays.
    bays: usize,
    /// World from side.
    frame: Mat4,
    /// Whether the corners belong to it.
    corners: bool,
}

impl Side {
    const fn length(&self) -> f32 {
        self.bays as f32 * BAY
    }

    /// Where the middle of a bay stands.
    fn bay(&self, index: usize) -> f32 {
        (index as f32 + 0.5) * BAY - self.length() * 0.5
    }

    fn at(&self, x: f32, y: f32, z: f32) -> Mat4 {
        self.frame * Mat4::from_translation(vec3(x, y, z))
    }
}

fn sides() -> [Side; 4] {
    let side = |name, bays, turn: f32, distance: f32, corners| Side {
        name,
        bays,
        frame: Mat4::from_rotation_y(turn) * Mat4::from_translation(vec3(0.0, 0.0, -distance)),
        corners,
    };
    [
        side("north", 5, 0.0, 9.0, true),
        side("east", 6, -FRAC_PI_2, 7.5, false),
        side("south", 5, PI, 9.0, true),
        side("west", 6, FRAC_PI_2, 7.5, false),
    ]
}

/// A scene under construction.
struct Stage {
    scene: Scene,
}

impl Stage {
    fn mesh(&mut self, name: &str, parts: Parts) -> usize {
        let primitives = parts.into_iter().map(|(surface, shape)| shape.primitive(surface as usize));
        self.scene.meshes.push(Mesh { name: name.into(), primitives: primitives.collect() });
        self.scene.meshes.len() - 1
    }

    fn place(&mut self, mesh: usize, name: impl Into<String>, world_from_object: Mat4) {
        self.scene.objects.push(Object { name: name.into(), mesh, world_from_object });
    }

    /// A mesh that stands once.
    fn single(&mut self, name: &str, parts: Parts, world_from_object: Mat4) {
        let mesh = self.mesh(name, parts);
        self.place(mesh, name, world_from_object);
    }
}

fn build(stage: &mut Stage) {
    let column = stage.mesh("column", arcade::column());
    let pier = stage.mesh("pier", arcade::pier());
    let bay = stage.mesh("bay", arcade::bay());
    stage.single("court", walls::court(), Mat4::IDENTITY);
    for side in sides() {
        let Side { name, bays, .. } = side;
        stage.single(&format!("{name} floor"), walls::floor(&side), side.frame);
        stage.single(&format!("{name} wall"), walls::outer_wall(&side), side.frame);
        stage.single(&format!("{name} ceiling"), walls::ceiling(&side), side.frame);
        stage.single(&format!("{name} roof"), walls::roof(&side), side.frame);
        stage.single(&format!("{name} cornice"), arcade::cornice(side.length()), side.frame);
        for i in 0..bays {
            stage.place(bay, format!("{name} bay {}", i + 1), side.at(side.bay(i), 0.0, 0.0));
        }
        for i in 1..bays {
            stage.place(column, format!("{name} column {i}"), side.at(side.bay(i) - BAY * 0.5, 0.0, 0.0));
        }
        stage.place(pier, format!("{name} pier"), side.at(-side.length() * 0.5, 0.0, 0.0));
    }
}

fn furnish(stage: &mut Stage) {
    stage.single("fountain", furniture::fountain(), Mat4::from_translation(vec3(0.0, COURT, -1.0)));
    let bench = stage.mesh("bench", furniture::bench());
    for (i, (x, z, turn)) in [(-2.9, -6.9, 0.0), (2.9, -6.9, 0.0), (5.6, 0.0, -FRAC_PI_2)].into_iter().enumerate() {
        let at = Mat4::from_translation(vec3(x, COURT, z)) * Mat4::from_rotation_y(turn);
        stage.place(bench, format!("bench {}", i + 1), at);
    }
    let screen = Mat4::from_translation(vec3(2.9, COURT, 3.4)) * Mat4::from_rotation_y(-0.25);
    stage.single("glass screen", furniture::screen(), screen);
}

fn plant(stage: &mut Stage) {
    let planter = stage.mesh("planter", furniture::planter());
    let flowers = stage.mesh("flowers", garden::flowers(&mut Random::new(5)));
    let trees = [1, 2].map(|seed| stage.mesh("tree", garden::tree(&mut Random::new(seed))));
    for (i, (x, z)) in [(-4.3, -5.0), (4.3, -5.0), (-4.3, 2.6), (4.5, 5.6)].into_iter().enumerate() {
        let at = Mat4::from_translation(vec3(x, COURT, z));
        stage.place(planter, format!("planter {}", i + 1), at);
        stage.place(flowers, format!("flowers {}", i + 1), at * Mat4::from_rotation_y(i as f32 * FRAC_PI_2));
        let turned = Mat4::from_rotation_y(i as f32 * 2.1) * Mat4::from_scale(Vec3::splat(1.0 - 0.06 * i as f32));
        stage.place(trees[i % 2], format!("tree {}", i + 1), at * Mat4::from_translation(vec3(0.0, 0.5, 0.0)) * turned);
    }

    let pot = stage.mesh("pot", furniture::pot(Surface::Terracotta));
    let vase = stage.mesh("glazed pot", furniture::pot(Surface::Azulejo));
    let shrub = stage.mesh("shrub", garden::shrub(&mut Random::new(3)));
    let mut count = 0;
    for side in sides() {
        // One beside every other column, on the steps' side.
        for i in (1..side.bays).step_by(2) {
            count += 1;
            let at = side.at(side.bay(i) - BAY * 0.5 + 0.75, 0.0, 0.05);
            let size = Mat4::from_scale(Vec3::splat(0.85 + 0.1 * (count % 3) as f32));
            stage.place(if count % 2 == 0 { vase } else { pot }, format!("pot {count}"), at * size);
            stage.place(shrub, format!("shrub {count}"), at * size * Mat4::from_rotation_y(count as f32));
        }
    }

    let ivy = stage.mesh("ivy", garden::ivy(&mut Random::new(11)));
    let [north, east, _, west] = sides();
    stage.place(ivy, "ivy 1", north.at(-north.length() * 0.5 + 0.4, COURT, 0.34));
    stage.place(ivy, "ivy 2", east.at(-BAY, 0.0, 0.32));
    stage.place(ivy, "ivy 3", west.at(BAY, 0.0, 0.32));
}

fn hang(stage: &mut Stage) {
    let banners = [0.0, 2.4].map(|phase| stage.mesh("banner", textile::banner(phase)));
    let lanterns = [Surface::AmberGlass, Surface::RedGlass, Surface::BlueGlass, Surface::GreenGlass]
        .map(|glass| stage.mesh("lantern", furniture::lantern(glass)));
    let mut count = 0;
    for side in sides() {
        for i in 0..side.bays {
            count += 1;
            let at = side.at(side.bay(i), 4.3, 0.0);
            stage.place(lanterns[(count * 3) % lanterns.len()], format!("lantern {count}"), at);
        }
        for i in 1..side.bays {
            let at = side.at(side.bay(i) - BAY * 0.5, 4.72, 0.62);
            stage.place(banners[i % 2], format!("{} banner {i}", side.name), at);
        }
    }
    for (i, z) in [-7.4, -4.4].into_iter().enumerate() {
        let name = format!("sail {}", i + 1);
        stage.single(&name, textile::sail(i as f32), Mat4::from_translation(vec3(0.0, 5.1, z)));
    }
}

fn lights() -> Vec<Light> {
    let warm = vec3(1.0, 0.76, 0.45);
    let spot = |name: &str, position: Vec3, target: Vec3, color: Vec3, intensity: f32, outer: f32| Light {
        name: name.into(),
        color,
        kind: LightKind::Spot {
            position,
            direction: (target - position).normalize(),
            intensity,
            range: f32::INFINITY,
            inner: outer * 0.6,
            outer,
        },
    };
    vec![
        Light {
            name: "sun".into(),
            color: vec3(1.0, 0.94, 0.84),
            kind: LightKind::Directional { direction: vec3(0.52, -0.80, -0.42).normalize(), illuminance: 80_000.0 },
        },
        spot("west_uplight", vec3(-9.4, 0.15, -1.5), vec3(-10.5, 3.4, -4.0), warm, 60_000.0, 0.75),
        spot("south_spot", vec3(-2.6, 4.4, 11.0), vec3(-0.6, 0.0, 9.0), warm, 50_000.0, 0.6),
        spot("fountain_spot", vec3(-2.4, COURT + 0.1, 1.6), vec3(0.0, 1.6, -1.0), vec3(0.6, 0.8, 1.0), 30_000.0, 0.5),
        Light {
            name: "west_lamp".into(),
            color: warm,
            kind: LightKind::Point { position: vec3(-9.2, 3.2, 4.5), intensity: 12_000.0, range: 12.0 },
        },
    ]
}

fn cameras() -> Vec<Camera> {
    let camera = |name: &str, eye: Vec3, target: Vec3, fov_y: f32| Camera {
        name: name.into(),
        ..Camera::look_at(eye, target, Vec3::Y, fov_y, 0.05)
    };
    vec![
        camera("court", vec3(-3.6, 1.45, 8.6), vec3(1.1, 2.0, -3.0), 0.95),
        camera("arcade", vec3(9.7, 1.65, 10.9), vec3(7.2, 1.9, -2.0), 1.0),
    ]
}

/// Points on a circle, counter-clockwise.
fn ring<const N: usize>(radius: f32) -> [[f32; 2]; N] {
    std::array::from_fn(|i| {
        let (sin, cos) = (i as f32 / N as f32 * TAU).sin_cos();
        [radius * cos, radius * sin]
    })
}
