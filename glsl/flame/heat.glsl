// What the look "cel" is made of: heat, the mean over repetitions of the winner's temperature as a share of the hottest, 0
// where there is none. Of a pixel that the scene hides nothing is known: it has no heat and no weight either.
layout(constant_id = 0) const uint EXPECTED = 0;   // 1: sums hold the integral, in shares of the brightest colour
layout(constant_id = 1) const uint HAS_SCENE = 0;  // 1: the scene's depth occludes
#include "sums.glsl"
#include "depth_range.glsl"

// In a tile of `n` repetitions. Colours are grey, and as bright as particles are hot.
float heat_at(uint at, float n, float brightest) {
    if (EXPECTED == 1u) {
        return uintBitsToFloat(sums[SUM_VECTORS * at].x) * brightest;
    }
    float sum = float(sums[SUM_VECTORS * at].x);
    // As much as a word holds of the largest.
    if (n > 65536.0) {
        sum += float(sums[SUM_VECTORS * at + 1u].x) * WORD;
    }
    return sum / n / LIGHT_STEPS * brightest;
}

bool is_covered(uint at) {
    uint last = sums[SUM_VECTORS * at].w;
    return EXPECTED == 1u ? uintBitsToFloat(last) < 1.0 : last > 0u;
}

// Whether the scene stands before the middle of the fire, and no fire before the scene.
bool is_hidden(uint at, bool has_fire) {
    vec2 ends = depth_range();
    return from_base(scene[at]) < 0.5 * (ends.x + ends.y) && !(has_fire && is_covered(at));
}
