// Fragments of BLEND materials, shaded forward, each with the number of its triangle.
#include "common/views.glsl"
#include "transparency/forward.glsl"
#include "transparency/key.glsl"
