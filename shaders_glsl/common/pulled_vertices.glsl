// What vertices have besides positions, for shaders that fetch them by hand.

struct AlphaVertex {
    vec2 uv0;
    vec2 uv1;
    vec4 color;
};

struct ShadingVertex {
    vec3 normal;
    vec4 tangent;
};

layout(set = 0, binding = 19, scalar) readonly buffer AlphaVertices {
    AlphaVertex alpha_vertices[];
};
layout(set = 0, binding = 20, scalar) readonly buffer ShadingVertices {
    ShadingVertex shading_vertices[];
};
