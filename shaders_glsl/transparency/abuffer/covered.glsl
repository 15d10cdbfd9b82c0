// Where the fragment is sorted, and at which samples of its pixel it is seen.
#include "transparency/abuffer/samples.glsl"

#ifdef MULTISAMPLED
#extension GL_ARB_post_depth_coverage : require

// Else the mask would be that before the depth test.
layout(post_depth_coverage) in;

// All samples have one place in the order: the depth of the triangle's plane at the pixel's centre, even where that is not
// covered. Then it may lie beyond what depth can be; nodes are nearer than depth 0.
Covered fragment_covered() {
    const float LEAST = 1.17549435e-38;
    return Covered(clamp(gl_FragCoord.z, LEAST, 1.0), uint(gl_SampleMaskIn[0]));
}
#else
Covered fragment_covered() {
    return Covered(gl_FragCoord.z, 1u);
}
#endif
