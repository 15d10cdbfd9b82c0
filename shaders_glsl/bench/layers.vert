#version 460
#extension GL_EXT_scalar_block_layout : require

// A triangle over the whole picture for each instance, at depths in no order.

layout(push_constant, scalar) uniform LayersPush {
    uint layers;
} push;

layout(location = 0) flat out uint layer;

invariant gl_Position;

void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0;
    // An odd factor goes through the numbers below a power of two in another order.
    uint depth = (uint(gl_InstanceIndex) * 2654435761u) >> 8;
    gl_Position = vec4(corner, (float(depth) + 1.0) / 16777218.0, 1.0);
    layer = uint(gl_InstanceIndex);
}
