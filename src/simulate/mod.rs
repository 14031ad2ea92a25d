//! Makes input where the user has none.

pub mod smoke;
