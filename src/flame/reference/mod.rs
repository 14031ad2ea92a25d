//! The flame effect in f64 on the CPU, written from its definition and not from the shaders: what tests and the
//! benchmark compare the GPU with. Clear before fast.
