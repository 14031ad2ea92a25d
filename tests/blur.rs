//! The blur on a device, against references in f64 and f32 and against itself. Every device is under core and
//! synchronisation validation, and a single message fails the test.
#![cfg(feature = "cli")]

mod common;

#[path = "blur/behind.rs"]
mod behind;
#[path = "blur/complete.rs"]
mod complete;
#[path = "blur/depth.rs"]
mod depth;
#[path = "blur/drawn.rs"]
mod drawn;
#[path = "blur/extent.rs"]
mod extent;
#[path = "blur/host.rs"]
mod host;
#[path = "blur/intervals.rs"]
mod intervals;
#[path = "blur/motion.rs"]
mod motion;
#[path = "blur/normals.rs"]
mod normals;
#[path = "blur/occluders.rs"]
mod occluders;
#[path = "blur/parts.rs"]
mod parts;
#[path = "blur/plan.rs"]
mod plan;
#[path = "blur/refine.rs"]
mod refine;
#[path = "blur/scenes.rs"]
mod scenes;
#[path = "blur/scratch.rs"]
mod scratch;
#[path = "blur/shade.rs"]
mod shade;
#[path = "blur/smears.rs"]
mod smears;
#[path = "blur/toon.rs"]
mod toon;
#[path = "blur/trajectory.rs"]
mod trajectory;
