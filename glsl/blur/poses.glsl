// World positions of points in poses.

// `place`: where the pose is among those on the device.
vec3 pose(uint place, uint point) {
    uint at = 3u * (place * params.points + point);
    return vec3(poses[at], poses[at + 1u], poses[at + 2u]);
}
