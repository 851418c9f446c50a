// A number for the geometry stage.
layout(location = 0) flat out uint point;

void main() {
    point = uint(gl_VertexIndex);
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
