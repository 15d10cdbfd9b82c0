//! Floors, outer walls, ceilings and roofs.

use glam::{Vec3, vec2, vec3};

use super::{BAY, COURT, Parts, Shape, Side, Surface, TOP, WALK};

/// Edge of the walk's floor, from the arcade's axis into the court.
const KERB: f32 = 0.50;
const TREAD: f32 = 0.36;
/// Where the roof meets the outer wall.
const RIDGE: f32 = 6.35;
const WALL_TOP: f32 = 8.9;

/// The paved court between the steps.
pub fn court() -> Parts {
    let mut paving = Shape::new();
    let (x, z) = (7.5 - KERB, 9.0 - KERB);
    // In fields, so that no triangle is very large.
    let n = 6;
    for i in 0..n {
        for j in 0..n {
            let at = |i: usize, j: usize| {
                let of = |k: usize, half: f32| half * (2.0 * k as f32 / n as f32 - 1.0);
                vec3(of(i, x), COURT, -of(j, z))
            };
            paving.face([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], Vec3::ZERO, Vec3::X);
        }
    }
    vec![(Surface::Paving, paving)]
}

/// The walk's floor and the steps down to the court.
pub fn floor(side: &Side) -> Parts {
    let half = side.length() * 0.5;
    let mut paving = Shape::new();
    let mut steps = Shape::new();
    // At the corners the floor belongs to the sides that have them.
    let reach = if side.corners { half + WALK } else { half - KERB };
    let n = 8;
    for i in 0..n {
        let x = |i: usize| reach * (2.0 * i as f32 / n as f32 - 1.0);
        let p = |i: usize, z: f32| vec3(x(i), 0.0, z);
        paving.face([p(i, KERB), p(i + 1, KERB), p(i + 1, -WALK), p(i, -WALK)], Vec3::ZERO, Vec3::X);
    }
    let inner = half - KERB;
    steps.quad([
        vec3(-inner, COURT * 0.5, KERB),
        vec3(inner, COURT * 0.5, KERB),
        vec3(inner, 0.0, KERB),
        vec3(-inner, 0.0, KERB),
    ]);
    let tread = if side.corners { inner } else { inner - TREAD };
    steps.cuboid(vec3(-tread, COURT, KERB), vec3(tread, COURT * 0.5, KERB + TREAD));
    vec![(Surface::Paving, paving), (Surface::Ashlar, steps)]
}

/// The outer wall: glazed tiles, plaster, a door, and above the roof bricks with a window over each bay.
pub fn outer_wall(side: &Side) -> Parts {
    let reach = side.length() * 0.5 + WALK;
    let mut tiles = Shape::new();
    let mut plaster = Shape::new();
    let mut brick = Shape::new();
    let mut stone = Shape::new();
    let mut wood = Shape::new();
    let mut glass = Shape::new();
    let band = |shape: &mut Shape, low: f32, high: f32| {
        let p = |x: f32, y: f32| vec3(x, y, -WALK);
        shape.face([p(-reach, low), p(reach, low), p(reach, high), p(-reach, high)], Vec3::ZERO, Vec3::X);
    };
    band(&mut tiles, 0.0, 1.32);
    band(&mut plaster, 1.32, TOP);
    let rail = [[0.0, 0.0], [0.05, 0.02], [0.05, 0.02], [0.05, 0.08], [0.05, 0.08], [0.0, 0.09]];
    stone.moulding(vec3(-reach, 1.30, -WALK), vec3(reach, 1.30, -WALK), Vec3::Z, &rail);

    // A door in the middle, under an arch of its own.
    let door = if side.bays % 2 == 1 { 0.0 } else { BAY * 0.5 };
    let z = -WALK + 0.06;
    wood.cuboid(vec3(door - 0.75, 0.0, -WALK), vec3(door + 0.75, 2.3, z));
    stone.cuboid(vec3(door - 1.0, 0.0, -WALK), vec3(door - 0.75, 2.2, z + 0.12));
    stone.cuboid(vec3(door + 0.75, 0.0, -WALK), vec3(door + 1.0, 2.2, z + 0.12));
    let mut lintel = Shape::new();
    lintel.arch(2.0, 0.24, 2.2, 3.3, 0.75, 16);
    stone.add(&lintel, glam::Mat4::from_translation(vec3(door, 0.0, -WALK + 0.1)));
    let mut fanlight = Shape::new();
    fanlight.card(vec3(door, 2.65, -WALK + 0.04), Vec3::X * 0.75, Vec3::Y * 0.42);
    glass.add(&fanlight, glam::Mat4::IDENTITY);

    // Over the roof: between the windows, below them, and the arches over them.
    let thick = 0.4;
    let (sill, spring, radius) = (6.75, 7.65, 0.55);
    let back = -WALK - thick;
    brick.cuboid(vec3(-reach, RIDGE - 0.4, back), vec3(reach, sill, -WALK));
    let end = side.length() * 0.5;
    for x in [-1.0f32, 1.0] {
        let (a, b) = (x * end, x * reach);
        brick.cuboid(vec3(a.min(b), sill, back), vec3(a.max(b), WALL_TOP, -WALK));
    }
    let mut arch = Shape::new();
    arch.arch(BAY, thick, spring, WALL_TOP, radius, 12);
    for bay in (0..side.bays).map(|i| side.bay(i)) {
        for x in [-1.0f32, 1.0] {
            let (a, b) = (bay + x * radius, bay + x * BAY * 0.5);
            brick.cuboid(vec3(a.min(b), sill, back), vec3(a.max(b), spring, -WALK));
        }
        let center = vec3(bay, 0.0, (back - WALK) * 0.5);
        brick.add(&arch, glam::Mat4::from_translation(center));
        stone.cuboid(vec3(bay - 0.75, sill - 0.12, -WALK - 0.1), vec3(bay + 0.75, sill, -WALK + 0.14));
        let pane = (sill + spring + radius) * 0.5;
        let half = (spring + radius - sill) * 0.5;
        glass.quad([
            vec3(bay - radius, pane - half, center.z),
            vec3(bay + radius, pane - half, center.z),
            vec3(bay + radius, pane + half, center.z),
            vec3(bay - radius, pane + half, center.z),
        ]);
    }
    let crown = [
        [0.0, 0.0],
        [0.06, 0.04],
        [0.06, 0.04],
        [0.10, 0.10],
        [0.20, 0.16],
        [0.20, 0.16],
        [0.20, 0.28],
        [0.20, 0.28],
        [-0.45, 0.30],
    ];
    let top = |x: f32| vec3(x, WALL_TOP - 0.02, -WALK);
    stone.moulding(top(-reach), top(reach), Vec3::Z, &crown);
    vec![
        (Surface::Azulejo, tiles),
        (Surface::Plaster, plaster),
        (Surface::Brick, brick),
        (Surface::Ashlar, stone),
        (Surface::Planks, wood),
        (Surface::StainedGlass, glass),
    ]
}

/// Boards and beams over the walk.
pub fn ceiling(side: &Side) -> Parts {
    let half = side.length() * 0.5;
    let reach = if side.corners { half + WALK } else { half };
    let y = TOP - 0.16;
    let mut wood = Shape::new();
    let p = |x: f32, z: f32| vec3(x, y, z);
    wood.face([p(-reach, -WALK), p(reach, -WALK), p(reach, 0.0), p(-reach, 0.0)], Vec3::ZERO, Vec3::X);
    let count = (2.0 * reach / 0.75) as usize;
    for i in 0..count {
        let x = reach * (2.0 * (i as f32 + 0.5) / count as f32 - 1.0);
        wood.cuboid(vec3(x - 0.08, y - 0.2, -WALK), vec3(x + 0.08, y, -0.2));
    }
    // The board under the eaves.
    wood.cuboid(vec3(-half, TOP - 0.06, 0.2), vec3(half, TOP + 0.02, 0.58));
    vec![(Surface::Planks, wood)]
}

/// Half-round tiles in courses from the eaves up to the outer wall. At the corners two roofs run into each other.
pub fn roof(side: &Side) -> Parts {
    const COURSES: usize = 8;
    const TILE: f32 = 0.24;
    const STEPS: usize = 3;
    let reach = side.length() * 0.5 + WALK;
    let tiles = (2.0 * reach / TILE).round() as usize;
    let (eaves, ridge) = (vec2(0.66, TOP + 0.04), vec2(-WALK, RIDGE));
    let slope = eaves.distance(ridge);
    let mut shape = Shape::new();
    for course in 0..COURSES {
        shape.grid([tiles * STEPS, 1], false, |s, t| {
            let up = (course as f32 + t * 1.12) / COURSES as f32;
            let on = eaves.lerp(ridge, up);
            let phase = (s * tiles as f32).fract();
            let barrel = 0.06 * (phase * std::f32::consts::PI).sin().abs();
            let x = reach * (2.0 * s - 1.0);
            (vec3(x, on.y + barrel + 0.035 * (1.0 - t), on.x), vec2(x, -up * slope))
        });
    }
    vec![(Surface::RoofTile, shape)]
}
