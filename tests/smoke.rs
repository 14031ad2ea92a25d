//! The smoke effect on a device, against the references in f64 (`src/smoke/reference`) and against itself. Every device
//! is under core and synchronisation validation, and a single message fails the test.
#![cfg(feature = "cli")]

mod common;

#[path = "smoke/coverage.rs"]
mod coverage;
#[path = "smoke/depth.rs"]
mod depth;
#[path = "smoke/detail.rs"]
mod detail;
#[path = "smoke/extremes.rs"]
mod extremes;
#[path = "smoke/frame.rs"]
mod frame;
#[path = "smoke/gaussian.rs"]
mod gaussian;
#[path = "smoke/graph.rs"]
mod graph;
#[path = "smoke/groups.rs"]
mod groups;
#[path = "smoke/host.rs"]
mod host;
#[path = "smoke/light.rs"]
mod light;
#[path = "smoke/motion.rs"]
mod motion;
#[path = "smoke/offline.rs"]
mod offline;
#[path = "smoke/particles.rs"]
mod particles;
#[path = "smoke/radius.rs"]
mod radius;
#[path = "smoke/scratch.rs"]
mod scratch;
#[path = "smoke/sequence.rs"]
mod sequence;
#[path = "smoke/shadow.rs"]
mod shadow;
#[path = "smoke/soft.rs"]
mod soft;
#[path = "smoke/spheres.rs"]
mod spheres;
#[path = "smoke/subresources.rs"]
mod subresources;
#[path = "smoke/surface.rs"]
mod surface;
#[path = "smoke/tone.rs"]
mod tone;
#[path = "smoke/views.rs"]
mod views;
