// The walk of a segment through a grid of bits, exact in integers. Coordinates count parts of a voxel, PARTS an axis,
// from the grid's lower corner, in column coordinates. A voxel is half open: it holds its lower faces.
//
// Leaving a voxel is an event on an axis, at distance / total of the way, where `distance` is how far the plane is along
// the axis and `total` how far the segment goes. Towards greater coordinates a plane belongs to what lies behind it,
// and towards lower ones to what lies before it: of events at one place the former come first.

const uint PARTS = 4096u;

// Whether the event at a.x / a.y of the way comes before that at b.x / b.y. Products take 64 bits.
bool comes_before(uvec2 a, uvec2 b) {
    uvec2 left, right; // high, low
    umulExtended(a.x, b.y, left.x, left.y);
    umulExtended(b.x, a.y, right.x, right.y);
    return left.x < right.x || (left.x == right.x && left.y < right.y);
}

struct Walk {
    uvec3 voxel; // where it is
    uvec3 left; // planes still to cross
    uvec3 distance; // to the next plane, from the origin
    uvec3 total; // from origin to end
    bvec3 upwards;
};

Walk walk_from(uvec3 origin, uvec3 end) {
    Walk walk;
    uvec3 last = end / PARTS;
    walk.voxel = origin / PARTS;
    walk.upwards = greaterThanEqual(end, origin);
    walk.left = mix(walk.voxel - last, last - walk.voxel, walk.upwards);
    walk.total = mix(origin - end, end - origin, walk.upwards);
    walk.distance = mix(origin - walk.voxel * PARTS, (walk.voxel + 1u) * PARTS - origin, walk.upwards);
    return walk;
}

// Planes of an axis that are crossed before an event.
uint crossed_before(uvec2 event, uint left, uint distance, uint total) {
    if (left == 0u) {
        return 0u;
    }
    float reach = float(event.x) * (float(total) / float(event.y)) - float(distance);
    uint count = uint(clamp(ceil(reach / float(PARTS)), 0.0, float(left)));
    // The estimate is off by one at most.
    while (count < left && comes_before(uvec2(distance + count * PARTS, total), event)) {
        ++count;
    }
    while (count > 0u && !comes_before(uvec2(distance + (count - 1u) * PARTS, total), event)) {
        --count;
    }
    return count;
}

void cross(inout Walk walk, uvec3 planes) {
    walk.voxel = mix(walk.voxel - planes, walk.voxel + planes, walk.upwards);
    walk.left -= planes;
    walk.distance += planes * PARTS;
}

// Walks out of the block of 2^level voxels an axis that it is in; false where the segment ends in it.
bool leave(inout Walk walk, uint level) {
    // 1. The first event that leads out of the block.
    uvec3 within = walk.voxel & ((1u << level) - 1u);
    uvec3 planes = mix(within + 1u, (1u << level) - within, walk.upwards);
    bvec3 leaves = lessThanEqual(planes, walk.left);
    if (!any(leaves)) {
        return false;
    }
    uvec3 distance = walk.distance + (planes - 1u) * PARTS;
    uvec2 event = leaves.x ? uvec2(distance.x, walk.total.x) :
        leaves.y ? uvec2(distance.y, walk.total.y) : uvec2(distance.z, walk.total.z);
    if (leaves.y && comes_before(uvec2(distance.y, walk.total.y), event)) {
        event = uvec2(distance.y, walk.total.y);
    }
    if (leaves.z && comes_before(uvec2(distance.z, walk.total.z), event)) {
        event = uvec2(distance.z, walk.total.z);
    }
    // 2. All events before it, within the block.
    if (level > 0u) {
        cross(walk, uvec3(
            crossed_before(event, walk.left.x, walk.distance.x, walk.total.x),
            crossed_before(event, walk.left.y, walk.distance.y, walk.total.y),
            crossed_before(event, walk.left.z, walk.distance.z, walk.total.z)
        ));
    }
    // 3. Those at its place: upwards first.
    bvec3 now = bvec3(
        walk.left.x > 0u && !comes_before(event, uvec2(walk.distance.x, walk.total.x)),
        walk.left.y > 0u && !comes_before(event, uvec2(walk.distance.y, walk.total.y)),
        walk.left.z > 0u && !comes_before(event, uvec2(walk.distance.z, walk.total.z))
    );
    uvec3 chosen = uvec3(now) * uvec3(walk.upwards);
    cross(walk, chosen == uvec3(0u) ? uvec3(now) : chosen);
    return true;
}
