// The views of a pass: one for a camera, several for cascades, cube faces, slices.
// A shader that includes this picks its view with VIEW_INDEX; `_multiview` files define MULTIVIEW.

struct ViewData {
    mat4 clip_from_world;
    mat4 view_from_world;
    mat4 world_from_view;
    mat4 view_from_clip;
    vec4 eye; // w 1: position; w 0: direction to an orthographic viewer
    vec2 size; // pixels
};

layout(set = 0, binding = 0, scalar) readonly buffer Views {
    ViewData views[];
};

// View-space position of a texel of a depth buffer. `pixel` counts from the upper left, centres at halves.
vec3 view_position(ViewData view, vec2 pixel, float depth) {
    vec2 ndc = pixel / view.size * 2.0 - 1.0;
    vec4 position = view.view_from_clip * vec4(ndc, depth, 1.0);
    return position.xyz / position.w;
}

// Unit vector from a world-space point to the viewer.
vec3 direction_to_eye(ViewData view, vec3 position) {
    return normalize(view.eye.xyz - view.eye.w * position);
}
