// Which pixels may be ink: a bit a pixel, a word a row of a tile, in planes. Tiles that show nothing have none.
const uint WEAK = 0u;    // what is ink if it goes on from a strong one, and all strong ones
const uint STRONG = 1u;  // what is ink
const uint INK_PLANES = 2u;
const uint INK_WORDS = INK_PLANES * TILE;  // of a tile
const uint TRACE_REACH = 16u;              // the most pixels that a weak line goes on
const uint PIECE_REACH = 13u;  // the most pixels that a piece of a line must reach over; both reaches are within a tile
