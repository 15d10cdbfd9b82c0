// Where layers lie between the nearest and the farthest, from -1 to 1, by the logarithm of their distance (Münstermann,
// Krumpen, Klein and Peters 2018, "Moment-based order-independent transparency", section 3.4).
#include "transparency/distance.glsl"

layout(set = 0, binding = 26, scalar) uniform MomentRange {
    float nearest; // logarithm of metres
    float scale; // 2 / (logarithm of the farthest - nearest)
} moment_range;

float moment_depth(float depth) {
    float z = (log(max(layer_distance(depth), 1e-30)) - moment_range.nearest) * moment_range.scale - 1.0;
    return clamp(z, -1.0, 1.0);
}
