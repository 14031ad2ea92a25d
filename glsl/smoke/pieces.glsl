const uint PIECE_REACH = 14u;  // pixels along a line that are looked at, and the most that one must reach over
