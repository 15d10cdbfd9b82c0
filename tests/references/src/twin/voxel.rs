//! Voxels of solids, by the parity of crossings or by winding numbers.
//!
//! - Grid coordinates count voxels from the grid's lower corner; voxel (i, j, k) has its centre at (i, j, k) + ½.
//! - A voxel's crossings are those of a ray from its centre towards smaller x. It is inside where they are odd in number,
//!   or where more go one way than the other.
//! - The test of a row against an edge gives exactly opposite values for the two triangles that share it, and a row on an
//!   edge belongs to one side of it, so a closed surface is crossed an even number of times.

use glam::DVec3;
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::Grid;

/// A scene's triangles in grid coordinates, those without area too. Those of mirrored objects are turned around, so that
/// they face as they did before.
pub fn in_grid(scene: &Scene, grid: &Grid) -> Vec<[DVec3; 3]> {
    let (min, edge) = (grid.min().as_dvec3(), f64::from(grid.edge()));
    let mut triangles = world_triangles(scene);
    triangles.iter_mut().flatten().for_each(|corner| *corner = (*corner - min) / edge);
    triangles
}

/// The same in world space, metres.
pub fn world_triangles(scene: &Scene) -> Vec<[DVec3; 3]> {
    let mut triangles = Vec::new();
    for object in &scene.objects {
        let world = object.world_from_object.as_dmat4();
        for primitive in &scene.meshes[object.mesh].primitives {
            let corner = |&i: &u32| world.transform_point3(primitive.positions[i as usize].as_dvec3());
            let mirrored = world.determinant() < 0.0;
            let turned = |&[a, b, c]: &[u32; 3]| if mirrored { [b, a, c] } else { [a, b, c] };
            triangles
                .extend(primitive.indices.as_chunks().0.iter().map(|corners| turned(corners).each_ref().map(corner)));
        }
    }
    triangles
}

/// Whether each voxel is inside by the parity of crossings, in the order `[z][y][x]`.
pub fn solid(triangles: &[[DVec3; 3]], size: [u32; 3]) -> Vec<bool> {
    windings(triangles, size).into_iter().map(|winding| winding % 2 != 0).collect()
}

/// Winding number of each voxel, in the order `[z][y][x]`: surfaces that a ray towards smaller x crosses, those that face
/// smaller x against those that face larger x.
pub fn windings(triangles: &[[DVec3; 3]], size: [u32; 3]) -> Vec<i32> {
    rows(triangles, size).0
}

/// The same, and by row, `[z][y]`, the sum over all crossings of its line.
pub fn rows(triangles: &[[DVec3; 3]], size: [u32; 3]) -> (Vec<i32>, Vec<i32>) {
    let [nx, ny, nz] = size.map(|n| n as usize);
    let mut windings = vec![0; nx * ny * nz];
    let mut sums = vec![0; ny * nz];
    for triangle in triangles {
        // Centres at most as far out as the triangle.
        let rows = |axis: usize, n: usize| {
            let [least, most] = extent(triangle, axis).map(|value| value - 0.5);
            least.ceil().clamp(0.0, n as f64) as usize..(most.floor() + 1.0).clamp(0.0, n as f64) as usize
        };
        for z in rows(2, nz) {
            for y in rows(1, ny) {
                let Some((x, sign)) = crossing(triangle, y as f64 + 0.5, z as f64 + 0.5) else { continue };
                sums[z * ny + y] += sign;
                // The first voxel of the row with its centre beyond the crossing.
                let first = (x - 0.5).floor() + 1.0;
                if first < nx as f64 {
                    windings[(z * ny + y) * nx + first.max(0.0) as usize] += sign;
                }
            }
        }
    }
    for row in windings.chunks_mut(nx) {
        let mut sum = 0;
        for voxel in row {
            sum += *voxel;
            *voxel = sum;
        }
    }
    (windings, sums)
}

/// Least and greatest coordinate along an axis.
fn extent(triangle: &[DVec3; 3], axis: usize) -> [f64; 2] {
    let [a, b, c] = triangle.map(|p| p[axis]);
    [a.min(b).min(c), a.max(b).max(c)]
}

/// Where the line along x at (y, z) crosses a triangle, and the sign of the way there: 1 into what the triangle encloses.
fn crossing(triangle: &[DVec3; 3], y: f64, z: f64) -> Option<(f64, i32)> {
    let sides = [0, 1, 2].map(|i| side(triangle[(i + 1) % 3], triangle[(i + 2) % 3], y, z));
    if sides.iter().any(|&(positive, _)| positive != sides[0].0) {
        return None;
    }
    let total: f64 = sides.iter().map(|&(_, area)| area).sum();
    let weighted = |i: usize| triangle[i].x * sides[i].1;
    let x = (weighted(0) + weighted(1) + weighted(2)) / total;
    // Slivers divide nearly nothing by nearly nothing: what lies in the triangle lies between its corners.
    let [least, most] = extent(triangle, 0);
    let x = if x.is_finite() { x.clamp(least, most) } else { triangle[0].x };
    Some((x, if sides[0].0 { -1 } else { 1 }))
}

/// Which side of the edge from `a` to `b` the point lies on, and twice the area they span. The edge is taken in one
/// direction whichever triangle asks, so that both get opposite answers, also for a point on it.
fn side(a: DVec3, b: DVec3, y: f64, z: f64) -> (bool, f64) {
    let turned = (a.y, a.z) > (b.y, b.z);
    let (from, to) = if turned { (b, a) } else { (a, b) };
    let area = (to.y - from.y) * (z - from.z) - (to.z - from.z) * (y - from.y);
    if turned { (area < 0.0, -area) } else { (area >= 0.0, area) }
}

/// Whether a point lies at most so far from one of some triangles.
pub fn is_near(point: DVec3, triangles: &[[DVec3; 3]], limit: f64) -> bool {
    let beside = |[a, b, c]: &[DVec3; 3]| {
        let (least, most) = (a.min(*b).min(*c) - limit, a.max(*b).max(*c) + limit);
        point.cmplt(least).any() || point.cmpgt(most).any()
    };
    triangles.iter().any(|triangle| !beside(triangle) && nearest(point, triangle).distance(point) <= limit)
}

/// The point of a triangle that is nearest to another one.
fn nearest(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> DVec3 {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let normal = ab.cross(ac);
    let on_edge = |from: DVec3, edge: DVec3| {
        let along = if edge.length_squared() > 0.0 { (p - from).dot(edge) / edge.length_squared() } else { 0.0 };
        from + edge * along.clamp(0.0, 1.0)
    };
    // Inside all three edges, the foot on the plane is the nearest; otherwise a point of an edge is.
    let inside = [(a, ab), (b, bc), (c, -ac)].iter().all(|&(from, edge)| edge.cross(p - from).dot(normal) >= 0.0);
    if inside && normal.length_squared() > 0.0 {
        return p - normal * ((p - a).dot(normal) / normal.length_squared());
    }
    let edges = [on_edge(a, ab), on_edge(a, ac), on_edge(b, bc)];
    edges.into_iter().min_by(|x, y| x.distance_squared(p).total_cmp(&y.distance_squared(p))).unwrap_or(a)
}

/// Volume inside a closed surface, in cubes of a voxel.
pub fn volume(triangles: &[[DVec3; 3]]) -> f64 {
    triangles.iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum()
}

/// Whether a triangle and a closed box touch: some point is in both. By separating axes (Gottschalk et al. 1996).
pub fn touches(triangle: &[DVec3; 3], center: DVec3, half: f64) -> bool {
    let corners = triangle.map(|p| p - center);
    let edges = [0, 1, 2].map(|i| corners[(i + 1) % 3] - corners[i]);
    let boxes = [DVec3::X, DVec3::Y, DVec3::Z];
    let across = edges.iter().flat_map(|edge| boxes.map(|axis| edge.cross(axis)));
    let mut axes = boxes.into_iter().chain([edges[0].cross(edges[1])]).chain(across);
    axes.all(|axis| {
        let along = corners.map(|p| p.dot(axis));
        let radius = half * (axis.x.abs() + axis.y.abs() + axis.z.abs());
        let least = along.into_iter().fold(f64::INFINITY, f64::min);
        let most = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
        least <= radius && most >= -radius
    })
}

/// Voxels that make up one of the triangles, as `belongs` says of a triangle and a voxel's centre; `[z][y][x]`. Only
/// voxels at most one further than a triangle's bounds are asked for.
pub fn surface(triangles: &[[DVec3; 3]], size: [u32; 3], belongs: impl Fn(&[DVec3; 3], DVec3) -> bool) -> Vec<bool> {
    let [nx, ny, nz] = size.map(|n| n as usize);
    let mut set = vec![false; nx * ny * nz];
    for triangle in triangles {
        let range = |axis: usize, n: usize| {
            let [least, most] = extent(triangle, axis);
            (least - 1.5).floor().clamp(0.0, n as f64) as usize..(most + 1.5).ceil().clamp(0.0, n as f64) as usize
        };
        let rows = range(2, nz).flat_map(|z| range(1, ny).map(move |y| (z, y)));
        for (z, y, x) in rows.flat_map(|(z, y)| range(0, nx).map(move |x| (z, y, x))) {
            let voxel = &mut set[(z * ny + y) * nx + x];
            *voxel = *voxel || belongs(triangle, DVec3::new(x as f64, y as f64, z as f64) + 0.5);
        }
    }
    set
}

/// Whether a voxel belongs to the thin voxelization of a triangle (Schwarz and Seidel 2010, section 4), each of whose
/// conditions is eased by what moving corners by `margin` voxels does: its closed box meets the triangle's bounds; its centre is no further from the
/// plane, and in each projection from the inner side of each edge, than the segments between centres of opposite faces
/// reach.
pub fn is_thin(triangle: &[DVec3; 3], center: DVec3, margin: f64) -> bool {
    let [a, b, c] = triangle.map(|p| p - center);
    let normal = (b - a).cross(c - a);
    let (least, most) = (a.min(b).min(c), a.max(b).max(c));
    let in_bounds = least.max_element() <= 0.5 + margin && most.min_element() >= -0.5 - margin;
    // Corners that move by the margin turn the normal of a sliver.
    let turn = margin * (b - a).length().max((c - a).length()) * a.length();
    let on_plane = normal.dot(a).abs() <= 0.5 * normal.abs().max_element() + margin * normal.length() + turn;
    let in_projection = |u: usize, v: usize, w: usize| {
        let side = if normal[w] >= 0.0 { 1.0 } else { -1.0 };
        [(a, b), (b, c), (c, a)].iter().all(|(from, to)| {
            let outward = [side * (to[v] - from[v]), side * (from[u] - to[u])];
            let beyond = -(outward[0] * from[u] + outward[1] * from[v]);
            let reach = 0.5 * outward[0].abs().max(outward[1].abs());
            beyond <= reach + margin * outward[0].hypot(outward[1])
        })
    };
    in_bounds && on_plane && in_projection(0, 1, 2) && in_projection(1, 2, 0) && in_projection(2, 0, 1)
}

/// Voxels that a walk from outside the grid reaches over unset voxels, from face to face; `[z][y][x]`.
pub fn reached(set: &[bool], size: [u32; 3]) -> Vec<bool> {
    let [nx, ny, nz] = size.map(|n| n as usize);
    let mut reached = vec![false; set.len()];
    let mut todo = Vec::new();
    let mut reach = |index: usize, todo: &mut Vec<usize>| {
        if !set[index] && !reached[index] {
            reached[index] = true;
            todo.push(index);
        }
    };
    let place = |index: usize| [index % nx, index / nx % ny, index / nx / ny];
    let sizes = [nx, ny, nz];
    for index in 0..set.len() {
        if place(index).iter().zip(sizes).any(|(&i, n)| i == 0 || i + 1 == n) {
            reach(index, &mut todo);
        }
    }
    while let Some(index) = todo.pop() {
        for ((i, n), step) in place(index).into_iter().zip(sizes).zip([1, nx, nx * ny]) {
            if i > 0 {
                reach(index - step, &mut todo);
            }
            if i + 1 < n {
                reach(index + step, &mut todo);
            }
        }
    }
    reached
}
