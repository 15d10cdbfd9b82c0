// Which slice of the grid is drawn, and into which layer of the attachment.
layout(push_constant, scalar) uniform SlicePush {
    uint slice;
    uint layer;
};
