// Where a triangle lies in an atlas of square texels.

layout(push_constant, scalar) uniform AtlasPush {
    vec2 texels; // a unit of what the layout is in
    vec2 first; // of the layout, in these
    float side; // of the atlas in texels
};

// A layout so thin, in texels, holds a texel by chance, and its gradients are mostly rounding.
const float THIN = 1.0 / 64.0;

// `corner` of the layout's corners; outside of the atlas, all three of them, where it is thin.
vec4 place_in_atlas(vec2 corners[3], uint corner) {
    vec2 a = (corners[0] - first) * texels;
    vec2 b = (corners[1] - first) * texels;
    vec2 c = (corners[2] - first) * texels;
    precise float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    precise float longest = max(distance(a, b), max(distance(b, c), distance(c, a)));
    if (!(abs(area) > THIN * longest)) {
        return vec4(-2.0, -2.0, 0.5, 1.0);
    }
    vec2 p = corner == 0u ? a : corner == 1u ? b : c;
    return vec4(2.0 * p / side - 1.0, 0.5, 1.0);
}
