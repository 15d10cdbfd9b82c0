// A regular grid of voxels. Its coordinates count voxels from the grid's lower corner: voxel (i, j, k) has its centre at
// (i + ½, j + ½, k + ½). Column coordinates are the same with the axis of the columns last.

layout(set = 0, binding = 0, scalar) uniform VoxelGrid {
    vec3 voxel_grid_min; // world space, metres
    float voxel_edge; // metres
    uvec3 columns; // voxels in column coordinates: columns across, and voxels in one
    uint column_axis; // 0: x, 1: y, 2: z
};

// From the grid's coordinates to column coordinates.
vec3 in_columns(vec3 p) {
    return column_axis == 0u ? p.yzx : column_axis == 1u ? p.zxy : p;
}

vec3 column_coordinates(vec3 world) {
    return in_columns((world - voxel_grid_min) / voxel_edge);
}

uint words_in_column() {
    return (columns.z + 31u) / 32u;
}

// Words of the bits: voxel k of a column is bit k % 32 of the column's word k / 32; words of all columns lie side by
// side.
uint word_index(uvec2 column, uint word) {
    return (word * columns.y + column.y) * columns.x + column.x;
}

// The first voxel of a column whose centre is at `depth` or beyond it; may be one the column does not have.
int first_voxel_behind(float depth) {
    return int(ceil(clamp(depth, -1.0, float(columns.z) + 1.0) - 0.5));
}

// Bits of a word that stand for voxel `first` of the column and all beyond it.
uint bits_from(int first, uint word) {
    int bit = first - 32 * int(word);
    return bit <= 0 ? 0xffffffffu : bit >= 32 ? 0u : 0xffffffffu << bit;
}
