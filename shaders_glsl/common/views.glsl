// The views of a pass: one for a camera, several for cascades, cube faces, slices.
// Uniform blocks and not storage buffers wherever a pixel reads: software drivers load the former once for all
// lanes, the latter lane by lane.
// A shader that includes this picks its view with VIEW_INDEX; `_multiview` files define MULTIVIEW.

struct ViewData {
    mat4 clip_from_world;
    mat4 view_from_world;
    mat4 world_from_view;
    mat4 view_from_clip;
    vec4 eye; // w 1: position; w 0: direction to an orthographic viewer
    vec2 size; // pixels
};

const uint MAX_VIEWS = 8u;

layout(set = 0, binding = 0, scalar) uniform Views {
    ViewData views[MAX_VIEWS];
};

// View-space position of a texel of a depth buffer. `pixel` counts from the upper left, centres at halves.
vec3 view_position(uint view, vec2 pixel, float depth) {
    vec2 ndc = pixel / views[view].size * 2.0 - 1.0;
    vec4 position = views[view].view_from_clip * vec4(ndc, depth, 1.0);
    return position.xyz / position.w;
}

// Unit vector from a world-space point to the viewer.
vec3 direction_to_eye(uint view, vec3 position) {
    return normalize(views[view].eye.xyz - views[view].eye.w * position);
}
