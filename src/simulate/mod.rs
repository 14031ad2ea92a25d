//! Makes input where the user has none.
