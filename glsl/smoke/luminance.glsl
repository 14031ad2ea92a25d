// Luminance, depth and group of the pixels that a sphere was seen at: Y = ambient + (1 - ambient) max(0, n.l) s,
// with a share of it filled. Works on occupied tiles, so that only pixels that are seen ask for shadows.
#include "no_channel.glsl"
layout(constant_id = 1) const uint KEEP_SHADOW = 0u;  // 1: s is smoothed or a layer, or several dispatches add to it
layout(constant_id = 2) const bool SECOND = false;      // there may be a second light
layout(constant_id = 3) const uint SHADE = NO_CHANNEL;           // channel of s,
layout(constant_id = 4) const uint FIRE = NO_CHANNEL;            // of the fire's light,
layout(constant_id = 5) const uint RIM = NO_CHANNEL;    // of how far surfaces are turned away
#include "tile.glsl"
layout(binding = 3, r32ui) uniform readonly uimage2D seen;
layout(std430, binding = 2) readonly buffer Spheres { vec4 spheres[]; };
layout(std430, binding = 4) writeonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 5) writeonly buffer Depth { float depth[]; };
layout(std430, binding = 6) buffer Shadow { float shadow[]; };
layout(std430, binding = 9) readonly buffer ViewSpheres { vec4 view_spheres[]; };
layout(std430, binding = 10) writeonly buffer Channels { float channels[]; };
layout(std430, binding = 11) readonly buffer Occupancy { uint occupancy[]; };
#include "view.glsl"
#include "pixel.glsl"
#include "channels.glsl"
#include "fire.glsl"
#include "toon/luminance.glsl"

// What a shadow is asked for.
struct Surface {
    uint slot;
    vec3 centre;  // of the pixel's sphere
    vec3 offset;  // from the centre to the surface
    vec3 normal;
    vec3 to_light;
    float light_distance;
    float facing;
};

float lit_share(Surface surface, float before);

// Cosine between the normal and the second light.
float facing_second(Surface surface) {
    vec4 light = params.second_light;
    vec3 way = light.w == 0.0 ? light.xyz : (light.xyz - surface.centre) - surface.offset;
    float squared = dot(way, way);
    return squared > 0.0 ? dot(surface.normal, way) * inversesqrt(squared) : 0.0;
}

void work_on(uvec2 at) {
    uint code = imageLoad(seen, ivec2(at)).x;
    if (code == 0u) {
        return;
    }
    Surface surface;
    surface.slot = (code >> GROUP_BITS) - 1u;
    vec3 centre = spheres[surface.slot].xyz;
    float view_depth;
    vec3 normal;
    vec4 view_sphere = view_spheres[surface.slot];
    Ray ray = pixel_ray(vec2(at) + 0.5);
    hit_sphere(ray, view_sphere, view_depth, normal);
    surface.centre = centre;
    surface.normal = to_world_direction(normal);
    surface.offset = surface.normal * view_sphere.w;
    bool is_point = params.is_point_light != 0u;
    vec3 to_light = is_point ? (params.light.xyz - centre) - surface.offset : params.light.xyz;
    surface.light_distance = is_point ? length(to_light) : INFINITY;
    surface.to_light = is_point ? to_light / max(surface.light_distance, 1e-30) : to_light;
    surface.facing = dot(surface.normal, surface.to_light);
    uint pixel = pixel_index(at);
    float s = 1.0;
    if (KEEP_SHADOW != 0u) {
        if (!FIRST_PART) {
            s = shadow[pixel];
        }
        s = lit_share(surface, s);
        shadow[pixel] = s;
    } else if (surface.facing > 0.0) {
        s = lit_share(surface, s);
    }
    float up = dot(surface.normal, params.fill.xyz);
    float luminance = luminance_of(surface.facing, s, up, params.ambient, params.fill.w);
    if (SECOND) {
        luminance = with_second(luminance, facing_second(surface), params.second_strength);
    }
    if (RIM != NO_CHANNEL) {
        channels[channel_index(RIM, pixel)] = turned_away(surface.facing, -dot(normal, normalize(ray.way)));
    }
    if (SHADE != NO_CHANNEL) {
        channels[channel_index(SHADE, pixel)] = s;
    }
    if (FIRE != NO_CHANNEL) {
        channels[channel_index(FIRE, pixel)] = fire_light(surface.centre + surface.offset, surface.normal);
    }
    pixels[pixel] = pack_pixel(luminance, code & GROUP_MASK);
    depth[pixel] = view_depth;
}
