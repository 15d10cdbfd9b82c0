// The part of a triangle in a voxel: its area, and its middle in barycentric coordinates.

struct Part {
    float area; // voxel sides squared
    vec3 middle;
};

// A triangle and six planes give nine corners at most.
const int MOST_CORNERS = 9;

struct Corner {
    vec3 place; // from the voxel's centre
    vec3 weights;
};

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

// By Sutherland and Hodgman 1974, "Reentrant Polygon Clipping". `a`, `b`, `c`: corners, column coordinates.
Part part_in(vec3 a, vec3 b, vec3 c, ivec3 voxel) {
    Corner corners[MOST_CORNERS];
    corners[0] = Corner(from_center(a, voxel), vec3(1.0, 0.0, 0.0));
    corners[1] = Corner(from_center(b, voxel), vec3(0.0, 1.0, 0.0));
    corners[2] = Corner(from_center(c, voxel), vec3(0.0, 0.0, 1.0));
    vec3 least = min(corners[0].place, min(corners[1].place, corners[2].place));
    vec3 most = max(corners[0].place, max(corners[1].place, corners[2].place));
    int count = 3;
    for (int plane = 0; plane < 6; ++plane) {
        int axis = plane >> 1;
        float side = (plane & 1) == 0 ? 1.0 : -1.0;
        if ((side > 0.0 ? most[axis] : -least[axis]) <= 0.5) {
            continue;
        }
        Corner kept[MOST_CORNERS];
        int kept_count = 0;
        for (int i = 0; i < count; ++i) {
            Corner here = corners[i];
            Corner next = corners[i + 1 == count ? 0 : i + 1];
            float inside = 0.5 - side * here.place[axis];
            float next_inside = 0.5 - side * next.place[axis];
            if (inside >= 0.0 && kept_count < MOST_CORNERS) {
                kept[kept_count++] = here;
            }
            if ((inside >= 0.0) != (next_inside >= 0.0) && kept_count < MOST_CORNERS) {
                float way = inside / (inside - next_inside);
                kept[kept_count++] = Corner(mix(here.place, next.place, way), mix(here.weights, next.weights, way));
            }
        }
        corners = kept;
        count = kept_count;
    }
    // A fan of triangles, each with its area and its middle.
    Part part = Part(0.0, vec3(0.0));
    vec3 sum = vec3(0.0);
    for (int i = 1; i + 1 < count; ++i) {
        vec3 first = corners[i].place - corners[0].place;
        vec3 second = corners[i + 1].place - corners[0].place;
        float area = 0.5 * length(cross(first, second));
        part.area += area;
        sum += area * (corners[0].weights + corners[i].weights + corners[i + 1].weights) / 3.0;
    }
    if (part.area > 0.0) {
        part.middle = sum / part.area;
        return part;
    }
    // What only touches has no area: its corners' middle, or where nothing is left the place nearest to the voxel.
    for (int i = 0; i < count; ++i) {
        part.middle += corners[i].weights / float(count);
    }
    if (count == 0) {
        part.middle = nearest(from_center(a, voxel), from_center(b, voxel), from_center(c, voxel));
    }
    return part;
}
