// What the Gaussian smooths separately: the pixels of each group, or, with the mask "soft", what pixels add to each plane of
// depth (coordinate.glsl). A plane goes by its number where a group does, from 0.
#include "group.glsl"

layout(constant_id = 0) const bool SOFT = false;

// Bits of the groups whose pixels add to the sums of a group, or of a plane: those before and behind it.
uint adding_bits(uint group) {
    return SOFT ? group_bit(group) | group_bit(group + 1u) : group_bit(group);
}
