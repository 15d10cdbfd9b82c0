//! What a camera sees of a surface: glTF 2.0, section 3.9.
//!
//! - Vertex normals go to world space by the inverse transpose (its sign kept on the front of mirrored objects) and
//!   are normalised there, tangents by the linear part of the transform; both are interpolated and normalised again.
//! - Bitangent: `cross(normal, tangent) · w`, of the interpolated and normalised vectors; w changes its sign on mirrored
//!   objects. Where the tangent is zero, the normal map is passed over.
//! - Normal map: `(2 · texel − 1) · (scale, scale, 1)`, taken to world space by tangent, bitangent and normal, then
//!   normalised.
//! - Seen from behind, both normals are reversed.
//! - Base colour: factor · texture · vertex colour. Occlusion: `1 + strength · (texel − 1)`.

use glam::{DVec2, DVec3, DVec4};
use shadowgraph::scene::{Primitive, TextureSlot};

use super::scene::{Footprint, Hit, Ray, Scene, Triangle};
use super::texture::level_of_detail;

/// A point of a surface as the G-buffer describes it.
#[derive(Clone, Debug)]
pub struct Surface {
    /// World space, metres.
    pub position: DVec3,
    /// Unit normal of the triangle, world space, towards the viewer.
    pub flat_normal: DVec3,
    /// Interpolated unit normal, world space.
    pub smooth_normal: DVec3,
    /// The interpolated normal turned by the normal map; the same where there is none.
    pub normal: DVec3,
    /// Object, triangle of the mesh, material: counted from 1, as in the `id` layers.
    pub ids: [u32; 3],
    /// Linear RGBA.
    pub base_color: DVec4,
    /// 0 to 1.
    pub metallic: f64,
    /// Perceptual roughness, 0 to 1.
    pub roughness: f64,
    /// 0 (dark) to 1.
    pub occlusion: f64,
    /// Linear radiance.
    pub emissive: DVec3,
    /// Share of the light that enters and passes, 0 to 1.
    pub transmission: f64,
    /// Seen from the front.
    pub front: bool,
}

impl Scene<'_> {
    /// The surface where a ray hits.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        // 1. The triangle seen
        let triangle = &self.triangles[hit.triangle as usize];
        let material = &self.source.materials[triangle.material as usize];
        let placement = &self.placements[triangle.object as usize];
        let primitive = self.primitive(triangle);
        let side = if hit.front { 1.0 } else { -1.0 };

        // 2. Normals
        let flat_normal = triangle.winding_normal() * placement.handedness * side;
        let interpolate = |vertex: &dyn Fn(usize) -> DVec3| {
            let [a, b, c] = triangle.vertices.map(|v| vertex(v as usize));
            (a * hit.weights.x + b * hit.weights.y + c * hit.weights.z).normalize_or_zero()
        };
        let normal = interpolate(&|v| (placement.normal * primitive.normals[v].as_dvec3()).normalize_or_zero());
        let tangent =
            interpolate(&|v| (placement.linear * primitive.tangents[v].truncate().as_dvec3()).normalize_or_zero());
        let mut mapped = normal;
        if let Some(slot) = &material.normal_texture
            && tangent != DVec3::ZERO
        {
            let sign = f64::from(primitive.tangents[triangle.vertices[0] as usize].w) * placement.handedness;
            let bitangent = normal.cross(tangent) * sign;
            let texel = self.sample(triangle, hit.weights, ray, slot, false).truncate() * 2.0 - 1.0;
            let scale = f64::from(material.normal_scale);
            mapped = (tangent * texel.x * scale + bitangent * texel.y * scale + normal * texel.z).normalize_or_zero();
        }

        // 3. The rest of the material
        let value = |slot: &Option<TextureSlot>, srgb: bool| {
            slot.as_ref().map_or(DVec4::ONE, |slot| self.sample(triangle, hit.weights, ray, slot, srgb))
        };
        let rough_metal = value(&material.metallic_roughness_texture, false);
        let occlusion = value(&material.occlusion_texture, false).x;
        Surface {
            position: ray.line.at(hit.t),
            flat_normal,
            smooth_normal: normal * side,
            normal: mapped * side,
            ids: [triangle.object, triangle.number, triangle.material].map(|id| id + 1),
            base_color: self.base_color(triangle, hit.weights, ray),
            metallic: f64::from(material.metallic) * rough_metal.z,
            roughness: f64::from(material.roughness) * rough_metal.y,
            occlusion: 1.0 + f64::from(material.occlusion_strength) * (occlusion - 1.0),
            emissive: material.emissive.as_dvec3() * value(&material.emissive_texture, true).truncate(),
            transmission: f64::from(material.transmission) * value(&material.transmission_texture, false).x,
            front: hit.front,
        }
    }

    pub(super) fn base_color(&self, triangle: &Triangle, weights: DVec3, ray: &Ray) -> DVec4 {
        let material = &self.source.materials[triangle.material as usize];
        let primitive = self.primitive(triangle);
        let [a, b, c] = triangle.vertices.map(|v| primitive.colors[v as usize].as_dvec4());
        let color = material.base_color.as_dvec4() * (a * weights.x + b * weights.y + c * weights.z);
        match &material.base_color_texture {
            Some(slot) => color * self.sample(triangle, weights, ray, slot, true),
            None => color,
        }
    }

    fn primitive(&self, triangle: &Triangle) -> &Primitive {
        let mesh = self.source.objects[triangle.object as usize].mesh;
        &self.source.meshes[mesh].primitives[triangle.primitive as usize]
    }

    fn sample(&self, triangle: &Triangle, weights: DVec3, ray: &Ray, slot: &TextureSlot, srgb: bool) -> DVec4 {
        let texture = &self.source.textures[slot.texture];
        let uvs = &self.primitive(triangle).uvs[slot.uv_set];
        let transform = slot.transform.as_dmat3();
        let corners = triangle.vertices.map(|v| transform.transform_point2(uvs[v as usize].as_dvec2()));
        let at = |w: DVec3| corners[0] * w.x + corners[1] * w.y + corners[2] * w.z;
        let lambda = match &ray.footprint {
            Footprint::Point => f64::NEG_INFINITY,
            Footprint::Width(width) => {
                let [a, b, c] = triangle.positions;
                let area = (b - a).cross(c - a).length();
                let uv_area = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]).abs();
                let along = DVec2::splat(width * (uv_area / area).sqrt());
                level_of_detail(texture.size, along * DVec2::X, along * DVec2::Y)
            }
            Footprint::Quad(quad) => {
                let [here, right, below] = quad.map(|line| at(triangle.weights(&line)));
                level_of_detail(texture.size, right - here, below - here)
            }
        };
        self.levels(slot.texture, srgb).sample(texture, at(weights), lambda)
    }
}
