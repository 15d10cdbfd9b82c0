#version 460
#extension GL_EXT_scalar_block_layout : require
#include "voxel/visibility.glsl"

// Whether a set voxel lies on a segment, other than those that hold its ends.

layout(local_size_x = 64) in;

struct Segment {
    vec3 origin; // world space, metres
    vec3 end;
};

layout(push_constant, scalar) uniform MarchPush {
    uint count; // of segments
    uint row; // segments in a row of invocations
};
layout(set = 0, binding = 4, scalar) readonly buffer Segments {
    Segment segments[];
};
layout(set = 0, binding = 5, scalar) writeonly buffer Blocked {
    uint blocked[]; // 1 or 0
};

void main() {
    uint index = gl_GlobalInvocationID.y * row + gl_GlobalInvocationID.x;
    if (index < count) {
        blocked[index] = uint(is_blocked(segments[index].origin, segments[index].end));
    }
}
