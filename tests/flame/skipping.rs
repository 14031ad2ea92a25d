//! skipping
