// Composites an effect's picture over the target, whatever the target's format.
layout(std430, binding = 2) readonly buffer Picture { vec4 picture[]; };
layout(location = 0) out vec4 colour;

// A pixel of a picture so many pixels wide.
void lay_over(uint width) {
    uvec2 at = uvec2(gl_FragCoord.xy) - params.corner;
    colour = picture[at.y * width + at.x];
    if (colour.a == 0.0) {
        discard;
    }
}
