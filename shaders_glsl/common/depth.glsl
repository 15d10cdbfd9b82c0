// Depth is reversed: 1 at the near plane, 0 at the far one (or at infinity). Nothing outside this file and
// `scene/camera.rs` needs to know.
#ifndef COMMON_DEPTH_GLSL
#define COMMON_DEPTH_GLSL

// What a depth attachment is cleared to: farther than everything.
const float DEPTH_CLEAR = 0.0;

#endif
