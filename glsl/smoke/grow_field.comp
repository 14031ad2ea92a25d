// Radius from the chessboard distance field, for cubic voxels and boxes. With D the distance of the particle's voxel c
// and d the particle's offset from its centre (at most half a voxel along each axis), every voxel nearer than D is
// full, so the nearest empty one is in the shell at distance D: one in the shell at D + 1 is at least D + 1/2 away, and
// none in the shell at D is farther than that. A voxel of that shell is as far as its axes that reach +-D say. Whether
// some voxel with just a given set of axes at +-D is empty, the field of one neighbour of c tells: for n in {-1,0,1}^3,
// field(c + n) < D means that the box of half side D - 1 around c + n holds an empty voxel; what it holds beyond the box
// around c are shell voxels whose reaching axes are among those of n. So the answer is the least, over the neighbours
// with field < D, of the largest distance among the axes of n: 27 look-ups, whatever D is.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
layout(local_size_x = 64) in;
#include "grow.glsl"
#include "voxel_words.glsl"
layout(std430, binding = 3) readonly buffer Field { uint field[]; };

int field_at(ivec3 v) {
    if (!is_inside(v)) {
        return 0;
    }
    uint word = row_of(uint(v.y), uint(v.z)) * field_row_words() + uint(v.x) / FIELD_VOXELS;
    return int(field[word] >> (uint(v.x) % FIELD_VOXELS * 8u)) & FIELD_FARTHEST;
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= params.particles) {
        return;
    }
    vec3 p = position_of(slot);
    if (!is_alive(slot)) {
        spheres[slot] = vec4(p, 0.0);
        return;
    }
    ivec3 voxel = voxel_of(p);
    int reach = field_at(voxel);
    float best = reach == 0 ? 0.0 : INFINITY;
    if (reach > 0) {
        vec3 up, down;
        for (int a = 0; a < 3; ++a) {
            up[a] = abs(voxel_centre(voxel[a] + reach, a) - p[a]);
            down[a] = abs(p[a] - voxel_centre(voxel[a] - reach, a));
        }
        for (int z = -1; z <= 1; ++z) {
            float along_z = z == 0 ? 0.0 : z > 0 ? up.z : down.z;
            for (int y = -1; y <= 1; ++y) {
                float along_yz = max(along_z, y == 0 ? 0.0 : y > 0 ? up.y : down.y);
                for (int x = -1; x <= 1; ++x) {
                    float distance = max(along_yz, x == 0 ? 0.0 : x > 0 ? up.x : down.x);
                    if (distance < best && field_at(voxel + ivec3(x, y, z)) < reach) {
                        best = distance;
                    }
                }
            }
        }
    }
    put_sphere(slot, p, best);
}
