#version 460

// What blending costs, to measure others against.

layout(location = 0) flat in uint layer;
layout(location = 0) out vec4 color;

void main() {
    color = vec4(0.1, 0.2, 0.3, 0.4);
}
