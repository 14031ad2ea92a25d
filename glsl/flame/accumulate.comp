// Repetitions of a tile's render particles. A tile owns its pixels: there are no atomics on them, and no render particle
// ever reaches memory. Particles come in batches, front first; each invocation makes one sprite of a repetition and puts it into the queues
// of the blocks that it touches; then invocations are columns of pixels, and a block's test its queue. Nearest wins, then the smaller id, then the
// first row: nothing depends on the order in which lists and queues were filled. Sums are integers.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "params.glsl"
layout(local_size_x = 32) in;
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 3) readonly buffer Cells { uint cell_ends[]; };
layout(std430, binding = 4) readonly buffer Entries { uint entries[]; };
layout(std430, binding = 5) readonly buffer ActiveTiles { uint active_tiles[]; };
layout(std430, binding = 6) readonly buffer Scene { float scene[]; };
layout(std430, binding = 7) buffer Sums { uvec4 sums[]; };
layout(std430, binding = 8) buffer Winners { uvec4 winners[]; };
layout(binding = 9, r32f) uniform readonly image2D levels;
layout(constant_id = 4) const uint HAS_SCENE = 0;  // 1: the scene's depth occludes
layout(push_constant) uniform AccumulateConstants {
    uint part;         // which dispatch of the stage this is
    uint repetitions;  // where the stage begins
    uint last;         // where it ends
    uint before;       // repetitions that earlier frames have added
} constants;
#include "cells.glsl"
#include "depth_range.glsl"
#include "lists.glsl"
#include "mask_level.glsl"
#include "mask_value.glsl"
#include "sprite.glsl"
#include "sums.glsl"

const uint LANES = 32u;
const uint BLOCKS = 4u;
const uint QUEUE = 64u;  // a round adds at most one sprite an invocation to each queue
const int ROWS = int(BLOCK);

shared uvec2 lists[12];          // where each level's list begins, and its end among all entries of the tile
shared vec4 batch_view[LANES];
shared vec4 batch_centre[LANES];
shared vec4 batch_slope[LANES];
shared uvec4 batch_draw[LANES];  // key, id, row, unused
shared uint batch_end[LANES];    // end of its render particles among those of the batch
shared vec4 queue_place[BLOCKS][QUEUE];    // x, y, depth, texels a pixel
shared uvec4 queue_sprite[BLOCKS][QUEUE];  // row + 1, id, texel, alpha
shared uint queue_length[BLOCKS];
shared uint farthest[BLOCKS];  // of what is nearest in a block's pixels

// A column of a block: what is nearest in each of its pixels. Rows count from 1; 0 is nobody.
uint nearest_depth[ROWS];
uint nearest_id[ROWS];
uint nearest_row[ROWS];

// Puts the tile's lists one after the other; how many entries they have.
uint join_lists(uvec2 tile) {
    uint levels_of_cells = params.counts.z;
    uint lane = gl_LocalInvocationID.x;
    if (lane < levels_of_cells) {
        lists[lane] = list_range(tile, lane);
    }
    barrier();
    uint total = 0u;
    uint own_end = 0u;
    for (uint level = 0u; level < levels_of_cells; ++level) {
        total += lists[level].y - lists[level].x;
        own_end = level == lane ? total : own_end;
    }
    barrier();
    if (lane < levels_of_cells) {
        lists[lane].y = own_end;
    }
    barrier();
    return total;
}

uint entry_at(uint index) {
    uint level = 0u;
    uint before = 0u;
    while (index >= lists[level].y) {
        before = lists[level].y;
        ++level;
    }
    return entries[lists[level].x + index - before];
}

// Loads a batch of particles; how many render particles they have. What all pixels have nearer is left out.
uint load_batch(uint at, uint end) {
    uint lane = gl_LocalInvocationID.x;
    uint count = 0u;
    if (at + lane < end) {
        uint row = entry_at(at + lane);
        vec4 view = particles[row].view;
        uvec4 draw = particles[row].draw;
        batch_view[lane] = view;
        batch_centre[lane] = particles[row].centre;
        batch_slope[lane] = particles[row].slope;
        batch_draw[lane] = uvec4(draw.xy, row + 1u, 0u);
        uint nearest = floatBitsToUint(max(nearest_of(view.z), 0.0));
        bool hidden = nearest > max(max(farthest[0], farthest[1]), max(farthest[2], farthest[3]));
        count = hidden ? 0u : draw.z;
    }
    batch_end[lane] = count;
    for (uint width = 1u; width < LANES; width *= 2u) {
        barrier();
        uint other = lane >= width ? batch_end[lane - width] : 0u;
        barrier();
        batch_end[lane] += other;
    }
    barrier();
    uint total = batch_end[LANES - 1u];
    // The next batch may follow at once, where nothing of this one is left.
    barrier();
    return total;
}

// Makes render particle `t` of the batch and queues it in the blocks that it touches.
void queue_sprites(uint t, uint repetition, vec2 origin, uint level) {
    uint slot = 0u;
    [[unroll]] for (uint step = LANES / 2u; step > 0u; step /= 2u) {
        slot += batch_end[slot + step - 1u] <= t ? step : 0u;
    }
    uint first = slot == 0u ? 0u : batch_end[slot - 1u];
    uvec4 draw = batch_draw[slot];
    vec4 view = batch_view[slot];
    vec4 slope = batch_slope[slot];
    Sprite sprite = make_sprite(view, batch_centre[slot], slope, draw.x, t - first, repetition, origin, level);
    // Rounding: a thousandth of a pixel is more than it can be.
    float reach = slope.w * 0.5 * float(MASK_SIDE >> level) / sprite.scale + 1e-3;
    vec4 bounds = vec4(sprite.at - reach, sprite.at + reach);
    uint depth = floatBitsToUint(sprite.z);
    [[unroll]] for (uint block = 0u; block < BLOCKS; ++block) {
        vec2 corner = float(BLOCK) * vec2(block & 1u, block >> 1u);
        bool touches = sprite.exists && depth <= farthest[block] && all(lessThanEqual(bounds.xy, corner + (float(BLOCK) - 0.5)))
            && all(greaterThanEqual(bounds.zw, corner + 0.5));
        if (touches) {
            uint place = atomicAdd(queue_length[block], 1u);
            queue_place[block][place] = vec4(sprite.at, sprite.z, sprite.scale);
            queue_sprite[block][place] = uvec4(draw.zy, sprite.texel, floatBitsToUint(view.w));
        }
    }
}

// Tests the sprites of a block's queue against a column of its pixels. `centre`: of its first pixel.
void test_queue(uint block, vec2 centre, uint level) {
    float middle = 0.5 * float(MASK_SIDE >> level);
    uint length = queue_length[block];
    for (uint i = 0u; i < length; ++i) {
        vec4 place = queue_place[block][i];
        uvec4 sprite = queue_sprite[block][i];
        uint depth = floatBitsToUint(place.z);
        float alpha = uintBitsToFloat(sprite.w);
        vec2 t = (centre - place.xy) * place.w + middle;
        Look look = begin_look(t.x, sprite.z, level);
        [[unroll]] for (int y = 0; y < ROWS; ++y) {
            float value = mask_value(look, t.y + float(y) * place.w);
            bool passes = value > 0.0 && alpha * value >= params.model.y;
            bool first = sprite.y < nearest_id[y] || (sprite.y == nearest_id[y] && sprite.x < nearest_row[y]);
            bool nearer = depth < nearest_depth[y] || (depth == nearest_depth[y] && first);
            bool wins = passes && nearer;
            nearest_depth[y] = wins ? depth : nearest_depth[y];
            nearest_id[y] = wins ? sprite.y : nearest_id[y];
            nearest_row[y] = wins ? sprite.x : nearest_row[y];
        }
    }
}

// What is nearest in a block's pixels can only come nearer: what is behind all of it need not be looked at.
void note_farthest(uint block) {
    if (gl_LocalInvocationID.x % BLOCK == 0u) {
        farthest[block] = 0u;
    }
    barrier();
    uint own = 0u;
    [[unroll]] for (int y = 0; y < ROWS; ++y) {
        own = max(own, nearest_depth[y]);
    }
    atomicMax(farthest[block], params.flags.x == 1u ? own : FAR_AWAY);
    barrier();
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint tile_index = active_tiles[gl_WorkGroupID.x];
    uvec2 tile = uvec2(tile_index % params.image.z, tile_index / params.image.z);
    uint level = mask_level();
    uint entries_of_tile = join_lists(tile);
    uint segment = constants.part % control.segments;
    uint first_entry = segment * control.segment_entries;
    uint last_entry = min(first_entry + control.segment_entries, entries_of_tile);
    uint first = constants.repetitions + constants.part / control.segments * control.part_repetitions;
    uint last = min(first + control.part_repetitions, constants.last);
    bool is_last_segment = segment + 1u == control.segments;

    uint block = lane / BLOCK;
    uvec2 corner = BLOCK * uvec2(block & 1u, block >> 1u);
    uvec2 pixel = tile * TILE + corner + uvec2(lane % BLOCK, 0u);
    vec2 centre = vec2(corner) + vec2(float(lane % BLOCK) + 0.5, 0.5);
    vec2 origin = vec2(tile * TILE);
    uint column = pixel.y * params.image.x + pixel.x;
    bool inside[ROWS];
    uint scene_depth[ROWS];
    Sum sum[ROWS];
    bool is_first = constants.before + first == 0u;
    [[unroll]] for (int y = 0; y < ROWS; ++y) {
        inside[y] = pixel.x < params.image.x && pixel.y + uint(y) < params.image.y;
        uint at = column + uint(y) * params.image.x;
        scene_depth[y] = inside[y] ? FAR_AWAY : 0u;
        if (HAS_SCENE == 1u) {
            if (inside[y]) {
                scene_depth[y] = floatBitsToUint(scene[at]);
            }
        }
        sum[y] = no_sum();
        if (inside[y] && !is_first) {
            sum[y] = load_sum(at);
        }
    }
    if (lane < BLOCKS) {
        queue_length[lane] = 0u;
    }
    for (uint repetition = first; repetition < last; ++repetition) {
        [[unroll]] for (int y = 0; y < ROWS; ++y) {
            nearest_depth[y] = scene_depth[y];
            nearest_id[y] = 0u;
            nearest_row[y] = 0u;
            if (segment > 0u && inside[y]) {
                uvec4 winner = winners[column + uint(y) * params.image.x];
                nearest_depth[y] = winner.x;
                nearest_id[y] = winner.y;
                nearest_row[y] = winner.z;
            }
        }
        note_farthest(block);
        for (uint at = first_entry; at < last_entry; at += LANES) {
            uint total = load_batch(at, last_entry);
            uint made = 0u;
            while (made < total) {
                bool has_room;
                do {
                    if (made + lane < total) {
                        queue_sprites(made + lane, constants.before + repetition, origin, level);
                    }
                    made += LANES;
                    barrier();
                    uint longest = max(max(queue_length[0], queue_length[1]), max(queue_length[2], queue_length[3]));
                    barrier();
                    has_room = longest <= QUEUE - LANES;
                } while (made < total && has_room);
                test_queue(block, centre, level);
                barrier();
                if (lane < BLOCKS) {
                    queue_length[lane] = 0u;
                }
                note_farthest(block);
            }
        }
        [[unroll]] for (int y = 0; y < ROWS; ++y) {
            if (inside[y] && !is_last_segment) {
                winners[column + uint(y) * params.image.x] = uvec4(nearest_depth[y], nearest_id[y], nearest_row[y], 0u);
            }
            if (is_last_segment && nearest_row[y] != 0u) {
                add_winner(sum[y], particles[nearest_row[y] - 1u].light, nearest_depth[y]);
            }
        }
    }
    [[unroll]] for (int y = 0; y < ROWS; ++y) {
        uint at = column + uint(y) * params.image.x;
        if (inside[y] && is_last_segment) {
            store_sum(at, sum[y]);
        }
    }
}
