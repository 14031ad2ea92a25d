// What a vertex says of its ember. A block, as the reactive mask does not ask for the light: without maintenance4, validation
// takes an output of a vertex that nothing reads for a fault.
flat vec2 middle;  // in pixels
flat float depth;  // in view
flat float radius;  // in pixels
flat vec3 light;
