// A band of rows of columns. Counts of the 32 voxels of a word lie side by side.
layout(push_constant, scalar) uniform BandPush {
    uint first_row;
    uint rows;
};

uint first_count(uvec2 column, uint word) {
    return 32u * ((word * rows + column.y - first_row) * columns.x + column.x);
}
