// Depth groups: in the low bits of words, and as bits of words of their own.
#ifndef GROUP
#define GROUP

const uint GROUP_BITS = 8u;                     // of a word that holds a group below and something else above
const uint GROUP_IDS = 1u << GROUP_BITS;        // numbers of groups; 0 is none
const uint GROUP_MASK = GROUP_IDS - 1u;
const uint TOUCHED = GROUP_MASK;                // of a tile: smoke is beside it; there is no such group
const uint GROUP_WORDS = GROUP_IDS / 32u;       // words of the groups of a tile, a bit each

// The bit of a group in its word of a tile, and in the one word of a block, where it stands for all groups that are equal
// modulo 32.
uint group_bit(uint group) {
    return 1u << (group & 31u);
}

#endif
