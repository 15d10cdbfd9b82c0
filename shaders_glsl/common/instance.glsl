// An instance of a primitive: where it stands, and what it is.

struct Instance {
    vec4 world_from_object[3]; // rows
    vec3 normal_from_object[3]; // rows of the signed cofactor matrix
    float handedness; // -1 where the transform mirrors
    uint object; // from 1
    uint material; // index into materials
    uint first_primitive; // triangles of the mesh before this primitive's
    uint first_blended; // blended triangles of the scene before this instance's, in the order of objects
    uint first_index; // of its triangles, in the scene's index buffer
    int vertex_offset; // added to each index
};

vec3 transform_point(vec4 world_from_object[3], vec3 point) {
    vec4 p = vec4(point, 1.0);
    return vec3(dot(world_from_object[0], p), dot(world_from_object[1], p), dot(world_from_object[2], p));
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
