// Composites an effect's picture over the target, whatever the target's format.
layout(std430, binding = 2) readonly buffer Picture { vec4 picture[]; };
layout(location = 0) out vec4 colour;
#include "fragment.glsl"

// A pixel of the picture.
void lay_over() {
    uvec2 at = pixel_of(gl_FragCoord.xy, params.corner, params.size);
    colour = picture[at.y * params.size.x + at.x];
    if (colour == vec4(0.0)) {
        discard;
    }
}
