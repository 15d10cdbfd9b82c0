#version 460
#extension GL_EXT_scalar_block_layout : require

// The workgroups of each round: none once every layer is peeled.

layout(local_size_x = 64) in;

layout(set = 0, binding = 1, scalar) readonly buffer MostLayers {
    uint most; // of a pixel
    uint too_deep; // fragments
} layers;
layout(set = 0, binding = 2, scalar) writeonly buffer PeelRounds {
    uvec3 groups[];
} rounds;

layout(push_constant, scalar) uniform PeelRoundsPush {
    uvec2 groups; // of a round over the whole picture
    uint layers_a_round;
} push;

void main() {
    uint round = gl_GlobalInvocationID.x;
    if (round >= rounds.groups.length()) {
        return;
    }
    uint needed = (layers.most + push.layers_a_round - 1u) / push.layers_a_round + 2u;
    rounds.groups[round] = layers.most > 0u && round < needed ? uvec3(push.groups, 1u) : uvec3(0u);
}
