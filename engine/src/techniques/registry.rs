//! The list of techniques. A test walks it and fails where a technique lacks its shaders, its test, its docs page or
//! a seeded mutation that its test catches.

/// An entry of the registry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Technique {
    /// Family: folder of techniques that answer the same question.
    pub family: &'static str,
    /// Name: folder in the family.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
}

/// Every technique of this crate, by family and name.
pub static TECHNIQUES: &[Technique] = &[
    Technique {
        family: "shading",
        name: "lighting",
        summary: "deferred shading by punctual lights and a constant environment",
    },
    Technique { family: "shadow", name: "cascaded", summary: "cascaded shadow maps of a directional light" },
    Technique {
        family: "shadow",
        name: "deep",
        summary: "what comes through blended surfaces of a light's red, green and blue",
    },
    Technique {
        family: "shadow",
        name: "marched",
        summary: "shadows of any light by rays through voxels, without maps",
    },
    Technique { family: "shadow", name: "spot", summary: "a shadow map for each spot light" },
    Technique { family: "surface", name: "depth", summary: "depth pre-pass" },
    Technique { family: "surface", name: "gbuffer", summary: "geometry and material of the first opaque surface" },
    Technique { family: "surface", name: "position", summary: "world position and distance from depth" },
    Technique {
        family: "transparency",
        name: "abuffer",
        summary: "blended materials, every layer kept, sorted by depth and composited exactly",
    },
    Technique {
        family: "transparency",
        name: "adaptive",
        summary: "blended materials, as visible as a step function of few nodes tells",
    },
    Technique {
        family: "transparency",
        name: "depth_peeling",
        summary: "blended materials, every layer composited exactly, one a pass from the front",
    },
    Technique {
        family: "transparency",
        name: "dual_depth_peeling",
        summary: "blended materials, every layer composited, two a pass from both ends",
    },
    Technique {
        family: "transparency",
        name: "kbuffer",
        summary: "blended materials, the nearest layers exact, an average of the others behind them",
    },
    Technique {
        family: "transparency",
        name: "moments",
        summary: "blended materials, as visible as four moments of absorbance tell",
    },
    Technique {
        family: "transparency",
        name: "sorted",
        summary: "blended materials, forward-shaded, sorted by object",
    },
    Technique {
        family: "transparency",
        name: "stochastic",
        summary: "blended materials, as visible as random samples tell",
    },
    Technique {
        family: "transparency",
        name: "weighted",
        summary: "blended materials, averaged with weights that fall with distance, in one pass",
    },
    Technique {
        family: "voxel",
        name: "ambient_occlusion",
        summary: "how open the space around a surface is, by rays through voxels",
    },
    Technique { family: "voxel", name: "atlas", summary: "voxels that the texels of a surface's atlas lie in" },
    Technique {
        family: "voxel",
        name: "attributes",
        summary: "what surfaces are like in each voxel, averaged by area",
    },
    Technique { family: "voxel", name: "bitmask", summary: "solid voxelization by XOR of column bits, in one pass" },
    Technique { family: "voxel", name: "bricks", summary: "surface voxels of grids that would not fit as a whole" },
    Technique { family: "voxel", name: "conservative", summary: "every voxel that a triangle touches" },
    Technique { family: "voxel", name: "ray_marching", summary: "which points see which, through the bits of a grid" },
    Technique { family: "voxel", name: "six_separating", summary: "voxels of thin surfaces without leaks" },
    Technique { family: "voxel", name: "stencil", summary: "solid voxelization slice by slice, counted in a stencil" },
    Technique {
        family: "voxel",
        name: "vote",
        summary: "solids whose surfaces are not closed, by columns along three axes",
    },
    Technique { family: "voxel", name: "winding", summary: "solid voxelization by winding numbers, in one pass" },
];
