// Sums over the parts of triangles in a voxel, in fixed point: 64 bits each, low word first, so that their order does not
// matter. A part weighs its area in units of 1 / area_scale of a voxel's side squared; the host chooses the unit so that
// no sum overflows. Voxels stand one behind the other as their bits do.

layout(set = 0, binding = 12, scalar) uniform AttributeScales {
    float area_scale; // units of weight in a voxel's side squared
    float greatest_emission; // cd/m²; 0: nothing emits
} scales;

const float ALPHA_ONE = 255.0;
const float ONE = 65535.0; // albedo, and emission as a part of the greatest
const float NORMAL_ONE = 32767.0; // a normal's components, with as much added
