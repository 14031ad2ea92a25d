// The strength of lines: from 0 to 1 of an inner one, below 0 of a silhouette.
const float SILHOUETTE = -1.0;
