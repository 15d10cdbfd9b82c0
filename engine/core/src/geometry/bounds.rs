//! Axis-aligned bounding boxes.

use glam::{Mat4, Vec3};

/// An axis-aligned bounding box; `min` and `max` are in the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least coordinates.
    pub min: Vec3,
    /// Greatest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The smallest box around `points`; `None` around nothing.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = points.next()?;
        Some(points.fold(Self { min: first, max: first }, |b, p| Self { min: b.min.min(p), max: b.max.max(p) }))
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Middle of the box.
    pub fn center(self) -> Vec3 {
        self.min + self.size() * 0.5
    }

    /// Lengths of the edges.
    pub fn size(self) -> Vec3 {
        self.max - self.min
    }

    /// Radius of the sphere through the corners.
    pub fn radius(self) -> f32 {
        self.size().length() * 0.5
    }

    /// The eight corners; bit 0, 1, 2 of the index chooses x, y, z of `max`.
    pub fn corners(self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, low: f32, high: f32| if i >> bit & 1 == 0 { low } else { high };
            Vec3::new(pick(0, self.min.x, self.max.x), pick(1, self.min.y, self.max.y), pick(2, self.min.z, self.max.z))
        })
    }

    /// The box around the transformed corners, which holds the transformed contents.
    pub fn transformed(self, matrix: Mat4) -> Self {
        let [first, rest @ ..] = self.corners().map(|corner| matrix.transform_point3(corner));
        rest.iter().fold(Self { min: first, max: first }, |b, &p| Self { min: b.min.min(p), max: b.max.max(p) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_has_no_bounds() {
        assert_eq!(Aabb::around([]), None);
    }

    #[test]
    fn a_turned_box_holds_its_corners() {
        let unit = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
        let turned = unit.transformed(Mat4::from_rotation_z(std::f32::consts::FRAC_PI_4));
        let half = std::f32::consts::FRAC_1_SQRT_2;
        assert!((turned.min - Vec3::new(-half, 0.0, 0.0)).length() < 1e-6, "{turned:?}");
        assert!((turned.max - Vec3::new(half, 2.0 * half, 1.0)).length() < 1e-6, "{turned:?}");
    }
}
