// Repetitions of a tile's render particles. A tile owns its pixels: there are no atomics on them, and no render particle
// ever reaches memory. Particles come in batches, front first. In a round invocations make a sprite of a repetition each and note the blocks that it
// touches; then invocations are columns of pixels, and test the sprites that touch their block. Nearest wins, then the smaller id, then
// the first row; with emission, the hottest of the nearest slab of depth before all of them: nothing depends on the order of the lists. Sums are integers.
//
// Loops are such as end at their bottom, and what a loop needs is read before it: on a device that runs invocations in step, an iteration that
// nobody takes still costs what it would have done.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "params.glsl"
#include "columns.glsl"
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 3) readonly buffer Cells { uint cell_ends[]; };
layout(std430, binding = 4) readonly buffer Entries { uint entries[]; };
layout(std430, binding = 5) readonly buffer ActiveTiles { uint active_tiles[]; };
layout(std430, binding = 6) readonly buffer Scene { float scene[]; };
layout(std430, binding = 7) buffer Sums { uvec4 sums[]; };
layout(std430, binding = 8) buffer Winners { uvec4 winners[]; };
layout(binding = 9, r32f) uniform readonly image2D levels;
layout(std430, binding = 10) readonly buffer Stretches { uint stretches[]; };
layout(constant_id = 5) const uint HAS_SCENE = 0;  // 1: the scene's depth occludes
layout(constant_id = 7) const uint EMISSION = 0;   // 1: in each slab of depth the hottest wins
#include "cells.glsl"
#include "depth_range.glsl"
#include "lists.glsl"
#include "mask_level.glsl"
#include "sprite.glsl"
#include "mask_value.glsl"
#include "slabs.glsl"
#include "winner.glsl"

const uint WORDS = BATCH / 32u;  // a bit for each sprite of a round

shared uvec2 lists[MAX_CELL_LEVELS];           // where each level's list begins, and its end among all entries of the tile
shared uint waiting;              // entries that are next in a batch
shared uint waiting_rows[BATCH + LANES];
shared uint batch_sums[BATCH];    // render particles of a batch up to here, and particles that have any in the upper 8 bits
shared vec4 batch_place[BATCH];   // of those particles: x, y, depth, alpha
shared vec4 batch_slope[BATCH];   // slope, reach, stretch; or, near the camera, x and y in view space and -1
shared uvec3 batch_draw[BATCH];   // row + 1, id, hash of the id less the place of its first render particle in the batch
shared vec4 sprite_place[BATCH];  // x, y, depth, texels a pixel
shared uvec4 sprite_draw[BATCH];  // row + 1, id, texel, alpha
shared uint sprite_stretch[BATCH];
// For even rounds and for odd ones: while one is used, the other is emptied. Columns of whole blocks have one of each: more barriers are cheaper for
// the drivers that they suit than places that are not known beforehand.
shared uint starts[2u * WORDS];         // a bit for each sprite of the round that is its particle's first
shared uint touches[2u * BATCH / 8u];   // which of 8 sprites each touch: a byte for each block
shared uint columns_farthest[LANES];  // of what is nearest in each column, where blocks are taken from there
shared uint farthest[2u * BLOCKS];      // of what is nearest in the pixels of each block as the round begins

// What is nearest in each pixel of the column. Rows count from 1; 0 is nobody.
uint nearest_depth[ROWS];
uint nearest_id[ROWS];
uint nearest_row[ROWS];
uint nearest_slab[ROWS];   // with EMISSION: the slab of depth, and how hot it is; nobody is below 0
float nearest_heat[ROWS];
uint scene_depth[ROWS];

// Puts the tile's lists one after the other; how many entries they have.
uint join_lists(uvec2 tile) {
    uint levels_of_cells = params.cell_level_count;
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

// Looks for the entries of the next batch from `at` on, `found` of which wait already; how many wait then. What all pixels have nearer, as the last round (`parity`) knew, is left
// out, unless nothing is known of them yet: behind the front of a fire, most of a list is.
uint find_batch(inout uint at, uint end, uint found, bool is_first, uint parity, Slabs slabs) {
    uint lane = gl_LocalInvocationID.x;
    uint most = is_first ? INFINITY_BITS : 0u;
    [[unroll]] for (uint block = 0u; block < BLOCKS; ++block) {
        most = max(most, farthest[BLOCKS * parity + block]);
    }
    do {
        // Where a batch is smaller than a workgroup, more may wait already than it takes.
        bool is_short = LANES == BATCH || found < BATCH;
        if (is_short && at + lane < end) {
            uint row = entry_at(at + lane);
            if (order_of(max(nearest_of(particles[row].depth), 0.0), slabs) <= most) {
                waiting_rows[atomicAdd(waiting, 1u)] = row;
            }
        }
        at += is_short ? LANES : 0u;
        barrier();
        found = waiting;
        barrier();
    } while (at < end && found < BATCH);
    return found;
}

struct Batch {
    uint total;  // its render particles
    uint left;   // entries that wait for the next one
    uint start;  // the place among them where this invocation's particle begins
};

// Loads the first of those that wait; the others are at most as many as there are invocations.
Batch load_batch(uint found, vec2 origin) {
    uint lane = gl_LocalInvocationID.x;
    uint row = waiting_rows[lane];
    uint next = waiting_rows[BATCH + lane];
    uint left = found - min(found, BATCH);
    uint count = 0u;
    if (is_in_batch() && lane < found) {
        count = particles[row].count;
    }
    uint sum = count + (count > 0u ? 1u << 24u : 0u);
    if (is_in_batch()) {
        batch_sums[lane] = sum;
    }
    [[unroll]] for (uint width = 1u; width < BATCH; width *= 2u) {
        barrier();
        sum += is_in_batch() && lane >= width ? batch_sums[lane - width] : 0u;
        barrier();
        if (is_in_batch()) {
            batch_sums[lane] = sum;
        }
    }
    uint start = (sum & 0xffffffu) - count;
    if (count > 0u) {
        uint slot = (sum >> 24u) - 1u;
        Particle particle = particles[row];
        bool is_near = (particle.flags & NEAR_CAMERA) != 0u;
        Source source = source_of(particle, vec2(0.0), origin);
        uint stretch = 0u;
        if (STRETCHED == 1u) {
            stretch = stretches[row];
        }
        batch_place[slot] = vec4(source.at, source.z, particle.colour.a);
        batch_slope[slot] = is_near ? vec4(source.from, -1.0, 0.0) : vec4(source.slope, particle.reach, uintBitsToFloat(stretch));
        batch_draw[slot] = uvec3(row + 1u, particle.id, particle.hash - start);
    }
    waiting_rows[lane] = next;
    if (lane == 0u) {
        waiting = left;
    }
    barrier();
    return Batch(batch_sums[BATCH - 1u] & 0xffffffu, left, count > 0u ? start : NOTHING);
}

// Makes render particle `t` of the batch, which is of the particle at `slot`, and notes which blocks it touches.
void note_sprite(Optics optics, uint slot, uint t, uint repetition, uint parity, Slabs slabs) {
    uint lane = gl_LocalInvocationID.x;
    vec4 place = batch_place[slot];
    vec3 slope = batch_slope[slot].xyz;
    vec2 stretch = vec2(0.0);
    if (STRETCHED == 1u) {
        stretch = stretch_of(floatBitsToUint(batch_slope[slot].w));
    }
    uvec3 draw = batch_draw[slot];
    bool has_slope = slope.z >= 0.0;
    Source source = Source(place.xy, place.z, has_slope ? slope.xy : vec2(0.0), has_slope ? vec2(0.0) : slope.xy, stretch);
    Sprite sprite = make_sprite(optics, source, pcg(t + draw.z), repetition);
    // Rounding: a thousandth of a pixel is more than it can be.
    vec2 reach = abs(slope.z) * optics.half_mask / (sprite.scale * vec2(1.0, optics.squash));
    reach = (STRETCHED == 1u ? reach * stretched_reach(stretch) : reach) + 1e-3;
    vec4 bounds = vec4(sprite.at - reach, sprite.at + reach);
    uint depth = order_of(sprite.z, slabs);
    uint limits[BLOCKS];
    [[unroll]] for (uint block = 0u; block < BLOCKS; ++block) {
        limits[block] = farthest[BLOCKS * parity + block];
    }
    uint touched = 0u;
    [[unroll]] for (uint block = 0u; block < BLOCKS; ++block) {
        vec2 corner = vec2(block_corner(block));
        bool is_near = all(lessThanEqual(bounds.xy, corner + (float(BLOCK) - 0.5))) && all(greaterThanEqual(bounds.zw, corner + 0.5));
        touched |= is_near && depth <= limits[block] ? 1u << (8u * block) : 0u;
    }
    if (sprite.exists && touched != 0u) {
        sprite_place[lane] = vec4(sprite.at, sprite.z, sprite.scale);
        sprite_draw[lane] = uvec4(draw.xy, sprite.texel, floatBitsToUint(place.w));
        if (STRETCHED == 1u) {
            sprite_stretch[lane] = floatBitsToUint(batch_slope[slot].w);
        }
        atomicOr(touches[(BATCH * parity + lane) / 8u], touched << (lane % 8u));
    }
}

// Whether `a` is below `b`, or, where they are equal, `next`. Nothing branches here, as `&&` and `||` may.
bool is_before(uint a, uint b, bool next) {
    return any(bvec2(a < b, all(bvec2(a == b, next))));
}

// Where a pixel of a column meets a sprite.
struct Meeting {
    Look look;
    float y;
};

// `look`, `y`: in the column's first row; `way`: there, from the sprite's centre, in pixels.
Meeting meeting_of(Look look, float y, int row, vec2 way, vec2 stretch, vec2 scale, float half_mask) {
    vec2 below = vec2(look.x, y + float(row) * scale.y);
    vec2 drawn = mask_way(way + vec2(0.0, float(row)), stretch, scale.y / scale.x) * scale.x + half_mask;
    vec2 at = mix(below, drawn, bvec2(STRETCHED == 1u));
    return Meeting(moved(look, at.x), at.y);
}

// Tests sprites, 32 from `first` on, against a column: those that `left` has a bit for. `centre`: of the column's pixel in the block's first row.
void test_sprites(uint left, uint first, Column column, vec2 centre, uint level, float half_mask, float squash, float threshold, Slabs slabs) {
    do {
        bool is_one = left != 0u;
        uint i = first + (uint(findLSB(left)) & 31u);
        left &= left - 1u;
        vec4 place = sprite_place[i];
        uvec4 sprite = sprite_draw[i];
        uint depth = floatBitsToUint(place.z);
        float alpha = uintBitsToFloat(sprite.w);
        vec2 scale = place.w * vec2(1.0, squash);
        vec2 t = (centre - place.xy) * scale + half_mask;
        Look look = begin_look(t.x, sprite.z, level, scale);
        uint slab = order_of(place.z, slabs);
        vec2 stretch = vec2(0.0);
        if (STRETCHED == 1u) {
            stretch = stretch_of(sprite_stretch[i]);
        }
        float values[ROWS];
        [[unroll]] for (int y = 0; y < ROWS; ++y) {
            Meeting at = meeting_of(look, t.y, column.row + y, centre - place.xy, stretch, scale, half_mask);
            values[y] = mask_value(at.look, at.y);
        }
        // What decides for all rows is asked once.
        if (has_octaves(look)) {
            [[unroll]] for (int y = 0; y < ROWS; ++y) {
                Meeting at = meeting_of(look, t.y, column.row + y, centre - place.xy, stretch, scale, half_mask);
                values[y] = detailed(at.look, at.y, values[y]);
            }
        }
        [[unroll]] for (int y = 0; y < ROWS; ++y) {
            float value = values[y];
            bool passes = all(bvec3(is_one, value > 0.0, alpha * value >= threshold));
            bool first_of_equals = is_before(sprite.y, nearest_id[y], sprite.x < nearest_row[y]);
            bool nearer = is_before(depth, nearest_depth[y], first_of_equals);
            bool hotter = any(bvec2(alpha > nearest_heat[y], all(bvec2(alpha == nearest_heat[y], nearer))));
            bool ahead = all(bvec2(depth < scene_depth[y], is_before(slab, nearest_slab[y], hotter)));
            bool wins = all(bvec2(passes, EMISSION == 1u ? ahead : nearer));
            nearest_slab[y] = wins ? slab : nearest_slab[y];
            nearest_heat[y] = wins ? alpha : nearest_heat[y];
            nearest_depth[y] = wins ? depth : nearest_depth[y];
            nearest_id[y] = wins ? sprite.y : nearest_id[y];
            nearest_row[y] = wins ? sprite.x : nearest_row[y];
        }
    } while (left != 0u);
}

// Which sprites of a round touch a block, 32 of them.
uint touching(uint block, uint word, uint parity) {
    uint bits = 0u;
    [[unroll]] for (uint i = 0u; i < 4u; ++i) {
        bits |= (touches[BATCH / 8u * parity + 4u * word + i] >> (8u * block) & 0xffu) << (8u * i);
    }
    return bits;
}

// Begins a round: notes how far away the farthest of what is nearest is. It can only come nearer, and what is behind all of it need not be looked at.
void begin_round(uint block, uint parity, bool skips) {
    uint own = skips ? 0u : INFINITY_BITS;
    [[unroll]] for (int y = 0; y < ROWS; ++y) {
        own = max(own, EMISSION == 1u ? nearest_slab[y] : nearest_depth[y]);
    }
    uint lane = gl_LocalInvocationID.x;
    if (ROWS == int(BLOCK)) {
        // Drivers that pack invocations into vectors do atomics one by one.
        columns_farthest[lane] = own;
        barrier();
        if (lane < BLOCKS) {
            uint all = 0u;
            [[unroll]] for (uint i = 0u; i < BLOCK; ++i) {
                all = max(all, columns_farthest[BLOCK * lane + i]);
            }
            farthest[lane] = all;
            touches[lane] = 0u;
        }
    } else {
        atomicMax(farthest[BLOCKS * parity + block], own);
    }
}

// Empties what a round leaves behind.
void empty_round(uint parity) {
    uint lane = gl_LocalInvocationID.x;
    if (lane < BATCH / 8u) {
        touches[BATCH / 8u * parity + lane] = 0u;
    }
    if (lane < WORDS) {
        starts[WORDS * parity + lane] = 0u;
    }
    if (lane < BLOCKS) {
        farthest[BLOCKS * parity + lane] = 0u;
    }
}

// The particles that have begun in a round: up to an invocation's sprite, and all.
uvec2 count_starts(uint parity) {
    uint lane = gl_LocalInvocationID.x;
    uvec2 count = uvec2(0u);
    [[unroll]] for (uint word = 0u; word < WORDS; ++word) {
        uint begun = starts[WORDS * parity + word];
        uint up_to_own = lane / 32u > word ? ~0u : lane / 32u == word ? ~0u >> (31u - lane % 32u) : 0u;
        count += uvec2(bitCount(begun & up_to_own), bitCount(begun));
    }
    return count;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uvec2 tile = tile_at(active_tiles[gl_WorkGroupID.x]);
    uint level = mask_level();
    uint entries_of_tile = join_lists(tile);
    uint segment = constants.part % control.segments;
    uint first_entry = segment * control.segment_entries;
    uint last_entry = min(first_entry + control.segment_entries, entries_of_tile);
    uint first = constants.first + constants.part / control.segments * control.part_repetitions;
    uint last = min(first + control.part_repetitions, constants.last);
    bool is_last_segment = segment + 1u == control.segments;

    Column column = own_column();
    uvec2 pixel = tile * TILE + column.corner + uvec2(column.x, uint(column.row));
    vec2 centre = vec2(column.corner) + vec2(float(column.x) + 0.5, 0.5);
    vec2 origin = vec2(tile * TILE);
    uint first_pixel = pixel_index(pixel);
    bool inside[ROWS];
    Sum sum[ROWS];
    uint before = params.repetitions_before;
    bool is_first = before + first == 0u;
    [[unroll]] for (int y = 0; y < ROWS; ++y) {
        inside[y] = pixel.x < params.size.x && pixel.y + uint(y) < params.size.y;
        uint at = first_pixel + uint(y) * params.size.x;
        scene_depth[y] = inside[y] ? INFINITY_BITS : 0u;
        if (HAS_SCENE == 1u) {
            if (inside[y]) {
                scene_depth[y] = floatBitsToUint(from_base(scene[at]));
            }
        }
        sum[y] = no_sum();
        if (inside[y] && !is_first) {
            sum[y] = load_sum(at);
        }
    }
    Optics optics = optics_of_frame(level);
    float threshold = params.threshold;
    bool skips = params.is_skipping != 0u;
    empty_round(0u);
    empty_round(1u);
    if (lane == 0u) {
        waiting = 0u;
    }
    barrier();
    uint parity = 0u;
    uint repetition = first;
    uint at = first_entry;
    uint left = 0u;
    do {
        bool is_first_batch = at == first_entry;
        Slabs slabs = slabs_of(before + repetition);
        uint found = find_batch(at, last_entry, left, is_first_batch, ROWS == int(BLOCK) ? 0u : 1u - parity, slabs);
        bool is_last_batch = at >= last_entry && found <= BATCH;
        Batch batch = load_batch(found, origin);
        left = batch.left;
        // One batch that is all of the list serves all repetitions.
        do {
            slabs = slabs_of(before + repetition);
            if (is_first_batch) {
                [[unroll]] for (int y = 0; y < ROWS; ++y) {
                    nearest_depth[y] = scene_depth[y];
                    nearest_id[y] = 0u;
                    nearest_row[y] = 0u;
                    nearest_heat[y] = -1.0;
                    if (segment > 0u && inside[y]) {
                        uvec4 winner = winners[first_pixel + uint(y) * params.size.x];
                        nearest_depth[y] = winner.x;
                        nearest_id[y] = winner.y;
                        nearest_row[y] = winner.z;
                        nearest_heat[y] = uintBitsToFloat(winner.w);
                    }
                    nearest_slab[y] = order_of(uintBitsToFloat(nearest_depth[y]), slabs);
                }
            }
            uint made = 0u;
            uint particles_before = 0u;
            do {
                begin_round(column.block, parity, skips);
                uint begins = batch.start - made;
                if (begins < BATCH) {
                    atomicOr(starts[WORDS * parity + begins / 32u], 1u << (begins % 32u));
                }
                barrier();
                if (ROWS != int(BLOCK)) {
                    empty_round(1u - parity);
                }
                uvec2 begun = count_starts(parity);
                if (is_in_batch() && made + lane < batch.total) {
                    note_sprite(optics, particles_before + begun.x - 1u, made + lane, before + repetition, parity, slabs);
                }
                particles_before += begun.y;
                made += BATCH;
                barrier();
                if (ROWS == int(BLOCK) && lane == 0u) {
                    starts[0] = 0u;
                }
                [[unroll]] for (uint word = 0u; word < WORDS; ++word) {
                    uint touching_block = touching(column.block, word, parity);
                    if (WORDS == 1u || touching_block != 0u) {
                        test_sprites(touching_block, 32u * word, column, centre, level, optics.half_mask, optics.squash, threshold, slabs);
                    }
                }
                parity = ROWS == int(BLOCK) ? 0u : 1u - parity;
            } while (made < batch.total);
            if (is_last_batch) {
                [[unroll]] for (int y = 0; y < ROWS; ++y) {
                    if (inside[y] && !is_last_segment) {
                        winners[first_pixel + uint(y) * params.size.x] = uvec4(nearest_depth[y], nearest_id[y], nearest_row[y], EMISSION == 1u ? floatBitsToUint(nearest_heat[y]) : 0u);
                    }
                    if (is_last_segment && nearest_row[y] != 0u) {
                        add_winner(sum[y], particles[nearest_row[y] - 1u].light, nearest_depth[y]);
                    }
                }
                ++repetition;
            }
        } while (is_first_batch && is_last_batch && repetition < last);
        at = is_last_batch ? first_entry : at;
    } while (repetition < last);
    [[unroll]] for (int y = 0; y < ROWS; ++y) {
        uint at = first_pixel + uint(y) * params.size.x;
        if (inside[y] && is_last_segment) {
            store_sum(at, sum[y]);
        }
    }
}
