#version 460
#include "transparency/kbuffer/keep_depths.glsl"

void main() {
    keep_depth();
}
