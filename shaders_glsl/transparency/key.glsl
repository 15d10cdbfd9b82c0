// The number of each fragment's triangle.

#ifdef PULL_VERTICES
layout(location = 6) flat in uint vertex_primitive;
#else
#define vertex_primitive uint(gl_PrimitiveID)
#endif
layout(location = 7) flat in uint vertex_first_triangle;

// Number of the triangle among all blended ones of the scene: no two fragments of a pixel share it, and it does not
// depend on the order of draws.
uint fragment_key() {
    return vertex_first_triangle + vertex_primitive;
}
