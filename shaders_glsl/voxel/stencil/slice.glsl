// Which slice of the grid is drawn, and where in the attachment.
layout(push_constant, scalar) uniform SlicePush {
    uint slice;
    uint layer;
    uvec2 corner; // of its tile, pixels
    uvec2 area; // of the attachment
};
