//! Geometry of articulated objects: one algorithm per file, in folders by purpose.
//!
//! Each folder uses only folders above it in this file. Surfaces are [`Mesh`] values, validated and in `f64`; scans are
//! points. Lengths are in the units of the input, angles in radians. Every function is deterministic: random draws come
//! from a seed, and the result does not depend on the number of threads.

/// Triangle meshes, their search trees, distances and components.
pub mod mesh {
    pub mod aabb;
    pub mod bvh;
    pub mod connected_components;
    pub(crate) mod disjoint_sets;
    pub mod part_surface;
    pub mod point_projection;
    pub mod surface_group;
    pub mod surface_patches;
    pub mod triangle;
    pub mod triangle_mesh;
}

/// Sampling of surfaces, neighbour searches, normals and Delaunay diagrams.
pub mod points {
    pub(crate) mod all_nearest_neighbours;
    pub(crate) mod delaunay;
    pub(crate) mod distinct_points;
    pub(crate) mod kd_tree;
    pub mod nearest_neighbours;
    pub mod neighbour_maximum;
    pub(crate) mod normal_estimation;
    pub(crate) mod perpendicular;
    pub(crate) mod point_columns;
    pub mod pointnet_grouping;
    pub(crate) mod quasi_random;
    pub(crate) mod sample_elimination;
    pub(crate) mod smallest_eigenvector;
    pub(crate) mod stratified_sampling;
    pub mod surface_sample;
    pub mod surface_sampling;
}

/// Joints, and points moved along them.
pub mod motion {
    pub mod joint_axis;
    pub mod point_motion;
}

/// Hulls, boxes, axes and symmetries fitted to parts.
pub mod fit {
    pub mod amodal_box;
    pub(crate) mod axis_of_revolution;
    pub mod box_iou;
    pub(crate) mod box_search;
    pub mod convex_hull;
    pub(crate) mod minimum_area_rectangle;
    pub mod minimum_volume_box;
    pub mod oriented_box;
    pub mod polyhedron;
    pub(crate) mod polyhedron_clipping;
    pub(crate) mod principal_axes;
    pub(crate) mod quickhull;
    pub mod round_pieces;
    pub mod symmetric_box;
    pub mod symmetry_detection;
    pub mod symmetry_test;
    pub(crate) mod vector_columns;
}

/// Distances, interaction regions and free travel of parts.
pub mod contact {
    pub(crate) mod clearance_grid;
    pub mod collision_probes;
    pub mod interaction_region;
    pub mod part_distance;
    pub mod sweep;
}

/// Rotations and similarity transforms from points with outliers.
pub mod pose {
    pub mod articulated_pose;
    pub(crate) mod axis_alignment;
    pub(crate) mod coupled_rotations;
    pub mod manhattan_frame;
    pub(crate) mod mixture_fit;
    pub(crate) mod nearest_rotation;
    pub mod pose_refinement;
    pub mod similarity;
    pub mod similarity_ransac;
}

/// Depth images and part images.
pub mod raster {
    pub mod depth_renderer;
    pub(crate) mod z_buffer;
}

pub mod error;
#[cfg(test)]
mod test_shapes;

pub use error::{GeometryError, Result};
pub use mesh::triangle_mesh::Mesh;
