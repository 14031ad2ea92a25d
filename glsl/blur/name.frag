// The triangle-id buffer: the id of the triangle that a pixel sees, from 1; 0 is none.
#version 460
layout(location = 0) flat in uint triangle_id;
layout(location = 0) out uint seen;

void main() {
    seen = triangle_id;
}
