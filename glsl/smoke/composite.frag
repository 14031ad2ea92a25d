// The picture over the target.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/composite_fragment.glsl"

void main() {
    lay_over();
}
