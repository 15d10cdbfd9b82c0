// Looks along the columns of a voxel grid: a pixel is a column. Vertices are put where the rasteriser would snap them: a
// column that passes through a triangle by its snapped corners alone would otherwise take its depth from the plane beyond
// the triangle, which for a steep one is far off. Depth takes no part in clipping: what lies before or behind the grid
// must reach the fragment shader too, or columns would lose a crossing.
#include "common/voxels.glsl"
#include "common/instance_transform.glsl"

layout(constant_id = 0) const uint SUBPIXELS = 256u; // places a pixel that the rasteriser knows

layout(location = 0) in vec3 position;

layout(location = 0) out float out_depth; // voxels

// Where the vertex lies across the columns.
vec2 snapped_column() {
    vec3 p = column_coordinates(transform_point(world_from_object(), position));
    out_depth = p.z;
    return round(p.xy * float(SUBPIXELS)) / float(SUBPIXELS);
}

void look_along_columns() {
    gl_Position = vec4(2.0 * snapped_column() / vec2(columns.xy) - 1.0, 0.5, 1.0);
}
