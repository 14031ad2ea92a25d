// A point as a directional light sees it: x, y across, z towards the light.
vec3 in_light_space(vec3 p) {
    return vec3(dot(params.light_right.xyz, p), dot(params.light_up.xyz, p), dot(params.light.xyz, p));
}
