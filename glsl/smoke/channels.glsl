// What is smoothed beside luminance, and as luminance is: channels of the picture, one after the other.

uint channel_index(uint channel, uint pixel) {
    return channel * params.size.x * params.size.y + pixel;
}
