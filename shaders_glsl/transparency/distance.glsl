// How far fragments are, from their depth.

layout(set = 0, binding = 21, scalar) uniform LayerDistances {
    vec4 row; // distance along the view axis is (x · depth + y) / (z · depth + w)
} distances;

// Along the view axis, metres.
float layer_distance(float depth) {
    vec2 parts = vec2(dot(distances.row.xy, vec2(depth, 1.0)), dot(distances.row.zw, vec2(depth, 1.0)));
    return parts.x / parts.y;
}
