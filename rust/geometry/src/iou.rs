//! Intersection of oriented boxes.
