//! The table of compiled shaders that `build.rs` writes.

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
