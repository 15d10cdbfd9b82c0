// The instance that a vertex belongs to, as attributes that advance once an instance: software drivers fetch those once for
// all lanes, and words of a storage buffer lane by lane.
#include "common/instance.glsl"

layout(location = 6) in vec4 world_x_from_object; // rows
layout(location = 7) in vec4 world_y_from_object;
layout(location = 8) in vec4 world_z_from_object;

vec4[3] world_from_object() {
    return vec4[](world_x_from_object, world_y_from_object, world_z_from_object);
}
