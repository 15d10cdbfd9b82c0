// A band of rows of columns. Counts of voxels lie as voxels do in an array [k][row][column].
layout(push_constant, scalar) uniform BandPush {
    uint first_row;
    uint rows;
};

uint count_index(uint k, uvec2 column) {
    return (k * rows + column.y - first_row) * columns.x + column.x;
}
