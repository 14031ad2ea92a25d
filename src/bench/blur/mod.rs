//! The blur effect: hulls against brute force, windows of trajectories against whole sequences, two rules of where
//! triangles are divided, what replaces hidden colours, passes instead of a mesh, whole frames.

mod complete;
mod draw;
mod extent;
mod frame;
mod passes;
mod refine;
mod scene;
mod trajectory;

use super::{Outcome, Session};

/// Name of the effect in rows.
const EFFECT: &str = "blur";

pub(crate) fn measure(session: &mut Session) -> Outcome {
    extent::measure(session)?;
    trajectory::measure(session)?;
    refine::measure(session)?;
    complete::measure(session)?;
    passes::measure(session)?;
    frame::measure(session)
}
