//! Makes input where the user has none.

pub mod flame;
pub mod mesh;
pub mod smoke;
