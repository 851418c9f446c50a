// A vertex a beam, for the geometry stage.
layout(location = 0) flat out uint beam_of_point;

void main() {
    beam_of_point = uint(gl_VertexIndex);
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
