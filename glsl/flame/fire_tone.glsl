// From a value `from` upwards fire has this colour.
struct Tone {
    float colour[3];  // linear RGB
    float from;
};
