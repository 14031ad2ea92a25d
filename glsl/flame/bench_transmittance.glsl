// The two geometry passes of blending by a function of transmittance over depth. The first adds each particle's absorbance, -ln(1 - opacity), to
// the function; the second composites colours with the transmittance at their depths, normalised so that all of them together are as opaque as
// the total absorbance says (Münstermann et al. 2018). The function stays in registers, where the papers write it to memory between the passes.
// Depth is its logarithm, from 0 to 1 over what the frame shows.
//
// What includes this defines the functions.
const float MOST_ABSORBANCE = 10.0;  // of a particle: sums in single precision keep digits of what is before an opaque one

// Nothing is recorded.
void clear_function();
// Adds an absorbance at a depth to the function.
void record(float depth, float amount);
// After the last: what the pixel's total is.
void conclude(float total);
// Absorbance before a depth, as a particle there of this absorbance sees it.
float absorbance_before(float depth, float own);

vec2 logarithm_range() {
    vec2 ends = log(max(depth_range() + depth_base(), 1e-30));
    return vec2(ends.x, max(ends.y - ends.x, 1e-6));
}

float warped_depth(uint row, vec2 range) {
    return clamp((log(particles[row].depth + depth_base()) - range.x) / range.y, 0.0, 1.0);
}

void main() {
    note_rows();
    Pixel pixel = own_pixel();
    vec2 range = logarithm_range();
    uint words = (params.particle_count + 31u) / 32u;
    clear_function();
    float total = 0.0;
    for (uint word = 0u; word < words; ++word) {
        for (uint bits = present[pixel.block][word]; bits != 0u; bits &= bits - 1u) {
            uint row = 32u * word + uint(findLSB(bits));
            float amount = min(absorbance(row, pixel.ray), MOST_ABSORBANCE);
            record(warped_depth(row, range), amount);
            total += amount;
        }
    }
    conclude(total);
    vec4 sum = vec4(0.0);
    for (uint word = 0u; word < words; ++word) {
        for (uint bits = present[pixel.block][word]; bits != 0u; bits &= bits - 1u) {
            uint row = 32u * word + uint(findLSB(bits));
            float amount = min(absorbance(row, pixel.ray), MOST_ABSORBANCE);
            float weight = opacity(amount) * exp(-absorbance_before(warped_depth(row, range), amount));
            sum += weight * vec4(particles[row].colour.rgb, 1.0);
        }
    }
    if (pixel.inside) {
        blended[pixel.at] = opacity(total) * vec4(sum.rgb / max(sum.a, 1e-30), 1.0);
    }
}
