// Tabulates ln(1 - G): each texel of the mask sees a chord through the space of the render particles, and G grows along it.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
layout(constant_id = 0) const uint CUBE = 0;
#include "params.glsl"
#include "kernel.glsl"
layout(local_size_x = KERNEL_LANES) in;
layout(std430, binding = 1) readonly buffer KernelState { KernelTable table; };
layout(std430, binding = 2) readonly buffer Shares { float shares[]; };
layout(binding = 3, r32f) uniform writeonly image2D kernel;

// The chord through the space at an offset across, in metres; empty where begin > end.
vec2 chord(vec2 at, float radius) {
    if (CUBE == 1u) {
        vec3 across = params.camera.right.xyz * at.x + params.camera.up.xyz * at.y;
        vec2 range = vec2(-1e30, 1e30);
        for (int axis = 0; axis < 3; ++axis) {
            float along = params.camera.forward[axis];
            along = abs(along) < 1e-6 ? 1e-6 : along;
            vec2 ends = (vec2(-radius, radius) - across[axis]) / along;
            range = vec2(max(range.x, min(ends.x, ends.y)), min(range.y, max(ends.x, ends.y)));
        }
        return range;
    }
    float rest = radius * radius - dot(at, at);
    float half_chord = rest > 0.0 ? sqrt(rest) : -1.0;
    return vec2(-half_chord, half_chord);
}

void main() {
    uint place = gl_GlobalInvocationID.x % (KERNEL_PLACES * KERNEL_PLACES);
    uint class_index = gl_GlobalInvocationID.x / (KERNEL_PLACES * KERNEL_PLACES);
    if (class_index >= KERNEL_CLASSES || !has_class(table.new_classes, class_index)) {
        return;
    }
    ivec2 grid = ivec2(place % KERNEL_PLACES, place / KERNEL_PLACES);
    // In spreads, so that the table is the same to the bit whatever a frame's spread.
    float sprite_size = params.relative_size;
    float bounding_radius = 1.0;
    if (CUBE == 1u) {
        bounding_radius = 1.7320508;
    }
    float reach = bounding_radius + 0.5 * sprite_size;
    vec2 m = reach * (2.0 * vec2(grid) / LAST_PLACE - 1.0);
    uint side = MASK_SIDE >> table.level;
    // Coarse texels are areas: each is looked at in several places.
    bool is_thin = 1.0 < 2.0 * sprite_size / float(MASK_PLACES);
    uint places = max((is_thin ? FINE_MASK_PLACES : MASK_PLACES) / side, 1u);
    uint across = side * places;
    float place_side = sprite_size / float(across);
    // A space narrower than two places would fall between them.
    float widest = max(1.0, 2.0 * place_side);
    float radius = CUBE == 1u ? 1.0 : widest;
    float volume = CUBE == 1u ? 8.0 * radius * radius * radius : ball_volume(radius);
    float squeeze = CUBE == 1u ? 1.0 : 1.0 / widest;
    float g[KERNEL_DEPTHS];
    [[unroll]] for (uint k = 0u; k < KERNEL_DEPTHS; ++k) {
        g[k] = 0.0;
    }
    for (uint i = 0u; i < across * across; ++i) {
        uvec2 at_mask = uvec2(i % across, i / across);
        float share = shares[(class_index * side + at_mask.y / places) * side + at_mask.x / places];
        if (share == 0.0) {
            continue;
        }
        vec2 u = (vec2(at_mask) + 0.5) / float(across) - 0.5;
        vec2 at = m - sprite_size * u;
        // The mask's rows go down, space goes up.
        vec2 range = chord(vec2(at.x, -at.y), radius) * squeeze;
        float length = range.y - range.x;
        if (length <= 0.0) {
            continue;
        }
        [[unroll]] for (uint k = 0u; k < KERNEL_DEPTHS; ++k) {
            float depth = bounding_radius * (2.0 * float(k) / float(KERNEL_DEPTHS - 1u) - 1.0);
            g[k] += share * clamp(depth - range.x, 0.0, length);
        }
    }
    float weight = place_side * place_side / volume / max(squeeze, 1e-12);
    [[unroll]] for (uint k = 0u; k < KERNEL_DEPTHS; ++k) {
        float p = min(weight * g[k], 1.0);
        float value = logarithm_of_rest(p);
        imageStore(kernel, kernel_texel(grid, int(k), int(class_index)), vec4(max(value, LEAST_LOGARITHM)));
    }
}
