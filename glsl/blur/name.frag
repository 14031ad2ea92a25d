// Which triangle a pixel sees: its number from 1.
#version 460
layout(location = 0) flat in uint triangle_id;
layout(location = 0) out uint seen;

void main() {
    seen = triangle_id;
}
