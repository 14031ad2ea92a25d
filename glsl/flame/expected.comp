// The image that repetitions converge to: emission and absorption along each pixel's ray, depth bin by depth bin (E2 of the
// derivation: optical depth -n ln(1 - G) of each particle). Within a bin colours mix in proportion to the optical depths, and lean towards those
// of its neighbours: a bin is composited when the one behind it is known. Sums are integers: nothing depends on the order of the lists. Loops end at
// their bottom, as those of `accumulate` do.
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
layout(binding = 8, r32f) uniform readonly image2D kernel;
layout(std430, binding = 9) buffer Winners { uvec4 winners[]; };  // of an unfinished bin: sums of optical depth times squared colour
layout(std430, binding = 10) buffer Unlaid { vec4 unlaid[]; };  // between dispatches: the bin that is not composited yet, and the one before it
layout(constant_id = 1) const uint HAS_SCENE = 0;    // 1: the scene's depth occludes
layout(std430, binding = 11) readonly buffer Stretches { uint stretches[]; };
layout(constant_id = 3) const uint STRETCHED = 0;    // 1: what particles draw is drawn out along their motion
layout(constant_id = 2) const uint KEEP_LAYERS = 0;  // 1: the variance is asked for
#include "cells.glsl"
#include "depth_range.glsl"
#include "kernel.glsl"
#include "bins.glsl"
#include "stretch.glsl"
#include "sums.glsl"

const float FIXED = 16777216.0;  // 1 as a fixed-point number
const float FIXED_WORD = WORD / FIXED;
const float FIXED_SQUARES = 0.25 * FIXED;  // a sum of three
const float MOST_DEPTH = 127.0;  // optical depth of one particle in one bin
const uint UNLAID = UNLAID_VECTORS + KEEP_LAYERS;

shared uint queue[BLOCKS][BATCH];
shared uint queue_length[BLOCKS];
shared uint clearest;
shared uvec2 lists[MAX_CELL_LEVELS];

// What of a pixel is only needed between bins.
struct Finished {
    vec3 mean;
    float transmittance;  // before the bin that is not composited yet
    vec4 nearer_bin;      // the one before that: mean colour, optical depth
    vec3 nearer_square;   // its mean squared colours
    float depth_sum;
    float bin_square;     // sum of the mean squared colours of the bin that is not composited yet
};

// An invocation that has one pixel has no registers left for it while particles are added.
const uint SHARED_PIXELS = LANES / (TILE * TILE) * (TILE * TILE - 1u) + 1u;
shared vec4 finished[3u * SHARED_PIXELS];
shared float finished_squares[SHARED_PIXELS];
Finished finished_rows[ROWS];

// The pixels of the column.
vec3 second[ROWS];
uvec4 bin_low[ROWS];   // sums of the bin: optical depth times colour, optical depth
uvec4 bin_high[ROWS];
uvec4 square_low[ROWS];  // optical depth times squared colour, and its sum over the channels
uvec4 square_high[ROWS];
vec4 bins[ROWS];         // not composited yet: mean colour, optical depth
vec3 bin_squares[ROWS];  // mean squared colours
float scene_depth[ROWS];

Finished load_finished(int y) {
    Finished of_pixel = finished_rows[y];
    if (ROWS == 1) {
        uint at = gl_LocalInvocationID.x;
        vec4 a = finished[at], b = finished[SHARED_PIXELS + at], c = finished[2u * SHARED_PIXELS + at];
        of_pixel = Finished(a.xyz, a.w, b, c.xyz, c.w, finished_squares[at]);
    }
    return of_pixel;
}

void store_finished(int y, Finished of_pixel) {
    if (ROWS == 1) {
        uint at = gl_LocalInvocationID.x;
        finished[at] = vec4(of_pixel.mean, of_pixel.transmittance);
        finished[SHARED_PIXELS + at] = of_pixel.nearer_bin;
        finished[2u * SHARED_PIXELS + at] = vec4(of_pixel.nearer_square, of_pixel.depth_sum);
        finished_squares[at] = of_pixel.bin_square;
    } else {
        finished_rows[y] = of_pixel;
    }
}

// ln(1 - G) at a corner of the grid, between two depths.
float corner(ivec2 at, float share) {
    return mix(imageLoad(kernel, at).r, imageLoad(kernel, at + ivec2(1, 0)).r, share);
}

// ln(1 - G) at a place of the grid and two depths of it.
vec2 logarithms(vec2 place, vec2 depths, int class_index) {
    ivec2 low = ivec2(min(place, vec2(float(KERNEL_PLACES) - 1.001)));
    vec2 f = place - vec2(low);
    ivec2 k = ivec2(min(depths, vec2(float(KERNEL_DEPTHS) - 1.001)));
    vec2 g = depths - vec2(k);
    ivec2 at = kernel_texel(low, 0, class_index);
    ivec2 right = kernel_texel(ivec2(1, 0), 0, 0);
    ivec2 down = kernel_texel(ivec2(0, 1), 0, 0);
    vec2 here = vec2(corner(at + ivec2(k.x, 0), g.x), corner(at + ivec2(k.y, 0), g.y));
    vec2 beside = vec2(corner(at + right + ivec2(k.x, 0), g.x), corner(at + right + ivec2(k.y, 0), g.y));
    at += down;
    vec2 below = vec2(corner(at + ivec2(k.x, 0), g.x), corner(at + ivec2(k.y, 0), g.y));
    vec2 across = vec2(corner(at + right + ivec2(k.x, 0), g.x), corner(at + right + ivec2(k.y, 0), g.y));
    return mix(mix(here, beside, f.x), mix(below, across, f.x), f.y);
}

// The same at the nearest place of the grid.
float nearest_logarithm(vec2 place, float depth, int class_index) {
    int k = int(min(depth, float(KERNEL_DEPTHS) - 1.001));
    return corner(kernel_texel(ivec2(place + 0.5), k, class_index), depth - float(k));
}

// -ln(1 - x), without cancelling.
float depth_of(float x) {
    float series = x * (1.0 + x * (0.5 + x * (0.33333333 + x * 0.25)));
    float whole = -log(max(1.0 - x, 1e-30));
    return x < 0.02 ? series : whole;
}

// Where an offset from a particle's centre (metres, up) lies in the grid.
vec2 grid_place(vec2 offset) {
    return (vec2(offset.x, -offset.y) / kernel_reach() * 0.5 + 0.5) * LAST_PLACE;
}

// The middle of the part of a ball's depth before one (in radii from its centre), in metres from the centre.
float cap_middle(float depth) {
    float share = 1.0 - depth;
    return -0.75 * share * share / (1.0 + share) * params.bounding_radius;
}

// The middle of what lies between two depths (in radii): where a slanted ray meets most of it. Sprites much larger than the space lie there as
// the ball's volume does, much smaller ones evenly.
float slab_middle(vec2 depths) {
    vec2 squares = depths * depths;
    float inner = 1.0 - 0.5 * (squares.x + squares.y) + 1e-6;
    float volume = 1.0 - (squares.x + depths.x * depths.y + squares.y) / 3.0 + 1e-6;
    float share = params.sprite_size / (params.sprite_size + params.bounding_radius);
    return 0.5 * (depths.x + depths.y) * mix(1.0, inner / volume, share) * params.bounding_radius;
}

// ln(1 - G) before a depth, in radii from the centre: what passed there did so at other offsets than in the bin, on average at the middle of the
// cap before it.
float logarithm_before(vec2 centre, vec2 slope, float depth, int class_index) {
    vec2 place = clamp(grid_place(centre + cap_middle(depth) * slope), 0.0, LAST_PLACE);
    return nearest_logarithm(place, (depth * 0.5 + 0.5) * float(KERNEL_DEPTHS - 1u), class_index);
}

// How much G rises between two depths, over what is left of 1 - G. `centre`: of the particle to the ray at the particle's depth;
// `zeta`: metres behind the particle.
float rise(vec2 centre, vec2 slope, vec2 zeta, int class_index) {
    float per_depth = 1.0 / max(params.bounding_radius, 1e-12);
    // The ray slants through the space: its offset from the centre in the middle of what the bin holds of it.
    vec2 place = grid_place(centre + slab_middle(zeta * per_depth) * slope);
    vec2 depths = (zeta * per_depth * 0.5 + 0.5) * float(KERNEL_DEPTHS - 1u);
    vec2 ends = logarithms(clamp(place, 0.0, LAST_PLACE), depths, class_index);
    float passed = logarithm_before(centre, slope, zeta.x * per_depth, class_index);
    bool inside = all(bvec4(greaterThanEqual(place, vec2(0.0)), lessThanEqual(place, vec2(LAST_PLACE))));
    float x = exp(ends.x - passed) * opacity(max(ends.x - ends.y, 0.0));
    return inside ? x : 0.0;
}

// By what that is too large where the near plane, so many metres behind the particle, cuts into its space: what would be before it is not there, and
// has passed nowhere.
float cut_by_near(vec2 centre, vec2 slope, float begin, float near, int class_index) {
    float per_depth = 1.0 / max(params.bounding_radius, 1e-12);
    float passed = logarithm_before(centre, slope, begin * per_depth, class_index);
    float missing = 1.0 - exp(logarithm_before(centre, slope, clamp(near * per_depth, -1.0, 1.0), class_index));
    return 1.0 + exp(-passed) * missing;
}

// Share of a ball before a depth.
float ball_before(float zeta) {
    float share = clamp(zeta / max(params.bounding_radius, 1e-12) * 0.5 + 0.5, 0.0, 1.0);
    return share * share * (3.0 - 2.0 * share);
}

// The same of a particle below a pixel: without a table, whose middle pixels' centres would miss. A sprite is a pixel wide there and
// passes anywhere with one chance; the spread blurs its edges by an even density with a ball's variance. All pixels together see as
// much wherever it is.
float narrow_rise(vec2 centre, vec2 zeta, float near, float pixel, float chance) {
    float half_side = max(0.5 * params.sprite_size, 0.5 * pixel);
    float blur = max(0.775 * params.spread, 1e-4 * pixel);
    vec2 share = clamp((half_side + blur - abs(centre)) / (2.0 * blur), 0.0, 1.0);
    float all_of_it = chance * share.x * share.y;
    vec3 before = vec3(ball_before(zeta.x), ball_before(zeta.y), ball_before(near));
    return all_of_it * (before.y - before.x) / max(1.0 - all_of_it * (before.x - before.z), 1e-30);
}

// Where a pixel's ray meets a particle. Depths are those from the frame's base, but for `z`: from the eye.
struct Meeting {
    vec2 slope;   // how far it goes across with each metre of depth
    vec2 centre;  // from the particle to the ray, at the particle's depth
    vec2 zeta;    // where a bin, as far as the scene lets one see, begins and ends; metres behind the particle
};

Meeting meet(vec3 view, float z, vec2 stretch, vec2 bin, vec2 ray, float step_down, int row, int y) {
    vec2 slope = vec2(ray.x, ray.y - float(row + y) * step_down);
    float end = min(bin.y, scene_depth[y]);
    vec2 zeta = clamp(vec2(bin.x, end) - view.z, -params.bounding_radius, params.bounding_radius);
    Meeting met = Meeting(params.is_orthographic != 0u ? vec2(0.0) : slope, widening(z) * slope - view.xy, zeta);
    if (STRETCHED == 1u) {
        met.slope = drawn_back(met.slope, stretch);
        met.centre = drawn_back(met.centre, stretch);
    }
    return met;
}

// Adds a particle's share of a bin to a column of pixels. `ray`: slope of the one in the block's first row; each further row is `step_down` below.
void add_particle(bool is_one, uint row, Column column, vec2 bin, vec2 ray, float step_down, float brightest) {
    vec3 view = vec3(particles[row].view, particles[row].depth);
    int class_index = int(particles[row].class_index);
    float z = from_eye(view).z;
    float pixel = params.pixel_footprint * widening(z);
    bool narrow = is_narrow(pixel);
    float near = params.near - depth_base() - view.z;
    vec2 stretch = vec2(0.0);
    if (STRETCHED == 1u) {
        stretch = stretch_of(stretches[row]);
    }
    // What decides for all rows is asked once, and not in each.
    float rises[ROWS];
    if (narrow) {
        [[unroll]] for (int y = 0; y < ROWS; ++y) {
            Meeting met = meet(view, z, stretch, bin, ray, step_down, column.row, y);
            rises[y] = narrow_rise(met.centre, met.zeta, near, pixel, particles[row].chance);
        }
    } else {
        [[unroll]] for (int y = 0; y < ROWS; ++y) {
            Meeting met = meet(view, z, stretch, bin, ray, step_down, column.row, y);
            rises[y] = rise(met.centre, met.slope, met.zeta, class_index);
        }
        if (near > -params.bounding_radius) {
            [[unroll]] for (int y = 0; y < ROWS; ++y) {
                Meeting met = meet(view, z, stretch, bin, ray, step_down, column.row, y);
                rises[y] /= cut_by_near(met.centre, met.slope, met.zeta.x, near, class_index);
            }
        }
    }
    // Read no earlier than they are needed: registers are few.
    vec3 colour = particles[row].colour.rgb / brightest;
    float weight = is_one ? particles[row].weight : 0.0;
    [[unroll]] for (int y = 0; y < ROWS; ++y) {
        float h = min(weight * depth_of(clamp(rises[y], 0.0, 1.0)), MOST_DEPTH);
        h = bin.x < min(bin.y, scene_depth[y]) ? h : 0.0;
        uvec4 added = uvec4(vec4(h * colour, h) * FIXED + 0.5);
        bin_low[y] += added;
        bin_high[y] += uvec4(lessThan(bin_low[y], added));
        vec4 squares = vec4(colour * colour, dot(colour, colour));
        if (KEEP_LAYERS == 1u) {
            uvec3 square = uvec3(h * squares.xyz * FIXED + 0.5);
            square_low[y].xyz += square;
            square_high[y].xyz += uvec3(lessThan(square_low[y].xyz, square));
        }
        uint all_channels = uint(h * squares.w * FIXED_SQUARES + 0.5);
        square_low[y].w += all_channels;
        square_high[y].w += uint(square_low[y].w < all_channels);
    }
}

// The middle of a bin, in metres from the frame's base; what lies before the near plane is not there.
float middle(uint bin, vec2 scale) {
    vec2 ends = scale.x + vec2(float(bin), float(bin + 1u)) / scale.y;
    ends = max(ends, vec2(params.near - depth_base()));
    return 0.5 * (ends.x + ends.y);
}

// Composites the pending bin behind what is nearer; the finished one takes its place. `depth`: of the former.
void composite_bin(float depth) {
    [[unroll]] for (int y = 0; y < ROWS; ++y) {
        vec4 sum = vec4(bin_high[y]) * FIXED_WORD + vec4(bin_low[y]) / FIXED;
        vec4 farther = vec4(sum.rgb / max(sum.w, 1e-30), sum.w);
        Finished before = load_finished(y);
        float left = before.transmittance > OPAQUE ? before.transmittance : 0.0;
        float share = left * opacity(bins[y].w);
        vec3 slope = slope_of(before.nearer_bin, bins[y], farther);
        float leans = left * fade(bins[y], before.bin_square, slope) * leaning(bins[y].w);
        before.mean += max(share * bins[y].rgb + leans * slope, 0.0);
        vec4 squares = vec4(square_high[y]) * vec4(vec3(FIXED_WORD), 4.0 * FIXED_WORD) + vec4(square_low[y]) / vec4(vec3(FIXED), FIXED_SQUARES);
        squares /= max(sum.w, 1e-30);
        if (KEEP_LAYERS == 1u) {
            vec4 nearer = vec4(before.nearer_square, before.nearer_bin.w);
            vec3 square_slope = slope_of(nearer, vec4(bin_squares[y], bins[y].w), vec4(squares.xyz, sum.w));
            second[y] += max(share * bin_squares[y] + leans * square_slope, 0.0);
            before.nearer_square = bin_squares[y];
            bin_squares[y] = squares.xyz;
        }
        before.bin_square = squares.w;
        square_low[y] = uvec4(0u);
        square_high[y] = uvec4(0u);
        before.depth_sum += share * depth;
        before.transmittance -= share;
        before.nearer_bin = bins[y];
        store_finished(y, before);
        bins[y] = farther;
        bin_low[y] = uvec4(0u);
        bin_high[y] = uvec4(0u);
    }
}

// What the dispatch before has left: the bin that is not composited yet and the one before it, and sums of an unfinished one.
void load_unlaid(int y, uint at, bool is_there, bool is_unfinished, inout Finished of_pixel) {
    bins[y] = vec4(0.0);
    bin_squares[y] = vec3(0.0);
    square_low[y] = uvec4(0u);
    square_high[y] = uvec4(0u);
    if (is_there) {
        bins[y] = unlaid[UNLAID * at];
        of_pixel.nearer_bin = unlaid[UNLAID * at + 1u];
        vec4 squares = unlaid[UNLAID * at + 2u];
        bin_squares[y] = squares.xyz;
        of_pixel.bin_square = squares.w;
        if (KEEP_LAYERS == 1u) {
            of_pixel.nearer_square = unlaid[UNLAID * at + 3u].xyz;
        }
        if (is_unfinished) {
            square_low[y] = winners[UNFINISHED_VECTORS * at];
            square_high[y] = winners[UNFINISHED_VECTORS * at + 1u];
        }
    }
}

void store_unlaid(int y, uint at, bool is_finished, Finished of_pixel) {
    unlaid[UNLAID * at] = bins[y];
    unlaid[UNLAID * at + 1u] = of_pixel.nearer_bin;
    unlaid[UNLAID * at + 2u] = vec4(bin_squares[y], of_pixel.bin_square);
    if (KEEP_LAYERS == 1u) {
        unlaid[UNLAID * at + 3u] = vec4(of_pixel.nearer_square, 0.0);
    }
    if (!is_finished) {
        winners[UNFINISHED_VECTORS * at] = square_low[y];
        winners[UNFINISHED_VECTORS * at + 1u] = square_high[y];
    }
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uvec2 tile = tile_at(active_tiles[gl_WorkGroupID.x]);
    uint buckets = params.bucket_count;
    float brightest = max(uintBitsToFloat(control.brightest), 1e-30);
    vec2 scale = bucket_scale();
    // How many buckets before a bin particles may begin that reach into it.
    uint window = min(uint(2.0 * params.bounding_radius * scale.y * 1.0001) + 2u, buckets);
    uint segment = constants.part % control.segments;
    uint first = constants.part / control.segments * control.part_repetitions;
    uint last = min(first + control.part_repetitions, buckets);
    bool is_last_segment = segment + 1u == control.segments;

    Column column = own_column();
    uvec2 pixel = tile * TILE + column.corner + uvec2(column.x, uint(column.row));
    vec2 ray = ray_at(vec2(tile * TILE + column.corner + uvec2(column.x, 0u)) + 0.5);
    uint first_pixel = pixel_index(pixel);
    bool inside[ROWS];
    [[unroll]] for (int y = 0; y < ROWS; ++y) {
        inside[y] = pixel.x < params.size.x && pixel.y + uint(y) < params.size.y;
        uint at = first_pixel + uint(y) * params.size.x;
        scene_depth[y] = uintBitsToFloat(INFINITY_BITS);
        if (HAS_SCENE == 1u) {
            if (inside[y]) {
                scene_depth[y] = from_base(scene[at]);
            }
        }
        uvec4 a = uvec4(0u, 0u, 0u, floatBitsToUint(1.0)), b = uvec4(0u), c = uvec4(0u), d = uvec4(0u);
        if (inside[y] && constants.part > 0u) {
            a = sums[SUM_VECTORS * at];
            b = sums[SUM_VECTORS * at + 1u];
            c = sums[SUM_VECTORS * at + 2u];
            d = sums[SUM_VECTORS * at + 3u];
        }
        float transmittance = inside[y] ? uintBitsToFloat(a.w) : 0.0;
        Finished of_pixel = Finished(uintBitsToFloat(a.xyz), transmittance, vec4(0.0), vec3(0.0), uintBitsToFloat(b.w), 0.0);
        second[y] = uintBitsToFloat(b.xyz);
        bin_low[y] = c;
        bin_high[y] = d;
        load_unlaid(y, at, inside[y] && constants.part > 0u, segment > 0u, of_pixel);
        store_finished(y, of_pixel);
    }
    if (lane < BLOCKS) {
        queue_length[lane] = 0u;
    }
    if (lane == 0u) {
        clearest = floatBitsToUint(1.0);
    }
    barrier();
    uint bin = first;
    do {
        // What is left of the tile's lists: particles that begin in the window before the bin or in it.
        if (lane < params.cell_level_count) {
            uint cell = cell_index(lane, tile.x >> lane, tile.y >> lane) * buckets;
            uint from = cell + (bin > window ? bin - window : 0u);
            uint begin = from == 0u ? 0u : cell_ends[from - 1u];
            lists[lane] = uvec2(begin, cell_ends[cell + bin]);
        }
        barrier();
        uint total = 0u;
        for (uint level = 0u; level < params.cell_level_count; ++level) {
            total += lists[level].y - lists[level].x;
        }
        bool is_seen = uintBitsToFloat(clearest) > OPAQUE || params.is_skipping == 0u;
        uint from = segment * control.segment_entries;
        uint to = is_seen ? min(from + control.segment_entries, total) : 0u;
        vec2 depths = vec2(scale.x + float(bin) / scale.y, scale.x + float(bin + 1u) / scale.y);
        depths = max(depths, vec2(params.near - depth_base()));
        uint at = from;
        do {
            if (is_in_batch() && at + lane < to) {
                uint index = at + lane;
                uint level = 0u;
                while (index >= lists[level].y - lists[level].x) {
                    index -= lists[level].y - lists[level].x;
                    ++level;
                }
                uint row = entries[lists[level].x + index];
                vec3 view = vec3(particles[row].view, particles[row].depth);
                vec2 farther = vec2(1.0);
                if (STRETCHED == 1u) {
                    farther = stretched_reach(stretch_of(stretches[row]));
                }
                vec4 bounds = pixel_bounds(from_eye(view), 1.0, farther) - vec4(vec2(tile * TILE), vec2(tile * TILE));
                bool reaches = view.z + params.bounding_radius >= depths.x && view.z - params.bounding_radius <= depths.y;
                [[unroll]] for (uint other = 0u; other < BLOCKS; ++other) {
                    vec2 low = vec2(block_corner(other));
                    bvec4 touches = bvec4(lessThanEqual(bounds.xy, low + float(BLOCK)), greaterThanEqual(bounds.zw, low));
                    if (all(touches) && reaches) {
                        queue[other][atomicAdd(queue_length[other], 1u)] = row;
                    }
                }
            }
            barrier();
            uint length = queue_length[column.block];
            uint i = 0u;
            do {
                bool is_one = i < length;
                add_particle(is_one, is_one ? queue[column.block][i] : 0u, column, depths, ray, params.pixel_slope.y, brightest);
                ++i;
            } while (i < length);
            barrier();
            if (lane < BLOCKS) {
                queue_length[lane] = 0u;
            }
            barrier();
            at += BATCH;
        } while (at < to);
        if (is_last_segment) {
            // Nothing is behind the last bin: it is composited as well.
            uint due = bin + 1u == buckets ? 2u : 1u;
            uint composited = 0u;
            do {
                composite_bin(middle(max(bin + composited, 1u) - 1u, scale));
                ++composited;
            } while (composited < due);
        }
        if (lane == 0u) {
            clearest = 0u;
        }
        barrier();
        float own = 0.0;
        [[unroll]] for (int y = 0; y < ROWS; ++y) {
            own = max(own, load_finished(y).transmittance);
        }
        atomicMax(clearest, floatBitsToUint(max(own, 0.0)));
        barrier();
        ++bin;
    } while (bin < last);
    bool is_done = last == buckets && is_last_segment;
    [[unroll]] for (int y = 0; y < ROWS; ++y) {
        uint at = first_pixel + uint(y) * params.size.x;
        Finished of_pixel = load_finished(y);
        if (inside[y] && !is_done) {
            store_unlaid(y, at, is_last_segment, of_pixel);
        }
        if (inside[y]) {
            sums[SUM_VECTORS * at] = uvec4(floatBitsToUint(of_pixel.mean), floatBitsToUint(of_pixel.transmittance));
            sums[SUM_VECTORS * at + 1u] = uvec4(floatBitsToUint(second[y]), floatBitsToUint(of_pixel.depth_sum));
            sums[SUM_VECTORS * at + 2u] = bin_low[y];
            sums[SUM_VECTORS * at + 3u] = bin_high[y];
        }
    }
}
