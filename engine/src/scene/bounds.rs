//! Extent and size of a scene.

use super::{Mesh, Object, Primitive, Scene};
use crate::geometry::Aabb;

impl Scene {
    /// World-space box around all vertices that the objects' triangles use; `None` for a scene without triangles. Vertices of
    /// an object whose mesh's box lies within are not looked at.
    pub fn bounds(&self) -> Option<Aabb> {
        // 1. Each object's box, turned with it: no smaller than the box around its vertices, but for rounding.
        let meshes: Vec<_> = self.meshes.iter().map(Mesh::bounds).collect();
        let around = |object: &Object| {
            let turned = meshes.get(object.mesh)?.as_ref()?.transformed(object.world_from_object);
            let spare = 1e-5 * turned.min.abs().max(turned.max.abs());
            Some(Aabb { min: turned.min - spare, max: turned.max + spare })
        };
        let boxes: Vec<Option<Aabb>> = self.objects.iter().map(around).collect();
        // 2. Those that reach out farthest first: few others reach beyond what these hold.
        let mut order: Vec<usize> = (0..boxes.len()).filter(|&index| boxes[index].is_some()).collect();
        let reach = |index: usize, side: usize| {
            boxes[index].map_or(f32::MIN, |b| if side < 3 { b.max[side] } else { -b.min[side - 3] })
        };
        for side in 0..6 {
            let last = (side..order.len()).max_by(|&a, &b| reach(order[a], side).total_cmp(&reach(order[b], side)));
            last.into_iter().for_each(|last| order.swap(side, last));
        }
        // 3. The vertices of those that may matter.
        let mut bounds: Option<Aabb> = None;
        for index in order {
            let (object, around) = (&self.objects[index], boxes[index]);
            if bounds.zip(around).is_some_and(|(bounds, around)| bounds.union(around) == bounds) {
                continue;
            }
            let corners = self.meshes[object.mesh].corners();
            let own = Aabb::around(corners.map(|p| object.world_from_object.transform_point3(p)));
            bounds = bounds.map_or(own, |bounds| Some(own.map_or(bounds, |own| bounds.union(own))));
        }
        bounds
    }

    /// Triangles drawn: those of a mesh count once for each of its objects.
    pub fn triangle_count(&self) -> u64 {
        let triangles: Vec<u64> = self.meshes.iter().map(Mesh::triangle_count).collect();
        self.objects.iter().filter_map(|object| triangles.get(object.mesh)).sum()
    }
}

impl Mesh {
    /// Triangles of all primitives.
    pub fn triangle_count(&self) -> u64 {
        self.primitives.iter().map(Primitive::triangle_count).sum()
    }

    /// Object-space box around all triangles; `None` without triangles.
    pub fn bounds(&self) -> Option<Aabb> {
        Aabb::around(self.corners())
    }

    /// Positions that triangles use; of an indexed vertex at least once.
    fn corners(&self) -> impl Iterator<Item = glam::Vec3> {
        self.primitives.iter().flat_map(|primitive| {
            let mut used = vec![false; primitive.positions.len()];
            for &index in &primitive.indices {
                if let Some(used) = used.get_mut(index as usize) {
                    *used = true;
                }
            }
            primitive.positions.iter().zip(used).filter(|(_, used)| *used).map(|(p, _)| *p)
        })
    }
}

impl Primitive {
    /// A third of the indices.
    pub fn triangle_count(&self) -> u64 {
        self.indices.len() as u64 / 3
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{EulerRot, Mat4, Quat, Vec3};

    #[test]
    fn bounds_are_those_of_all_vertices() {
        let positions: Vec<_> =
            (0..30).map(|i| Vec3::new((i as f32).sin(), (2.3 * i as f32).cos(), 0.1 * i as f32)).collect();
        let primitive = Primitive { indices: (0..30).collect(), positions: positions.clone(), ..Primitive::default() };
        let mut scene =
            Scene { meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }], ..Scene::default() };
        assert_eq!(scene.bounds(), None);
        for i in 0..200_u16 {
            let turn = Quat::from_euler(EulerRot::XYZ, f32::from(i), 0.7 * f32::from(i), 0.3);
            let aside = Vec3::new(f32::from(i % 7), f32::from(i % 11), f32::from(i % 13));
            let world_from_object = Mat4::from_rotation_translation(turn, aside);
            scene.objects.push(Object { name: String::new(), mesh: 0, world_from_object });
            let all = scene
                .objects
                .iter()
                .flat_map(|object| positions.iter().map(|&p| object.world_from_object.transform_point3(p)));
            assert_eq!(scene.bounds(), Aabb::around(all), "{i}");
        }
    }
}
