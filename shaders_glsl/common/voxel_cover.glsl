// Draws each triangle over all columns of voxels that it may touch, looking along the axis it faces most: its corners are
// moved apart until its edges have passed the corners of every pixel (Hasselgren et al. 2005, "Conservative
// Rasterization", GPU Gems 2). A sliver's corners would go far, and so may those of a triangle that leaves the grid:
// twice the rectangle of its bounds covers it as well. What is covered is tested by the fragment stage. Vertices are
// pulled: each knows its whole triangle, as in a geometry shader, which not every device has.
#include "common/triangle_voxels.glsl"

layout(location = 0) flat out vec3 out_a; // corners, column coordinates
layout(location = 1) flat out vec3 out_b;
layout(location = 2) flat out vec3 out_c;

// More than rasterisers snap corners by, in pixels.
const float SNAP = 0.125;
// How far a corner may move, in pixels, and where it may lie.
const float FAR = 8.0;
const float MOST = 4096.0;
// A rectangle of so few pixels has no more to test than a triangle moved apart.
const int FEW = 4;

// A corner's way, where the edges that meet there move by `reach` along both axes.
vec2 moved(vec2 into, vec2 from, float side, float reach) {
    vec2 n = side * vec2(into.y, -into.x);
    vec2 m = side * vec2(from.y, -from.x);
    float d = reach * (abs(n.x) + abs(n.y));
    float e = reach * (abs(m.x) + abs(m.y));
    return vec2(d * m.y - e * n.y, n.x * e - m.x * d) / (n.x * m.y - n.y * m.x);
}

// `place`: of the vertex, in the index buffer.
void cover_triangle(Instance instance, uint place) {
    uint corner = (place - instance.first_index) % 3u;
    vec3 corners[3] = corners_at(instance, place - corner);
    out_a = corners[0];
    out_b = corners[1];
    out_c = corners[2];
    Triangle triangle = triangle_of(corners);
    uvec3 axes = facing(triangle.normal);
    ivec2 first = ivec2(triangle.first[axes.x], triangle.first[axes.y]);
    ivec2 size = ivec2(triangle.last[axes.x], triangle.last[axes.y]) - first + 1;
    if (any(lessThanEqual(triangle.last - triangle.first + 1, ivec3(0)))) {
        gl_Position = vec4(-2.0, -2.0, 0.5, 1.0);
        return;
    }

    vec2 p = vec2(corners[corner][axes.x], corners[corner][axes.y]);
    vec2 q = vec2(corners[(corner + 1u) % 3u][axes.x], corners[(corner + 1u) % 3u][axes.y]);
    vec2 r = vec2(corners[(corner + 2u) % 3u][axes.x], corners[(corner + 2u) % 3u][axes.y]);
    // All three corners decide alike.
    float area = abs(triangle.normal[axes.z]);
    vec3 b = triangle.corners[1] - triangle.corners[2];
    float reach = touch.reach + SNAP;
    vec3 farthest = max(abs(corners[0]), max(abs(corners[1]), abs(corners[2])));
    bool is_near = max(farthest.x, max(farthest.y, farthest.z)) < MOST && 3.0 * reach * dot(b, b) < FAR * area;
    vec2 at = vec2(first) + 2.0 * vec2(size) * vec2(corner == 1u, corner == 2u);
    if (is_near && size.x * size.y > FEW) {
        float turn = (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
        at = p + moved(p - r, q - p, turn < 0.0 ? -1.0 : 1.0, reach);
    }
    uint side = max(columns.x, max(columns.y, columns.z));
    gl_Position = vec4(2.0 * at / float(side) - 1.0, 0.5, 1.0);
}
