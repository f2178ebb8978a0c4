//! Exact distances between parts.
