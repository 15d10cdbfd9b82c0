// Sums up absorbance and its first four power moments over depth (Münstermann et al. 2018, section 3).
#include "transparency/moments/depth.glsl"

layout(early_fragment_tests) in;

layout(location = 0) out vec4 moments; // 1 to 4
layout(location = 1) out float absorbance; // moment 0

// An opaque layer's would be infinite.
const float MOST_ABSORBANCE = 10.0;

void add_moments(float alpha) {
    float z = moment_depth(gl_FragCoord.z);
    float z2 = z * z;
    absorbance = min(-log(max(1.0 - alpha, 1e-30)), MOST_ABSORBANCE);
    moments = absorbance * vec4(z, z2, z2 * z, z2 * z2);
}
