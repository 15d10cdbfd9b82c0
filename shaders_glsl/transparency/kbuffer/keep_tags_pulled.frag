#version 460
#define PULL_VERTICES
#include "transparency/key.glsl"
#include "transparency/kbuffer/keep_tags.glsl"

void main() {
    keep_tag(fragment_key());
}
