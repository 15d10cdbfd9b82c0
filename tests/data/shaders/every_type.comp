#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types : require
#extension GL_EXT_buffer_reference : require
layout(local_size_x = 8, local_size_y = 4, local_size_z = 2) in;

struct Light {
    vec3 position;
    float range;
    mat2x3 basis;
};

layout(buffer_reference) buffer Link;
layout(buffer_reference, scalar) buffer Link {
    Link next;
    vec3 color;
};

layout(set = 0, binding = 0, scalar) uniform Everything {
    float f;
    vec2 v2;
    vec3 v3;
    vec4 v4;
    int i;
    ivec2 i2;
    ivec3 i3;
    ivec4 i4;
    uint u;
    uvec2 u2;
    uvec3 u3;
    uvec4 u4;
    bool b;
    mat2 m2;
    mat3 m3;
    mat4 m4;
    mat3x4 m34;
    mat4x3 m43;
    float floats[5];
    vec3 grid[2][3];
    Light light;
    Light lights[2];
    int8_t byte;
    double d;
    float16_t half_float;
    uint16_t u16;
    int64_t i64;
    uint64_t type;
    dvec3 d3;
    Link link;
    uint last;
} everything;

layout(set = 0, binding = 1, scalar) readonly buffer Numbers { vec4 numbers[]; };
layout(set = 0, binding = 2, scalar) buffer Nodes {
    uint count;
    Light nodes[];
};
layout(set = 0, binding = 3, scalar) writeonly buffer Sums {
    uint count;
    double sums[];
} result;

void main() {
    uint i = atomicAdd(count, 1u) + everything.last;
    nodes[i] = everything.lights[1];
    result.sums[i] = double(numbers[i].x) + everything.d;
    everything.link.next.color = everything.v3;
}
