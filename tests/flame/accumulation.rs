//! accumulation
