#include "common/voxels.glsl"
#include "common/voxel_bits.glsl"
#include "voxel/walk.glsl"
// What blocks the way from point to point: the bits of a grid, and a pyramid over them to skip what is empty. Of bricks, the
// pyramid is one over their grid, which is level 3; finer levels are found in their words.

layout(set = 0, binding = 1, scalar) uniform PyramidLevels {
    uint level_begins[12]; // words
    uint coarsest; // level that walks begin at; 0: voxels alone
};
layout(set = 0, binding = 3, scalar) readonly buffer Pyramid {
    uint pyramid[];
};

// Whether any of the block of 2^level voxels an axis is set that a voxel is in.
bool is_occupied(uvec3 voxel, uint level) {
    if (IN_BRICKS && level < 3u) {
        return is_any_set(voxel, level);
    }
    uvec3 p = voxel >> level;
    uvec2 size = (columns.xy + (1u << level) - 1u) >> level;
    uint index = (p.z / 32u * size.y + p.y) * size.x + p.x;
    uint word;
    if (IN_BRICKS && level == 3u) {
        word = coarse[index];
    } else if (!IN_BRICKS && level == 0u) {
        word = bits[index];
    } else {
        word = pyramid[level_begins[level] + index];
    }
    return (word >> (p.z % 32u) & 1u) != 0u;
}

bool is_in_grid(vec3 p) {
    return all(greaterThanEqual(p, vec3(0.0))) && all(lessThan(p, vec3(columns)));
}

uvec3 in_parts(vec3 p) {
    return uvec3(clamp(p * float(PARTS), vec3(0.0), vec3(columns * PARTS - 1u)));
}

// The part of a segment that is in the grid: from.x to to.y of the way. Empty where x > y.
vec2 clip(vec3 origin, vec3 way) {
    vec2 part = vec2(0.0, 1.0);
    for (int axis = 0; axis < 3; ++axis) {
        float size = float(columns[axis]);
        if (way[axis] == 0.0) {
            if (origin[axis] < 0.0 || origin[axis] >= size) {
                return vec2(1.0, 0.0);
            }
        } else {
            precise float lower = -origin[axis] / way[axis];
            precise float upper = (size - origin[axis]) / way[axis];
            part = vec2(max(part.x, min(lower, upper)), min(part.y, max(lower, upper)));
        }
    }
    return part;
}

// Whether a set voxel lies between two points in world space, other than those that hold them.
bool is_blocked(vec3 world_origin, vec3 world_end) {
    // 1. In the grid's coordinates, and within the grid.
    vec3 origin = column_coordinates(world_origin);
    vec3 end = column_coordinates(world_end);
    precise vec3 way = end - origin;
    if (!(dot(abs(way) + abs(origin), vec3(1.0)) < 1e30)) {
        return false;
    }
    vec2 part = clip(origin, way);
    if (!(part.x <= part.y)) {
        return false;
    }
    precise vec3 first = part.x > 0.0 ? origin + way * part.x : origin;
    precise vec3 last = part.y < 1.0 ? origin + way * part.y : end;
    uvec3 from = in_parts(first);
    uvec3 to = in_parts(last);

    // 2. From block to block, as large as they are empty.
    bvec2 own = bvec2(is_in_grid(origin), is_in_grid(end));
    Walk walk = walk_from(from, to);
    uint level = coarsest;
    do {
        while (level > 0u && is_occupied(walk.voxel, level)) {
            --level;
        }
        bool is_own = (own.x && walk.voxel == from / PARTS) || (own.y && walk.voxel == to / PARTS);
        if (level == 0u && !is_own && is_occupied(walk.voxel, 0u)) {
            return true;
        }
        if (!leave(walk, level)) {
            return false;
        }
        level = min(level + 1u, coarsest);
    } while (true);
}
