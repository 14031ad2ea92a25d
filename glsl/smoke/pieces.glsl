const uint PIECE_REACH = 14u;  // the most pixels that a piece of a line must reach over; one less than four bits hold
