// Where a camera is and which way it looks, each as a sum of two floats.
struct CameraRows {
    vec4 eye;          // its position, high part; w: unused
    vec4 eye_low;      // what `eye` lost in rounding
    vec4 right;        // rows of the view rotation; w: unused
    vec4 up;
    vec4 forward;
    vec4 right_low;    // what they lost in rounding
    vec4 up_low;
    vec4 forward_low;
};
