// Layers summed up with weights. Colours add up; the alpha of the first target is multiplied by 1 - alpha: one blend
// state serves both targets.

layout(location = 0) out vec4 sums; // weighted colours; what all layers let through
layout(location = 1) out float weights; // weighted alphas

void add_layer(vec4 color, float weight) {
    sums = vec4(color.rgb * weight, color.a);
    weights = color.a * weight;
}
