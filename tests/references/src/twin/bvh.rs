//! A bounding volume hierarchy over boxes, in double precision: binned surface-area heuristic (Wald 2007, "On fast
//! Construction of SAH-based Bounding Volume Hierarchies"), and a walk along a ray that misses nothing (Ize 2013,
//! "Robust BVH Ray Traversal": the far distance of a box is enlarged by the rounding error of the slab test).

use std::ops::ControlFlow;

use glam::DVec3;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Least corner.
    pub min: DVec3,
    /// Greatest corner.
    pub max: DVec3,
}

impl Bounds {
    /// Holds nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The box around points.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The box around two boxes.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Middle; NaN for the empty box.
    pub fn center(self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// From the least to the greatest corner.
    pub fn size(self) -> DVec3 {
        self.max - self.min
    }

    /// Half the surface area; 0 for the empty box.
    fn half_area(self) -> f64 {
        let s = self.size().max(DVec3::ZERO);
        s.x * s.y + s.y * s.z + s.z * s.x
    }

    /// Where a ray enters, if it passes through within `near..far`.
    fn entry(&self, origin: DVec3, inverse: DVec3, near: f64, far: f64) -> Option<f64> {
        const ROUNDING: f64 = 1.0 + 4.0 * f64::EPSILON;
        let (a, b) = ((self.min - origin) * inverse, (self.max - origin) * inverse);
        let (mut low, mut high) = (a.min(b), a.max(b));
        // 0 · ∞: a ray within the plane of a face does not leave the slab.
        let within = a.is_nan_mask() | b.is_nan_mask();
        if within.any() {
            low = DVec3::select(within, DVec3::NEG_INFINITY, low);
            high = DVec3::select(within, DVec3::INFINITY, high);
        }
        let (enter, leave) = (low.max_element().max(near), high.min_element() * ROUNDING);
        (enter <= leave.min(far)).then_some(enter)
    }
}

/// `count` > 0: a leaf with that many items from `first` of the order; else two children from `first` of the nodes.
struct Node {
    bounds: Bounds,
    first: u32,
    count: u32,
}

/// The hierarchy. Items are named by their index in the slice it was built over.
pub struct Bvh {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

const LEAF: usize = 4;
const BINS: usize = 16;
/// From here on a node is halved by count, so that the depth stays below [`STACK`].
const DEEP: u32 = 48;
const STACK: usize = 96;

impl Bvh {
    /// Builds the hierarchy over boxes, none of them empty.
    pub fn new(items: &[Bounds]) -> Self {
        let mut order: Vec<u32> = (0..items.len() as u32).collect();
        let mut nodes = Vec::with_capacity(items.len().max(1));
        nodes.push(Node { bounds: Bounds::EMPTY, first: 0, count: 0 });
        let mut pending = vec![(0_usize, 0_usize, items.len(), 0_u32)];
        while let Some((node, start, end, depth)) = pending.pop() {
            let slice = &mut order[start..end];
            nodes[node].bounds = slice.iter().fold(Bounds::EMPTY, |b, &i| b.union(items[i as usize]));
            if slice.len() <= LEAF {
                (nodes[node].first, nodes[node].count) = (start as u32, slice.len() as u32);
                continue;
            }
            let middle = start + split(slice, items, depth);
            let first = nodes.len();
            nodes[node].first = first as u32;
            nodes.extend([0, 0].map(|count| Node { bounds: Bounds::EMPTY, first: 0, count }));
            pending.push((first, start, middle, depth + 1));
            pending.push((first + 1, middle, end, depth + 1));
        }
        Self { nodes, order }
    }

    /// The box around everything.
    pub fn bounds(&self) -> Bounds {
        self.nodes[0].bounds
    }

    /// Visits the items whose boxes the ray passes within `near..far`, nearer boxes first. `visit` may lower `far`;
    /// it ends the walk with `Break`.
    pub fn walk(
        &self,
        origin: DVec3,
        direction: DVec3,
        near: f64,
        mut far: f64,
        mut visit: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) {
        if self.order.is_empty() {
            return;
        }
        let inverse = direction.recip();
        let mut stack = [(0_u32, 0.0_f64); STACK];
        let mut height = 0;
        if let Some(entry) = self.nodes[0].bounds.entry(origin, inverse, near, far) {
            stack[0] = (0, entry);
            height = 1;
        }
        while height > 0 {
            height -= 1;
            let (index, entry) = stack[height];
            if entry > far {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for &item in &self.order[node.first as usize..(node.first + node.count) as usize] {
                    if visit(item, &mut far).is_break() {
                        return;
                    }
                }
                continue;
            }
            let mut children = [node.first, node.first + 1]
                .map(|child| self.nodes[child as usize].bounds.entry(origin, inverse, near, far).map(|t| (child, t)));
            if let [Some(a), Some(b)] = children
                && a.1 < b.1
            {
                children.swap(0, 1);
            }
            for child in children.into_iter().flatten() {
                stack[height] = child;
                height += 1;
            }
        }
    }
}

/// Orders a slice of more than one item into two parts that are not empty, and gives the length of the first.
fn split(slice: &mut [u32], items: &[Bounds], depth: u32) -> usize {
    let center = |i: u32| items[i as usize].center();
    let centers = Bounds::of(slice.iter().map(|&i| center(i)));
    let extent = centers.size();
    let widest = if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    };
    let half = slice.len() / 2;
    if depth >= DEEP || extent[widest] <= 0.0 {
        slice.select_nth_unstable_by(half, |&a, &b| center(a)[widest].total_cmp(&center(b)[widest]).then(a.cmp(&b)));
        return half;
    }

    let bin = |i: u32| {
        let t = (center(i)[widest] - centers.min[widest]) / extent[widest];
        ((t * BINS as f64) as usize).min(BINS - 1)
    };
    let mut bins = [(Bounds::EMPTY, 0_usize); BINS];
    for &i in slice.iter() {
        let b = &mut bins[bin(i)];
        *b = (b.0.union(items[i as usize]), b.1 + 1);
    }
    let cost = |part: &[(Bounds, usize)]| {
        let (bounds, count) = part.iter().fold((Bounds::EMPTY, 0), |a, b| (a.0.union(b.0), a.1 + b.1));
        bounds.half_area() * count as f64
    };
    let cut = (1..BINS)
        .min_by(|&a, &b| {
            (cost(&bins[..a]) + cost(&bins[a..])).total_cmp(&(cost(&bins[..b]) + cost(&bins[b..]))).then(a.cmp(&b))
        })
        .unwrap_or(1);

    let mut first = 0;
    for k in 0..slice.len() {
        if bin(slice[k]) < cut {
            slice.swap(first, k);
            first += 1;
        }
    }
    // The least and the greatest centre lie in the first and the last bin, so neither part is empty.
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn visited(bvh: &Bvh, origin: DVec3, direction: DVec3, near: f64, far: f64) -> Vec<u32> {
        let mut all = Vec::new();
        bvh.walk(origin, direction, near, far, |i, _| {
            all.push(i);
            ControlFlow::Continue(())
        });
        all.sort_unstable();
        all
    }

    fn point() -> impl Strategy<Value = DVec3> {
        [-4_i32..5, -4..5, -4..5].prop_map(|p| DVec3::from(p.map(f64::from)))
    }

    proptest! {
        // Whole numbers make rays that run along faces, edges and through corners, and flat boxes.
        #[test]
        fn walks_through_every_box_that_the_ray_meets(
            boxes in prop::collection::vec((point(), point()), 0..60),
            origin in point(),
            direction in point(),
            repeat in 1_usize..4,
        ) {
            prop_assume!(direction != DVec3::ZERO);
            let boxes: Vec<_> = boxes.iter().map(|&(a, b)| Bounds::of([a, b])).collect();
            let boxes = boxes.repeat(repeat);
            let found = visited(&Bvh::new(&boxes), origin, direction, 0.0, f64::INFINITY);
            for (i, b) in boxes.iter().enumerate() {
                // A hundred points along the ray: whoever holds one must have been visited.
                let inside = (0..100).map(|k| origin + direction * (f64::from(k) / 8.0))
                    .any(|p| p.cmpge(b.min).all() && p.cmple(b.max).all());
                if inside {
                    prop_assert!(found.binary_search(&(i as u32)).is_ok(), "box {i} was missed");
                }
            }
        }
    }

    #[test]
    fn deep_and_equal_boxes_stay_within_the_stack() {
        // Centres that halve again and again defeat binning; equal boxes cannot be told apart.
        let halving = (0..4000).map(|k| DVec3::splat(0.5_f64.powi(k % 1000)));
        let boxes: Vec<_> = halving.map(|p| Bounds::of([p, p])).collect();
        assert_eq!(visited(&Bvh::new(&boxes), DVec3::ZERO, DVec3::ONE, 0.0, 2.0).len(), 4000);
    }

    #[test]
    fn leaves_out_what_lies_behind_or_beyond() {
        let boxes: Vec<_> =
            (0..100).map(|k| DVec3::X * f64::from(k)).map(|p| Bounds::of([p, p + DVec3::ONE * 0.5])).collect();
        let found = visited(&Bvh::new(&boxes), DVec3::new(10.2, 0.1, 0.1), DVec3::X, 0.0, 5.0);
        assert!(found.contains(&10) && found.contains(&15) && found.len() < 20, "{found:?}");
        assert!(visited(&Bvh::new(&[]), DVec3::ZERO, DVec3::X, 0.0, 1.0).is_empty());
    }
}
