//! The flame effect: repetitions against the integral, against the paper's own way and against blending; whole frames.

mod accumulate;
mod frame;
mod rivals;
mod scene;
mod truth;

use super::{Outcome, Session};

/// Name of the effect in rows.
const EFFECT: &str = "flame";

pub(crate) fn measure(session: &mut Session) -> Outcome {
    accumulate::measure(session)?;
    frame::measure(session)
}
