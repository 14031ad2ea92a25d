//! Readers and writers of the files that users have.

pub mod volume;
