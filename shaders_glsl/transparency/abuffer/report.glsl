// What went wrong, counted on the device.
layout(set = 0, binding = 6, scalar) buffer ABufferReport {
    uint lost_pixels; // whose nodes are not as many as were counted: never any
    uint clamped_pixels; // with a colour that the nodes' format could not hold
    uint lost_nodes; // of lists, counted and in no list: never any
} report;
