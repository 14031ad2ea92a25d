// Arguments of a stage's dispatches: so many as the longest list needs, all others empty. The mask is magnified at level 0, and minified
// otherwise: a kernel for each, of which the other has nothing to do.
layout(push_constant) uniform PartsConstants {
    uint first;        // this stage's place in `part_arguments`
    uint parts;        // dispatches recorded for the stage
    uint repetitions;  // of the stage
    uint done;         // repetitions of earlier stages
} stage;

void write_parts(uint lane, uint tiles) {
    uint chunks = (stage.repetitions + control.part_repetitions - 1u) / max(control.part_repetitions, 1u);
    uint needed = control.listed == 0u ? 0u : chunks * control.segments;
    bool magnified = mask_level() == 0u;
    for (uint part = lane; part < stage.parts; part += gl_WorkGroupSize.x) {
        uvec4 arguments = uvec4(part < needed ? tiles : 0u, 1u, 1u, 0u);
        part_arguments[stage.first + part] = magnified ? uvec4(0u, 1u, 1u, 0u) : arguments;
        part_arguments[stage.first + stage.parts + part] = magnified ? arguments : uvec4(0u, 1u, 1u, 0u);
    }
}
