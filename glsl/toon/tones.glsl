const uint MOST_TONES = 256u;  // of an effect
