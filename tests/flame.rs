//! The stochastic flame on a device, against the reference in f64 (`src/flame/reference`) and against itself. Every
//! device is under core and synchronisation validation, and a single message fails the test.
#![cfg(feature = "cli")]

mod common;

#[path = "flame/accumulation.rs"]
mod accumulation;
#[path = "flame/adaptive.rs"]
mod adaptive;
#[path = "flame/cel.rs"]
mod cel;
#[path = "flame/determinism.rs"]
mod determinism;
#[path = "flame/embers.rs"]
mod embers;
#[path = "flame/extremes.rs"]
mod extremes;
#[path = "flame/motion.rs"]
mod motion;
#[path = "flame/oracle.rs"]
mod oracle;
#[path = "flame/raster.rs"]
mod raster;
#[path = "flame/scratch.rs"]
mod scratch;
#[path = "flame/shapes.rs"]
mod shapes;
#[path = "flame/skipping.rs"]
mod skipping;
#[path = "flame/stochastic.rs"]
mod stochastic;
#[path = "flame/stretch.rs"]
mod stretch;
