//! Frames as one submission and as many, and what is said of those that fail.
#![cfg(feature = "cli")]

mod common;

#[path = "submissions/faults.rs"]
mod faults;
#[path = "submissions/slices.rs"]
mod slices;
