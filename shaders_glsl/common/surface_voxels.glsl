// Which voxels make up a triangle? Either all whose closed box it touches, by separating axes (Akenine-Möller 2001), or
// with SIX_SEPARATING as few as no path through faces of voxels slips by (Schwarz and Seidel 2010, section 4): those
// whose three diagonals from face to face it meets, in each projection. Differences from the voxel's centre are taken
// before any product, so that what lies on the grid's planes is not lost to rounding.
#include "common/voxels.glsl"
#include "common/instances.glsl"

layout(set = 0, binding = 2, scalar) buffer Bits {
    uint bits[];
};
layout(set = 0, binding = 3, scalar) readonly buffer TriangleStarts {
    uint triangle_starts[]; // by instance, then the number of all triangles
};
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

// The instance with a triangle: the last one that begins at it or before.
uint instance_of(uint triangle) {
    uint first = 0u;
    uint end = touch.instance_count;
    while (end - first > 1u) {
        uint middle = (first + end) / 2u;
        if (triangle_starts[middle] <= triangle) {
            first = middle;
        } else {
            end = middle;
        }
    }
    return first;
}

Triangle triangle_at(uint number) {
    uint place = instance_of(number);
    Instance instance = instances[place];
    uint index = instance.first_index + 3u * (number - triangle_starts[place]);
    Triangle triangle;
    for (uint i = 0u; i < 3u; ++i) {
        vec3 position = positions[uint(int(indices[index + i]) + instance.vertex_offset)];
        triangle.corners[i] = column_coordinates(transform_point(instance, position));
    }
    // The longest edge goes from the second corner to the third: the normal of the two others is the most exact.
    vec3 a = triangle.corners[0];
    vec3 b = triangle.corners[1];
    vec3 c = triangle.corners[2];
    vec3 squared = vec3(dot(b - c, b - c), dot(c - a, c - a), dot(a - b, a - b));
    if (squared.y > max(squared.x, squared.z)) {
        triangle.corners = vec3[](b, c, a);
    } else if (squared.z > squared.x) {
        triangle.corners = vec3[](c, a, b);
    }
    a = triangle.corners[0];
    b = triangle.corners[1];
    c = triangle.corners[2];
    triangle.normal = cross(b - a, c - a);
    // A sliver's normal is mostly rounding: the less it says, the less it decides.
    triangle.slack = 3e-7 * length(b - a) * length(c - a);
    vec3 grid = vec3(columns);
    triangle.first = ivec3(clamp(ceil(min(a, min(b, c)) - 0.5 - touch.reach), vec3(0.0), grid));
    triangle.last = ivec3(clamp(floor(max(a, max(b, c)) - 0.5 + touch.reach), vec3(-1.0), grid - 1.0));
    return triangle;
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
    vec2 outward = side >= 0.0 ? vec2(b.y - a.y, a.x - b.x) : vec2(a.y - b.y, b.x - a.x);
    return -dot(outward, a) > extent(outward);
}

bool separated(vec2 a, vec2 b, vec2 c, float side) {
    return outside(a, b, side) || outside(b, c, side) || outside(c, a, side);
}
#else
float extent(vec3 n) {
    n = abs(n);
    return touch.reach * (n.x + n.y + n.z);
}

// Whether an edge's normal in a plane of two axes separates a square around the origin from the triangle.
bool separates(vec2 edge, vec2 a, vec2 b, vec2 c) {
    vec2 axis = vec2(-edge.y, edge.x);
    vec3 along = vec3(dot(axis, a), dot(axis, b), dot(axis, c));
    float radius = touch.reach * (abs(axis.x) + abs(axis.y));
    return min(along.x, min(along.y, along.z)) > radius || max(along.x, max(along.y, along.z)) < -radius;
}

bool separated(vec2 a, vec2 b, vec2 c, float side) {
    return separates(b - a, a, b, c) || separates(c - b, a, b, c) || separates(a - c, a, b, c);
}
#endif

// Sets the voxels of a column that the triangle touches.
void mark_column(Triangle triangle, ivec2 column) {
    vec3 origin = vec3(vec2(column) + 0.5, 0.5);
    vec3 a = triangle.corners[0] - origin;
    vec3 b = triangle.corners[1] - origin;
    vec3 c = triangle.corners[2] - origin;
    vec3 n = triangle.normal;
    if (separated(a.xy, b.xy, c.xy, n.z)) {
        return;
    }
    float spread = extent(n) + triangle.slack * length(a);
    // Where the plane passes through the column, a voxel more on either side for the rounding of the quotient.
    int first = triangle.first.z;
    int last = triangle.last.z;
    if (abs(n.z) * 1e6 > spread) {
        float middle = dot(n, a) / n.z;
        float half_height = spread / abs(n.z) + 1.0;
        first = max(first, int(floor(clamp(middle - half_height, -1.0, 4096.0))));
        last = min(last, int(ceil(clamp(middle + half_height, -1.0, 4096.0))));
    }
    uint word = uint(first) / 32u;
    uint found = 0u;
    for (int k = first; k <= last; ++k) {
        if (uint(k) / 32u != word) {
            if (found != 0u) {
                atomicOr(bits[word_index(uvec2(column), word)], found);
            }
            word = uint(k) / 32u;
            found = 0u;
        }
        vec3 up = vec3(0.0, 0.0, float(k));
        vec3 p = a - up;
        vec3 q = b - up;
        vec3 r = c - up;
        float height = abs(dot(n, p)) - extent(n) - triangle.slack * length(p);
        if (height <= 0.0 && !separated(p.yz, q.yz, r.yz, n.x) && !separated(p.zx, q.zx, r.zx, n.y)) {
            found |= 1u << (uint(k) % 32u);
        }
    }
    if (found != 0u) {
        atomicOr(bits[word_index(uvec2(column), word)], found);
    }
}
