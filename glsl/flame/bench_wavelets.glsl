// Of the Haar wavelets over depth.
const uint WAVELET_RANK = 3u;
const uint WAVELET_BINS = 2u << WAVELET_RANK;  // and coefficients
