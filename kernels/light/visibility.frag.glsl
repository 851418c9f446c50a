layout(location = 0) flat in uvec2 ids;
layout(location = 0) out uvec2 color;

void main() {
    color = ids;
}
