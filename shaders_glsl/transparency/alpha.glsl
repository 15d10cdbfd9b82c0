// Alpha of BLEND materials, as `forward_color` has it, without its shading.
#include "common/surface_fragment.glsl"

float forward_alpha() {
    return (material.flags & MATERIAL_ADD) != 0u ? 0.0 : fragment_surface().alpha;
}
