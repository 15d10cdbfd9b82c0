// Instances for shaders that find them themselves, by gl_InstanceIndex: the draw's firstInstance plus the instance.
#include "common/instance.glsl"

layout(set = 0, binding = 1, scalar) readonly buffer Instances {
    Instance instances[];
};
