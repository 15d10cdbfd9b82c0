// A fragment of common/voxel_cover.glsl: the voxels of one row, along the axis that the triangle faces most.
#include "common/triangle_voxels.glsl"

layout(location = 0) flat in vec3 corner_a; // column coordinates
layout(location = 1) flat in vec3 corner_b;
layout(location = 2) flat in vec3 corner_c;

struct Row {
    Triangle triangle;
    ivec3 voxel; // of the row, its place along it 0
    uint axis;
    ivec2 part; // first and last to be asked; none where the first is greater
};

Row fragment_row() {
    Row row;
    row.triangle = triangle_of(vec3[](corner_a, corner_b, corner_c));
    uvec3 axes = facing(row.triangle.normal);
    row.axis = axes.z;
    row.voxel = ivec3(0);
    row.voxel[axes.x] = int(gl_FragCoord.x);
    row.voxel[axes.y] = int(gl_FragCoord.y);
    row.part = ivec2(1, 0);
    ivec3 along = ivec3(0);
    along[axes.z] = row.triangle.first[axes.z];
    ivec3 start = row.voxel + along;
    if (any(lessThan(start, row.triangle.first)) || any(greaterThan(start, row.triangle.last))) {
        return row;
    }
    // A long sliver has few rows of the rectangle around it.
    vec3 a = from_center(row.triangle.corners[0], row.voxel);
    vec3 b = from_center(row.triangle.corners[1], row.voxel);
    vec3 c = from_center(row.triangle.corners[2], row.voxel);
    vec2 across[3] = vec2[](
        vec2(a[axes.x], a[axes.y]), vec2(b[axes.x], b[axes.y]), vec2(c[axes.x], c[axes.y])
    );
    if (!separated(across[0], across[1], across[2], row.triangle.normal[axes.z])) {
        row.part = row_at_plane(row.triangle, row.voxel, axes.z);
    }
    return row;
}

// Whether the triangle makes up a voxel of its bounds.
bool makes_up(Triangle triangle, ivec3 voxel) {
    vec3 a = from_center(triangle.corners[0], voxel);
    vec3 b = from_center(triangle.corners[1], voxel);
    vec3 c = from_center(triangle.corners[2], voxel);
    return !separated(a.xy, b.xy, c.xy, triangle.normal.z) && meets(triangle, voxel);
}
