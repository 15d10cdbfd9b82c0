// Triangles of a scene by number, and the voxels that one makes up: column by column, `take` is told which of a word it
// found. Whoever includes this says what becomes of them.
#include "common/triangle_voxels.glsl"

layout(set = 0, binding = 3, scalar) readonly buffer TriangleStarts {
    uint triangle_starts[]; // by instance, then the number of all triangles
};

// Of the triangle that was last asked for: its instance, and where its indices begin.
uint taken_instance = 0u;
uint taken_place = 0u;

// `found`: bits of voxels 32 · word to 32 · word + 31 of a column; some is set.
void take(uvec2 column, uint word, uint found);

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
    taken_instance = instance_of(number);
    Instance instance = instances[taken_instance];
    taken_place = instance.first_index + 3u * (number - triangle_starts[taken_instance]);
    return triangle_of(corners_at(instance, taken_place));
}

// Tells of the voxels of a column that the triangle makes up.
void visit_column(Triangle triangle, ivec2 column) {
    vec3 a = from_center(triangle.corners[0], ivec3(column, 0));
    vec3 b = from_center(triangle.corners[1], ivec3(column, 0));
    vec3 c = from_center(triangle.corners[2], ivec3(column, 0));
    if (separated(a.xy, b.xy, c.xy, triangle.normal.z)) {
        return;
    }
    ivec2 row = row_at_plane(triangle, ivec3(column, 0), 2u);
    uint word = uint(row.x) / 32u;
    uint found = 0u;
    for (int k = row.x; k <= row.y; ++k) {
        if (uint(k) / 32u != word) {
            if (found != 0u) {
                take(uvec2(column), word, found);
            }
            word = uint(k) / 32u;
            found = 0u;
        }
        ivec3 voxel = ivec3(column, k);
        if (meets(triangle, voxel)) {
            found |= 1u << (uint(k) % 32u);
        }
    }
    if (found != 0u) {
        take(uvec2(column), word, found);
    }
}
