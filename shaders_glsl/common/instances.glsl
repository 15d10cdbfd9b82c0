// Instances of primitives, found by gl_InstanceIndex: the draw's firstInstance plus the instance.

struct Instance {
    vec4 world_from_object[3]; // rows
    vec3 normal_from_object[3]; // rows of the signed cofactor matrix
    float handedness; // -1 where the transform mirrors
    uint object; // from 1
    uint material; // index into materials
    uint first_primitive; // triangles of the mesh before this primitive's
    uint first_index; // of its triangles, in the scene's index buffer
    int vertex_offset; // added to each index
    uint first_blended; // blended triangles of the scene before this instance's, in the order of objects
};

layout(set = 0, binding = 1, scalar) readonly buffer Instances {
    Instance instances[];
};

vec3 transform_point(Instance instance, vec3 point) {
    vec4 p = vec4(point, 1.0);
    return vec3(
        dot(instance.world_from_object[0], p),
        dot(instance.world_from_object[1], p),
        dot(instance.world_from_object[2], p)
    );
}

vec3 transform_direction(Instance instance, vec3 direction) {
    return vec3(
        dot(instance.world_from_object[0].xyz, direction),
        dot(instance.world_from_object[1].xyz, direction),
        dot(instance.world_from_object[2].xyz, direction)
    );
}

vec3 transform_normal(Instance instance, vec3 normal) {
    return vec3(
        dot(instance.normal_from_object[0], normal),
        dot(instance.normal_from_object[1], normal),
        dot(instance.normal_from_object[2], normal)
    );
}
