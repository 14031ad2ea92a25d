// What embers look like, for those who place them and those who draw them.
const float ASIDE = 0.25;        // of how far one has risen, that it circles at
const float HOTTER = 0.35;       // than its particle one is: the share of what that lacks to the hottest
const float LEAST_RADIUS = 0.5;  // that one is drawn with, in pixels
