#version 460

// All of the area: what is drawn of it says the scissor.

void main() {
    vec2 corner = vec2(gl_VertexIndex == 1, gl_VertexIndex == 2);
    gl_Position = vec4(4.0 * corner - 1.0, 0.5, 1.0);
}
