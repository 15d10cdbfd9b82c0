// Which voxels make up a triangle? Either all whose closed box it touches, by separating axes (Akenine-Möller 2001), or
// with SIX_SEPARATING as few as no path through faces of voxels slips by (Schwarz and Seidel 2010, section 4): those
// whose three diagonals from face to face it meets, in each projection. Differences from the voxel's centre are taken
// before any product, so that what lies on the grid's planes is not lost to rounding. What decides is `precise`: every
// shader that asks gets the same answer.
#include "common/voxels.glsl"
#include "common/instances.glsl"

layout(set = 0, binding = 4, scalar) readonly buffer Indices {
    uint indices[];
};
layout(set = 0, binding = 5, scalar) readonly buffer Positions {
    vec3 positions[];
};
layout(set = 0, binding = 6, scalar) uniform Touch {
    uint instance_count;
    uint triangle_count;
    float reach; // half a voxel, and what rounding may take away, in voxels
} touch;

struct Triangle {
    vec3 corners[3]; // column coordinates
    vec3 normal; // not of unit length
    float slack; // error of `normal` for each voxel of distance
    ivec3 first; // voxels of its bounds within the grid
    ivec3 last;
};

vec3 corner_at(Instance instance, uint place) {
    vec4 position = vec4(positions[uint(int(indices[place]) + instance.vertex_offset)], 1.0);
    precise vec3 world = vec3(
        dot(instance.world_from_object[0], position),
        dot(instance.world_from_object[1], position),
        dot(instance.world_from_object[2], position)
    );
    precise vec3 p = (world - voxel_grid_min) / voxel_edge;
    return in_columns(p);
}

// Corners in column coordinates of the triangle whose indices begin at `place`.
vec3[3] corners_at(Instance instance, uint place) {
    return vec3[](corner_at(instance, place), corner_at(instance, place + 1u), corner_at(instance, place + 2u));
}

Triangle triangle_of(vec3 corners[3]) {
    // The longest edge goes from the second corner to the third: the normal of the two others is the most exact.
    Triangle triangle;
    triangle.corners = corners;
    vec3 a = corners[0];
    vec3 b = corners[1];
    vec3 c = corners[2];
    precise vec3 squared = vec3(dot(b - c, b - c), dot(c - a, c - a), dot(a - b, a - b));
    if (squared.y > max(squared.x, squared.z)) {
        triangle.corners = vec3[](b, c, a);
    } else if (squared.z > squared.x) {
        triangle.corners = vec3[](c, a, b);
    }
    a = triangle.corners[0];
    b = triangle.corners[1];
    c = triangle.corners[2];
    precise vec3 normal = cross(b - a, c - a);
    // A sliver's normal is mostly rounding: the less it says, the less it decides.
    precise float slack = 3e-7 * length(b - a) * length(c - a);
    triangle.normal = normal;
    triangle.slack = slack;
    vec3 grid = vec3(columns);
    precise vec3 first = ceil(min(a, min(b, c)) - 0.5 - touch.reach);
    precise vec3 last = floor(max(a, max(b, c)) - 0.5 + touch.reach);
    triangle.first = ivec3(clamp(first, vec3(0.0), grid));
    triangle.last = ivec3(clamp(last, vec3(-1.0), grid - 1.0));
    return triangle;
}

// Of a point, seen from the centre of a voxel.
vec3 from_center(vec3 point, ivec3 voxel) {
    precise vec3 p = point - vec3(vec2(voxel.xy) + 0.5, 0.5);
    precise float up = p.z - float(voxel.z);
    return vec3(p.xy, up);
}

#ifdef SIX_SEPARATING
// How far the voxel reaches along a direction, for a plane and in a projection.
float extent(vec3 n) {
    n = abs(n);
    return 0.5 * max(n.x, max(n.y, n.z));
}

float extent(vec2 n) {
    n = abs(n);
    return 0.5 * max(n.x, n.y);
}

// Whether the voxel lies outside an edge from `a` to `b`; `side` is positive where the corners run counter-clockwise.
bool outside(vec2 a, vec2 b, float side) {
    precise vec2 outward = side >= 0.0 ? vec2(b.y - a.y, a.x - b.x) : vec2(a.y - b.y, b.x - a.x);
    precise float beyond = -dot(outward, a);
    return beyond > extent(outward);
}

bool separated(vec2 a, vec2 b, vec2 c, float side) {
    return outside(a, b, side) || outside(b, c, side) || outside(c, a, side);
}
#else
float extent(vec3 n) {
    n = abs(n);
    precise float e = touch.reach * (n.x + n.y + n.z);
    return e;
}

// Whether an edge's normal in a plane of two axes separates a square around the origin from the triangle.
bool separates(vec2 edge, vec2 a, vec2 b, vec2 c) {
    vec2 axis = vec2(-edge.y, edge.x);
    precise vec3 along = vec3(dot(axis, a), dot(axis, b), dot(axis, c));
    precise float radius = touch.reach * (abs(axis.x) + abs(axis.y));
    return min(along.x, min(along.y, along.z)) > radius || max(along.x, max(along.y, along.z)) < -radius;
}

bool separated(vec2 a, vec2 b, vec2 c, float side) {
    return separates(b - a, a, b, c) || separates(c - b, a, b, c) || separates(a - c, a, b, c);
}
#endif

// Whether the triangle makes up a voxel of its bounds, where their projections along the columns are not separated.
bool meets(Triangle triangle, ivec3 voxel) {
    vec3 a = from_center(triangle.corners[0], voxel);
    vec3 b = from_center(triangle.corners[1], voxel);
    vec3 c = from_center(triangle.corners[2], voxel);
    vec3 n = triangle.normal;
    // From the nearest corner the normal's error weighs least.
    precise vec3 squared = vec3(dot(a, a), dot(b, b), dot(c, c));
    float least = min(squared.x, min(squared.y, squared.z));
    vec3 near = squared.x == least ? a : squared.y == least ? b : c;
    precise float height = abs(dot(n, near)) - extent(n) - triangle.slack * sqrt(least);
    return height <= 0.0 && !separated(a.yz, b.yz, c.yz, n.x) && !separated(a.zx, b.zx, c.zx, n.y);
}

// From where to where along an axis the plane of the triangle passes through a voxel's row, within the triangle's bounds
// and with a voxel more on either side for the rounding of the quotient.
ivec2 row_at_plane(Triangle triangle, ivec3 voxel, uint axis) {
    int first = triangle.first[axis];
    int last = triangle.last[axis];
    voxel[axis] = 0;
    vec3 a = from_center(triangle.corners[0], voxel);
    float rise = triangle.normal[axis];
    // Other corners than the first may be asked: they are as far at most, and the edge to them twice as far.
    float spread = extent(triangle.normal) + 3.0 * triangle.slack * (length(a) + float(last));
    if (abs(rise) * 1e6 > spread) {
        float middle = dot(triangle.normal, a) / rise;
        float half_height = spread / abs(rise) + 1.0;
        first = max(first, int(floor(clamp(middle - half_height, -1.0, 4096.0))));
        last = min(last, int(ceil(clamp(middle + half_height, -1.0, 4096.0))));
    }
    return ivec2(first, last);
}

// Two axes across and the one that a triangle faces most, in column coordinates.
uvec3 facing(vec3 normal) {
    vec3 n = abs(normal);
    return n.x > max(n.y, n.z) ? uvec3(1u, 2u, 0u) : n.y > n.z ? uvec3(2u, 0u, 1u) : uvec3(0u, 1u, 2u);
}
