//! Points on surfaces.
