// Triangles of a scene by number, and the voxels of a column that one makes up.
#include "common/triangle_voxels.glsl"

layout(set = 0, binding = 2, scalar) buffer Bits {
    uint bits[];
};
layout(set = 0, binding = 3, scalar) readonly buffer TriangleStarts {
    uint triangle_starts[]; // by instance, then the number of all triangles
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
    return triangle_of(corners_at(instance, instance.first_index + 3u * (number - triangle_starts[place])));
}

// Sets the voxels of a column that the triangle makes up.
void mark_column(Triangle triangle, ivec2 column) {
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
                atomicOr(bits[word_index(uvec2(column), word)], found);
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
        atomicOr(bits[word_index(uvec2(column), word)], found);
    }
}
