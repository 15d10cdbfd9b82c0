// Alpha of BLEND materials, as `forward_color` has it, without its shading.
#include "common/surface_fragment.glsl"

float forward_alpha() {
    return fragment_surface().alpha;
}
