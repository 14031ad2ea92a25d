//! The shaders: compiled from `glsl/` (feature `compile-shaders`), or as they are in `shaders/`.

#[cfg(feature = "compile-shaders")]
#[path = "build/compile.rs"]
mod compile;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    #[cfg(feature = "compile-shaders")]
    compile::all();
}
