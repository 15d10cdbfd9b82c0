// The part of a triangle in a voxel: its area, and its middle in barycentric coordinates.

struct Part {
    float share; // of the triangle's area
    vec3 middle;
};

// A triangle and six planes give nine corners at most.
const int MOST_CORNERS = 9;

// Of the point of a triangle that is about nearest to the origin, where it lies just beside the triangle.
vec3 nearest(vec3 a, vec3 b, vec3 c) {
    vec3 n = cross(b - a, c - a);
    float squared = dot(n, n);
    if (squared <= 0.0) {
        return vec3(1.0 / 3.0);
    }
    vec3 weights = clamp(vec3(dot(n, cross(b, c)), dot(n, cross(c, a)), dot(n, cross(a, b))) / squared, 0.0, 1.0);
    return weights / max(weights.x + weights.y + weights.z, 1e-6);
}

// By Sutherland and Hodgman 1974, "Reentrant Polygon Clipping". `a`, `b`, `c`: corners, column coordinates. Corners of the
// part are weights of `b` and `c`: the whole triangle has an area of one half in them. Each lane takes the planes it crosses,
// since a software driver runs what any lane does for all.
Part part_in(vec3 a, vec3 b, vec3 c, ivec3 voxel) {
    a = from_center(a, voxel);
    b = from_center(b, voxel);
    c = from_center(c, voxel);
    vec3 least = min(a, min(b, c));
    vec3 most = max(a, max(b, c));
    uint planes = 0u; // 2 · axis, and one more for the lower side
    for (int axis = 0; axis < 3; ++axis) {
        planes |= (uint(most[axis] > 0.5) | uint(least[axis] < -0.5) << 1) << (2 * axis);
    }
    // Before a plane and after it, in turns: to copy them takes a software driver as long as to clip.
    vec2 corners[2 * MOST_CORNERS];
    int from = 0;
    corners[0] = vec2(0.0);
    corners[1] = vec2(1.0, 0.0);
    corners[2] = vec2(0.0, 1.0);
    int count = 3;
    while (planes != 0u) {
        int plane = findLSB(planes);
        planes &= planes - 1u;
        int axis = plane >> 1;
        float side = (plane & 1) == 0 ? 1.0 : -1.0;
        // How far inside a corner with these weights is.
        float start = 0.5 - side * a[axis];
        vec2 slope = -side * vec2(b[axis] - a[axis], c[axis] - a[axis]);
        int to = MOST_CORNERS - from;
        int kept = 0;
        vec2 here = corners[from];
        float inside = start + dot(slope, here);
        for (int i = 0; i < count; ++i) {
            vec2 next = corners[from + (i + 1 < count ? i + 1 : 0)];
            float next_inside = start + dot(slope, next);
            if (inside >= 0.0) {
                corners[to + min(kept++, MOST_CORNERS - 1)] = here;
            }
            if ((inside >= 0.0) != (next_inside >= 0.0)) {
                corners[to + min(kept++, MOST_CORNERS - 1)] = mix(here, next, inside / (inside - next_inside));
            }
            here = next;
            inside = next_inside;
        }
        from = to;
        count = min(kept, MOST_CORNERS);
    }
    // A fan of triangles, each with its area and its middle.
    Part part = Part(0.0, vec3(0.0));
    vec2 sum = vec2(0.0);
    vec2 mean = vec2(0.0);
    vec2 last = vec2(0.0);
    for (int i = 0; i < count; ++i) {
        vec2 corner = corners[from + i] - corners[from];
        float share = abs(last.x * corner.y - last.y * corner.x);
        part.share += share;
        sum += share * (last + corner) / 3.0;
        mean += corner / float(count);
        last = corner;
    }
    // What only touches has no area: its corners' middle, or where nothing is left the place nearest to the voxel.
    vec2 middle = corners[from] + (part.share > 0.0 ? sum / part.share : mean);
    part.middle = count == 0 ? nearest(a, b, c) : vec3(1.0 - middle.x - middle.y, middle);
    return part;
}
