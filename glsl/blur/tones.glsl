// How the light on a surface depends on its normal: places that both frames show, and what is found from them. A colour is
// what the surface is painted with times a tone, and the tone follows from how far the normal turns to a direction, the
// light's. Logarithms of colours are whole numbers here, so that sums do not depend on their order.

#include "bins.glsl"

const uint CLEAR = 77u;             // units of a change that is seen, over three channels
const uint TONE_STEPS = 48u;        // of the cosine to the light, from -1 to 1
const float LOGARITHM = 256.0;      // units of a logarithm
const int MOST_CHANGE = 1024;       // of a logarithm
const int EVEN = 128;               // tones of neighbouring steps that differ by less, over three channels, change evenly
const uint MOST_SITES = 32768u;     // places
const uint MOST_FEW = 8192u;        // places that the search begins with, after these
const uint MOST_FIRST = 8192u;      // places that its first rounds look at, after those
const uint WANTED_FIRST = 2048u;    // of all places; of those few that the search begins with they have the same share
const uint FIRST_SEARCHES = 2u;     // these rounds
const uint WANTED_SITES = 8192u;
const uint MOST_STRIDE = 256u;      // pixels from one place to the next along each axis
const uint FEW_WEIGHT = 8u;         // places that one stands for of those in every fourth column and second row
const uint SEARCHES = 6u;           // rounds of the search for the light
const uint STARTS = 512u;           // candidates of the first
const uint STILL_STARTS = 256u;     // of them, those where it stays
const uint TURNED_STARTS = 8u;      // around each direction, those where it turns
const float AROUND = 0.25;          // distance of these
const uint BESIDE = 5u;             // directions of each frame that later rounds try: the best, and those around it
const float REACH = 0.24;           // distance of those around it, which each round halves
const uint FIRST_STEPS = 16u;       // of the cosine in the first round
const uint SEARCH_STEPS = 32u;      // in later ones
const uint WHOLE = 16u;             // weight of a place; also of neighbouring steps having one tone
const uint RESIDUAL = 13u;          // what the tones that are found may leave of a place that counts wholly
const uint REPEATS = 5u;            // times that these are solved for
const uint ALLOWED = 4u;            // badness that each place of a surface may leave unexplained
const uint TONE_ROWS = TONE_STEPS + 2u; // of a surface: the light's directions in frames i and i + 1, the tone at each step

// A place that both frames show.
struct Site {
    vec4 normals[2];  // unit, in frames i and i + 1; w: the surface's number, unused
    ivec4 change;     // logarithm of the colour in frame i + 1 by that in frame i; how many places it stands for
};

// What has been found stands behind the tables of colours: of all (place 0), then of each surface, TONE_ROWS each, of
// which those of tones are logarithms.
uint row_of_light(uint place, uint frame) {
    return 2u * BINS * params.tables + TONE_ROWS * place + frame;
}

uint row_of_tone(uint place, uint step) {
    return row_of_light(place, 2u) + step;
}

uint step_of(vec3 light, vec3 normal, uint steps) {
    return uint(clamp((dot(light, normal) * 0.5 + 0.5) * float(steps), 0.0, float(steps) - 1.0));
}

#include "unit.glsl"
#include "common/half.glsl"
#include "samples.glsl"

// A channel that has a logarithm: what is not a number or below 0 is 0.
float lit(float channel) {
    return (channel > 0.0 ? min(channel, MOST_HALF) : 0.0) + LEAST_COLOUR;
}

uint sum_of(ivec3 change) {
    return uint(abs(change.x) + abs(change.y) + abs(change.z));
}

// A departure of logarithms, of little weight where it is small: an error of less than 0.3 hardly shows.
uint badness(uint residual) {
    return residual < CLEAR ? residual * residual / (2u * CLEAR) : residual - CLEAR / 2u;
}
