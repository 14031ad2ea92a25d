const uint NO_CHANNEL = 0xffffffffu;  // what a kernel is told where something has no channel
