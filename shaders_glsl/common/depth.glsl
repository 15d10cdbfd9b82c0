// Depth is reversed: 1 at the near plane, 0 at the far one (or at infinity). Nothing outside this file and
// `scene/camera.rs` needs to know.
#ifndef COMMON_DEPTH_GLSL
#define COMMON_DEPTH_GLSL

// What a depth attachment is cleared to: farther than everything.
const float DEPTH_CLEAR = 0.0;

// Whether depth `a` lies nearer to the eye than depth `b`.
bool closer(float a, float b) { return a > b; }

// The nearer of two depths.
float nearest(float a, float b) { return max(a, b); }

// The farther of two depths.
float farthest(float a, float b) { return min(a, b); }

// Distance along the view axis, in metres, of a depth under a perspective projection with its far plane at infinity:
// depth = near / distance. Infinite at DEPTH_CLEAR.
float linear_distance(float depth, float near) { return near / depth; }

// The same with a far plane: depth = near (far - distance) / (distance (far - near)).
float linear_distance(float depth, float near, float far) { return near * far / (near + depth * (far - near)); }

#endif
