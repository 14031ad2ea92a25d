// Error-free transformations: a result and what it lost in rounding.
#ifndef EXACT
#define EXACT

// a + b (Knuth).
vec2 two_sum(float a, float b) {
    precise float sum = a + b;
    precise float back = sum - a;
    precise float lost = (a - (sum - back)) + (b - back);
    return vec2(sum, lost);
}

// a * b (Dekker, Veltkamp).
vec2 two_product(float a, float b) {
    precise float product = a * b;
    precise float split_a = a * 4097.0;
    precise float high_a = split_a - (split_a - a);
    precise float low_a = a - high_a;
    precise float split_b = b * 4097.0;
    precise float high_b = split_b - (split_b - b);
    precise float low_b = b - high_b;
    precise float lost = ((high_a * high_b - product) + high_a * low_b + low_a * high_b) + low_a * low_b;
    return vec2(product, lost);
}

#endif
