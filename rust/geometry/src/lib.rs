//! Geometry of articulated objects, one algorithm a file.
//!
//! What has a surface is a [`mesh::Mesh`], a validated triangle mesh with `f64` coordinates; scans are points. Every function
//! is deterministic: random draws come from a seed, and the result does not depend on the number of threads.

pub mod aabb;
pub mod adjacency;
mod all_neighbours;
pub mod articulated_pose;
mod box_search;
pub mod bvh;
mod clearance;
mod convex;
mod coupled_rotations;
mod delaunay;
pub mod error;
mod facing;
pub mod grouping;
pub mod hull;
pub mod interaction;
pub mod iou;
mod lanes;
pub mod manhattan;
pub mod mesh;
pub mod motion;
pub mod neighbours;
mod normals;
pub mod obb;
pub mod oriented_box;
pub mod parry;
mod pieces;
mod point_tree;
pub mod probes;
pub mod proximity;
mod quasi_random;
mod quickhull;
pub mod ransac;
pub mod raster;
mod rectangle;
mod revolution;
pub mod round_pieces;
mod sample_elimination;
pub mod sampling;
pub mod seen_box;
pub mod settled_pose;
pub mod similarity;
mod soft_fit;
#[cfg(test)]
mod soup;
mod strata;
pub mod surface;
pub mod sweep;
pub mod symmetric_box;
pub mod symmetry;
pub mod symmetry_test;
pub mod triangle;

pub use error::{GeometryError, Result};
pub use mesh::Mesh;
