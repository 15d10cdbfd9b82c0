#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/abuffer/node.glsl"
#include "transparency/distance.glsl"

// Visibility of each pixel as a step function of few nodes, then all layers as visible as it says (Salvi, Montgomery and
// Lefohn 2011, "Adaptive transparency", from sorted layers).

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 8) const uint KEPT = 8u;

layout(set = 0, binding = 5, rgba32f) uniform image2D color; // premultiplied
layout(set = 0, binding = 6, rgba32f) readonly uniform image2D spans; // first, count, nearest, farthest
layout(set = 0, binding = 22, rgba32ui) readonly uniform uimage2D nodes;

// Nearest first; one more than is kept.
uint step_place[KEPT + 1u]; // of the layer, among the pixel's
float step_distance[KEPT + 1u];
vec3 step_through[KEPT + 1u]; // behind it

// Takes away the step that changes the area under the function least: the one before takes its transmittance, so that what
// all layers let through stays exact.
void remove_least() {
    uint least = 1u;
    float least_area = 0.0;
    for (uint i = 1u; i <= KEPT; ++i) {
        float fall = mean_of(step_through[i - 1u]) - mean_of(step_through[i]);
        precise float area = (step_distance[i] - step_distance[i - 1u]) * fall;
        bool smaller = i == 1u || area < least_area;
        least = smaller ? i : least;
        least_area = smaller ? area : least_area;
    }
    step_through[least - 1u] = step_through[least];
    for (uint i = least; i < KEPT; ++i) {
        step_place[i] = step_place[i + 1u];
        step_distance[i] = step_distance[i + 1u];
        step_through[i] = step_through[i + 1u];
    }
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(color)))) {
        return;
    }
    vec4 span = imageLoad(spans, pixel);
    uint first = uint(span.x);
    uint count = uint(span.y);
    if (count == 0u) {
        return;
    }

    // 1. The function.
    uint steps = 0u;
    vec3 through = vec3(1.0);
    for (uint place = 0u; place < count; ++place) {
        uvec4 node = imageLoad(nodes, node_texel(first + place));
        through *= unpack_node(node, uvec4(0u)).through;
        step_place[steps] = place;
        step_distance[steps] = layer_distance(uintBitsToFloat(node.x));
        step_through[steps] = through;
        ++steps;
        if (steps > KEPT) {
            remove_least();
            steps = KEPT;
        }
    }

    // 2. All layers by it.
    vec3 rgb = vec3(0.0);
    vec3 visible = vec3(1.0);
    uint next = 0u;
    for (uint place = 0u; place < count; ++place) {
        rgb += visible * unpack_node(imageLoad(nodes, node_texel(first + place)), uvec4(0u)).rgb;
        if (next < steps && step_place[next] == place) {
            visible = step_through[next];
            ++next;
        }
    }
    imageStore(color, pixel, over_opaque(Gathered(rgb, through), imageLoad(color, pixel)));
}
