//! Symmetries of a part.
