// A stage's dispatches, where drivers end loops: so many as the longest list needs, all others empty. The mask is magnified at level 0, and
// minified otherwise: where there is a kernel for each, the other has nothing to do.
layout(push_constant) uniform PartsConstants {
    uint first;        // this stage's place in `part_arguments`
    uint parts;        // dispatches recorded for the stage, of each kernel
    uint kernels;      // 2: one where the mask is minified and one where it is magnified
    uint repetitions;  // of the stage
    uint done;         // repetitions of earlier stages
    uint budget;       // loop iterations that an invocation may take; NOTHING: as many as it likes
    uint base;         // iterations that a repetition takes besides its entries
    uint visit;        // iterations that an entry takes besides its render particles
    uint eighths;      // eighths of an iteration that each of those takes
} stage;

// How the work on lists is cut.
struct Parts {
    uint segments;         // parts that a list is cut into
    uint segment_entries;  // entries of each
    uint repetitions;      // of a dispatch
};

// So that each invocation stays within its loop budget.
Parts cut_lists() {
    uint total = control.listed;
    if (stage.budget == NOTHING) {
        return Parts(1u, max(total, 1u), params.iterations);
    }
    uint visit = stage.visit + (control.most * stage.eighths + 7u) / 8u;
    uint entries_at_once = max((stage.budget - stage.base) / visit, 1u);
    uint segments = max((total + entries_at_once - 1u) / entries_at_once, 1u);
    uint repetitions = segments > 1u ? 1u : max(stage.budget / (stage.base + total * visit), 1u);
    return Parts(segments, segments > 1u ? entries_at_once : max(total, 1u), min(repetitions, params.iterations));
}

// Arguments of the stage's dispatches over so many tiles.
void write_parts(uint segments, uint repetitions, uint tiles) {
    uint chunks = (stage.repetitions + repetitions - 1u) / max(repetitions, 1u);
    uint needed = control.listed == 0u ? 0u : chunks * segments;
    uint kernel = stage.kernels == 2u && mask_level() == 0u ? 1u : 0u;
    for (uint i = gl_LocalInvocationID.x; i < stage.kernels * stage.parts; i += gl_WorkGroupSize.x) {
        bool is_needed = i / stage.parts == kernel && i % stage.parts < needed;
        part_arguments[stage.first + i] = uvec4(is_needed ? tiles : 0u, 1u, 1u, 0u);
    }
}
