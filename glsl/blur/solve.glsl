// Tones that explain best how colours change between two frames: a workgroup solves its normal equations.
layout(std430, binding = 1) readonly buffer Sites { Site sites[]; };
layout(std430, binding = 2) buffer Lights { vec4 lights[]; };
layout(std430, binding = 3) buffer Completing { uint completing[]; };

const uint ALL = NONE;  // of the surfaces

// The equations' matrix and right sides, whole numbers at first, then the bits of others.
shared int cells[TONE_STEPS * TONE_STEPS];
shared int rights[3u * TONE_STEPS];
shared int tones[3u * TONE_STEPS];
// Tones of all, from which a surface's depart by `tones`; 0 while these are not known.
shared int common_tones[3u * TONE_STEPS];

// Where the places of a round of the search begin, and how many there are; of what follows it: all places. None, if there was no room for all of them.
uvec2 places(uint round) {
    bool is_first = round < FIRST_SEARCHES;
    bool are_few = round < SEARCHES;
    uint count = completing[is_first ? FIRST_COUNT : are_few ? FEW_COUNT : SITE_COUNT];
    bool fits = completing[SITE_COUNT] <= MOST_SITES && completing[FEW_COUNT] <= MOST_FEW && completing[FIRST_COUNT] <= MOST_FIRST;
    return uvec2(is_first ? MOST_SITES + MOST_FEW : are_few ? MOST_SITES : 0u, fits ? count : 0u);
}

uvec2 steps_at(Site site, vec3 earlier, vec3 later, uint steps) {
    return uvec2(step_of(later, site.normals[1].xyz, steps), step_of(earlier, site.normals[0].xyz, steps));
}

// How a place's colour changes, less what the common tones explain.
int change_of(Site site, uvec2 at, uint channel) {
    return site.change[channel] - common_tones[3u * at.x + channel] + common_tones[3u * at.y + channel];
}

void begin_solving() {
    for (uint i = gl_LocalInvocationIndex; i < 3u * TONE_STEPS; i += gl_WorkGroupSize.x) {
        common_tones[i] = 0;
    }
    barrier();
}

uint residual_of(Site site, uvec2 at) {
    uint sum = 0u;
    for (uint i = 0u; i < 3u; ++i) {
        sum += uint(abs(tones[3u * at.x + i] - tones[3u * at.y + i] - change_of(site, at, i)));
    }
    return sum;
}

// Sums up the equations, of all places or of those of a surface. A place counts less where the tones leave more than `scale` unexplained; 0: all count alike.
void gather(uvec2 range, vec3 earlier, vec3 later, uint steps, uint scale, uint surface) {
    uint lane = gl_LocalInvocationIndex;
    for (uint i = lane; i < steps * steps; i += gl_WorkGroupSize.x) {
        cells[i] = 0;
    }
    for (uint i = lane; i < 3u * steps; i += gl_WorkGroupSize.x) {
        rights[i] = 0;
    }
    barrier();
    for (uint i = lane; i < range.y; i += gl_WorkGroupSize.x) {
        Site site = sites[range.x + i];
        if (surface != ALL && uint(site.normals[0].w) != surface) {
            continue;
        }
        uvec2 at = steps_at(site, earlier, later, steps);
        if (at.x == at.y) {
            continue;
        }
        uint weight = WHOLE;
        if (scale > 0u) {
            uint residual = residual_of(site, at);
            weight = residual <= scale ? WHOLE : (WHOLE * scale + residual / 2u) / residual;
        }
        weight *= uint(site.change.w);
        atomicAdd(cells[at.x * steps + at.y], int(weight));
        for (uint c = 0u; c < 3u && weight > 0u; ++c) {
            atomicAdd(rights[3u * at.x + c], int(weight) * change_of(site, at, c));
            atomicAdd(rights[3u * at.y + c], -int(weight) * change_of(site, at, c));
        }
    }
    barrier();
}

// Solves them: neighbouring steps tend to have one tone, and tones tend to 0, so that there is always a solution.
void solve(uint steps) {
    uint lane = gl_LocalInvocationIndex;
    for (uint i = lane; i < steps * steps; i += gl_WorkGroupSize.x) {
        uint row = i / steps;
        uint column = i % steps;
        if (row < column) {
            int sum = cells[i] + cells[column * steps + row] + (column == row + 1u ? int(WHOLE) : 0);
            cells[i] = -sum;
            cells[column * steps + row] = -sum;
        }
    }
    barrier();
    if (lane < steps) {
        int sum = 1;
        for (uint column = 0u; column < steps; ++column) {
            sum -= column == lane ? 0 : cells[lane * steps + column];
        }
        cells[lane * steps + lane] = sum;
    }
    barrier();
    for (uint i = lane; i < steps * steps; i += gl_WorkGroupSize.x) {
        cells[i] = floatBitsToInt(float(cells[i]));
    }
    for (uint i = lane; i < 3u * steps; i += gl_WorkGroupSize.x) {
        rights[i] = floatBitsToInt(float(rights[i]));
    }
    barrier();
    for (uint pivot = 0u; pivot + 1u < steps; ++pivot) {
        float diagonal = intBitsToFloat(cells[pivot * steps + pivot]);
        uint side = steps - 1u - pivot;
        // Of each row below: the columns beyond, and three right sides.
        for (uint i = lane; i < side * (side + 3u); i += gl_WorkGroupSize.x) {
            uint row = pivot + 1u + i / (side + 3u);
            uint column = i % (side + 3u);
            float factor = intBitsToFloat(cells[row * steps + pivot]) / diagonal;
            if (column < side) {
                uint at = row * steps + pivot + 1u + column;
                float above = intBitsToFloat(cells[pivot * steps + pivot + 1u + column]);
                cells[at] = floatBitsToInt(intBitsToFloat(cells[at]) - factor * above);
            } else {
                uint at = 3u * row + column - side;
                float above = intBitsToFloat(rights[3u * pivot + column - side]);
                rights[at] = floatBitsToInt(intBitsToFloat(rights[at]) - factor * above);
            }
        }
        barrier();
    }
    for (uint left = steps; left > 0u; --left) {
        uint pivot = left - 1u;
        float diagonal = intBitsToFloat(cells[pivot * steps + pivot]);
        for (uint i = lane; i < 3u * pivot; i += gl_WorkGroupSize.x) {
            float solved = intBitsToFloat(rights[3u * pivot + i % 3u]) / diagonal;
            float factor = intBitsToFloat(cells[i / 3u * steps + pivot]);
            rights[i] = floatBitsToInt(intBitsToFloat(rights[i]) - factor * solved);
        }
        if (lane < 3u) {
            tones[3u * pivot + lane] = int(floor(intBitsToFloat(rights[3u * pivot + lane]) / diagonal + 0.5));
        }
        barrier();
    }
}

// Candidates of a round of the search, and where they stand: earlier and later direction; bits of what they leave
// unexplained in the first's w.
uint candidates_of(uint round) {
    return round == 0u ? STARTS : BESIDE * BESIDE;
}

uint candidate_at(uint round, uint index) {
    return 2u * ((round & 1u) * STARTS + index);
}

shared uint least[2];

// The best candidate of a round, the first of those that are equally good.
uint best_of(uint round) {
    uint lane = gl_LocalInvocationIndex;
    if (lane < 2u) {
        least[lane] = NONE;
    }
    barrier();
    uint count = candidates_of(round);
    for (uint i = lane; i < count; i += gl_WorkGroupSize.x) {
        atomicMin(least[0], floatBitsToUint(lights[candidate_at(round, i)].w));
    }
    barrier();
    for (uint i = lane; i < count; i += gl_WorkGroupSize.x) {
        if (floatBitsToUint(lights[candidate_at(round, i)].w) == least[0]) {
            atomicMin(least[1], i);
        }
    }
    barrier();
    return least[1];
}
