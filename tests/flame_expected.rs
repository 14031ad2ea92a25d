//! The flame's expected image, what it is made of, and how hosts embed the effect: on a device under core and
//! synchronisation validation, against the references in f64 (`src/flame/reference`), and against the repetitions that
//! it is the limit of.
#![cfg(feature = "cli")]

mod common;

#[path = "flame_expected/accuracy.rs"]
mod accuracy;
#[path = "flame_expected/cases.rs"]
mod cases;
#[path = "flame_expected/colour.rs"]
mod colour;
#[path = "flame_expected/distance.rs"]
mod distance;
#[path = "flame_expected/extremes.rs"]
mod extremes;
#[path = "flame_expected/frames.rs"]
mod frames;
#[path = "flame_expected/host.rs"]
mod host;
#[path = "flame_expected/mask.rs"]
mod mask;
#[path = "flame_expected/scene.rs"]
mod scene;
#[path = "flame_expected/stochastic.rs"]
mod stochastic;
#[path = "flame_expected/table.rs"]
mod table;
