//! Points moved along candidate joints.
