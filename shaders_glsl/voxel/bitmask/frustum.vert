#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"
#include "common/instance_transform.glsl"

// Looks along a camera's lines of sight: a pixel is a column. As in common/voxel_columns.glsl, vertices are put where the
// rasteriser would snap them, and what lies beyond the voxels is drawn too. What lies before them is cut off: it marks no
// voxel, and nothing behind the eye can be drawn.

layout(constant_id = 0) const uint SUBPIXELS = 256u; // places a pixel that the rasteriser knows

layout(set = 0, binding = 3, scalar) uniform Frustum {
    vec4 clip_x; // rows: of clip space,
    vec4 clip_y;
    vec4 clip_w;
    vec4 slices; // and slices from the far end towards the eye
    float nearest; // w that triangles are cut at
};

layout(location = 0) in vec3 position;

layout(location = 0) out float out_depth; // slices

void main() {
    vec4 world = vec4(transform_point(world_from_object(), position), 1.0);
    vec2 p = vec2(dot(clip_x, world), dot(clip_y, world));
    float w = dot(clip_w, world);
    if (w >= nearest) {
        vec2 size = vec2(columns.xy);
        vec2 pixel = (p / w + 1.0) * 0.5 * size;
        vec2 snapped = round(pixel * float(SUBPIXELS)) / float(SUBPIXELS);
        p = (2.0 * snapped / size - 1.0) * w;
    }
    gl_Position = vec4(p, nearest, w);
    out_depth = dot(slices, world);
}
