// What is known of each of a pixel's four samples, row by row of a picture that is twice as large.
#ifndef BLUR_SAMPLES
#define BLUR_SAMPLES

// Which frames show it: the mask of a state, and of layers. 0: neither.
const uint SHOWN_PREVIOUS = 1u;
const uint SHOWN_NEXT = 2u;
const uint SHOWN_BOTH = SHOWN_PREVIOUS | SHOWN_NEXT;
const uint NOTHING_SEEN = 4u;  // it sees nothing of the mesh
const uint MASK = 7u;          // all of these
// The rest of a state.
const uint KNOWN = 8u;        // its colour is final
const uint PENDING = 16u;     // its colour is to be made from its neighbours'
const uint MADE = 32u;        // in this round
const uint STILL = 64u;       // what it sees stays where it is
const uint COUNT_SHIFT = 8u;  // how many of its neighbours can give it a colour

// Places in what completion works on.
const uint BORDER_DISPATCHES = 0u;  // of the dispatch that counts neighbours; the second's four words later
const uint INWARD_DISPATCHES = 8u;  // of those that go inward
const uint SCALES = 16u;            // the largest channel of frames i and i + 1
const uint LARGEST_VALUE = 18u;     // the largest value
const uint HEADS = 20u;             // where what is left of each of four lists begins; the second's eight words later
const uint TAILS = 24u;             // and where it ends
const uint OVERFLOWS = 36u;         // whether there was no room for a list
const uint MOVING_COUNT = 38u;      // pixels of both frames that see what moves
const uint SITE_COUNT = 39u;        // places that both show; of those the few that the search begins with
const uint FEW_COUNT = 40u;
const uint FIRST_COUNT = 43u;       // and those with which its first rounds do
const uint UNEXPLAINED = 41u;       // what tones leave unexplained of how these change, and all of it
const uint SURFACES = 64u;          // the same of each surface, two words; before, how many places show it

const float LEAST_COLOUR = 0.01;  // added to colours: what is black has no tone, and changes by no factor

#endif
