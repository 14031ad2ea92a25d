// Moment-based order-independent transparency (Münstermann, Krumpen, Klein and Peters 2018) with power moments of absorbance over depth, in
// single precision: bias and overestimation are the paper's for that.
//
// A particle's absorbance before it is that of the canonical representation: the few points, one of them its own depth, whose weights have
// these moments. The orthogonal polynomials P of the moments give both (Christoffel and Darboux): with K(z, x) = sum of P_k(z) P_k(x) / d_k the
// other points are the roots x of K(z, x), and the weight of a point is 1 / K(x, x).
//
// What includes this says how many MOMENTS there are.
#include "bench_blend.glsl"
#include "bench_transmittance.glsl"

const float OVERESTIMATION = 0.25;  // how much of the weight at a particle's own depth is before it
const float FARTHEST_POINT = 1e6;         // of points

// Of 1, z ... z^6; the mean of z^k after `conclude`.
float moments[7];
float pixel_absorbance;
// P1 = z - b1, P2 = z^2 - b2 - l21 P1, P3 = z^3 - b3 - l31 P1 - l32 P2: the Cholesky decomposition of the Hankel matrix of moments.
float l21;
float l31;
float l32;
vec3 inverse_norms;  // 1 / d1 to 1 / d3

void clear_function() {
    [[unroll]] for (uint k = 0u; k < 7u; ++k) {
        moments[k] = 0.0;
    }
}

void record(float depth, float amount) {
    float z = 2.0 * depth - 1.0;
    float power = amount;
    [[unroll]] for (uint k = 0u; k <= MOMENTS; ++k) {
        moments[k] += power;
        power *= z;
    }
}

// Where rounding leaves no norm.
float inverse_norm(float norm) {
    return 1.0 / max(norm, 1e-9);
}

void conclude(float total) {
    pixel_absorbance = total;
    float bias = MOMENTS == 4u ? 5e-7 : 5e-6;
    vec3 even = MOMENTS == 4u ? vec3(0.375, 0.375, 0.0) : vec3(0.48, 0.451, 0.45);
    [[unroll]] for (uint k = 0u; k < 7u; ++k) {
        moments[k] = moments[k] / max(total, 1e-30) * (1.0 - bias);
    }
    float b1 = moments[1];
    float b2 = moments[2] + bias * even.x;
    float b3 = moments[3];
    float b4 = moments[4] + bias * even.y;
    float b5 = moments[5];
    float b6 = moments[6] + bias * even.z;
    moments[2] = b2;
    inverse_norms.x = inverse_norm(b2 - b1 * b1);
    float across21 = b3 - b1 * b2;
    l21 = across21 * inverse_norms.x;
    inverse_norms.y = inverse_norm(b4 - b2 * b2 - l21 * across21);
    if (MOMENTS == 4u) {
        return;
    }
    float across31 = b4 - b1 * b3;
    l31 = across31 * inverse_norms.x;
    float across32 = b5 - b2 * b3 - l21 * across31;
    l32 = across32 * inverse_norms.y;
    inverse_norms.z = inverse_norm(b6 - b3 * b3 - l31 * across31 - l32 * across32);
}

// P1 to P3.
vec3 polynomials(float z) {
    float p1 = z - moments[1];
    float p2 = z * z - moments[2] - l21 * p1;
    float p3 = MOMENTS == 4u ? 0.0 : z * z * z - moments[3] - l31 * p1 - l32 * p2;
    return vec3(p1, p2, p3);
}

float weight_at(float z) {
    vec3 p = polynomials(z);
    return 1.0 / (1.0 + dot(p * p, MOMENTS == 4u ? vec3(inverse_norms.xy, 0.0) : inverse_norms));
}

// Weight of the point at z + 1 / t where that is before z.
float weight_before(float z, float t) {
    return t < 0.0 ? weight_at(z + 1.0 / min(t, -1.0 / FARTHEST_POINT)) : 0.0;
}

// Roots of t^2 + m t + n; all are real but for rounding.
vec2 quadratic_roots(float m, float n) {
    float root = sqrt(max(0.25 * m * m - n, 0.0));
    float larger = -0.5 * m - (m < 0.0 ? -root : root);
    return vec2(larger, larger == 0.0 ? 0.0 : n / larger);
}

// That root of t^3 + a t^2 + b t + c which is farthest from their mean (Viète): it alone does not cancel.
float far_root(float a, float b, float c) {
    float mean = -a / 3.0;
    float p = max(mean * mean - b / 3.0, 0.0);
    float q = -mean * (mean * mean - 0.5 * b) + 0.5 * c;
    float y = 2.0 * sqrt(p) * cos(acos(min(abs(q) / max(p * sqrt(p), 1e-30), 1.0)) / 3.0);
    return mean + (q > 0.0 ? -y : y);
}

float absorbance_before(float depth, float own) {
    float z = 2.0 * depth - 1.0;
    vec3 p = polynomials(z);
    // K(z, z + 1 / t) t^n is a polynomial of t whose leading coefficient is K(z, z), at least 1; that of K(z, x) may vanish.
    vec3 scaled = p * (MOMENTS == 4u ? vec3(inverse_norms.xy, 0.0) : inverse_norms);
    float slope2 = 2.0 * z - l21;
    float k0 = 1.0 + dot(scaled, p);
    float k1 = scaled.x + scaled.y * slope2;
    float k2 = scaled.y;
    float before = OVERESTIMATION / k0;
    vec2 quadratic = vec2(k1, k2) / k0;
    if (MOMENTS == 6u) {
        k1 += scaled.z * (3.0 * z * z - l31 - l32 * slope2);
        k2 += scaled.z * (3.0 * z - l32);
        vec3 cubic = vec3(k1, k2, scaled.z) / k0;
        float t = far_root(cubic.x, cubic.y, cubic.z);
        before += weight_before(z, t);
        // Division by t - root, from the end where it is stable.
        quadratic.x = cubic.x + t;
        quadratic.y = cubic.y + t * quadratic.x;
        if (abs(t * t * t) > abs(cubic.z)) {
            quadratic.y = -cubic.z / t;
            quadratic.x = (quadratic.y - cubic.y) / t;
        }
    }
    vec2 t = quadratic_roots(quadratic.x, quadratic.y);
    return pixel_absorbance * (before + weight_before(z, t.x) + weight_before(z, t.y));
}
