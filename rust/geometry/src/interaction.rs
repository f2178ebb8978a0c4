//! Interaction regions of part pairs.
