//! The table of compiled shaders: as `build.rs` writes it, or as it is in the package.

#[cfg(feature = "compile-shaders")]
include!(concat!(env!("OUT_DIR"), "/shaders/table.rs"));
#[cfg(not(feature = "compile-shaders"))]
include!("../shaders/table.rs");
