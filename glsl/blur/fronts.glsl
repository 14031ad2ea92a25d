// Which side of each triangle of the mesh is outside: eight triangles a word, four bits each.
layout(std430, binding = 28) readonly buffer Fronts { uint fronts[]; };

const uint CLOSED = 1u;  // only the outside can be seen
const uint TURNED = 2u;  // outside is where its corners follow each other clockwise, in frame i; the next one in frame i + 1

uint front_of(uint triangle) {
    return fronts[triangle / 8u] >> (4u * (triangle % 8u)) & 15u;
}
