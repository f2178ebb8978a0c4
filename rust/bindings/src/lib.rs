//! The Python module `kinmo._core`: one thin file per algorithm of `kinmo_geometry`, in the same folders.
//!
//! Arguments are checked in `arguments`. Documentation and types for Python are in `python/kinmo/_core.pyi`.
#![allow(missing_docs)]

/// Checked arguments of Python functions.
mod arguments {
    pub mod arrays;
    pub mod articulated_parts;
    pub mod boxes;
    pub mod groups;
    pub mod joints;
    pub mod numbers;
}

mod batches;
mod errors;

mod mesh {
    pub mod meshes;
    pub mod point_projection;
    pub mod surface_patches;
}

mod points {
    pub mod nearest_neighbours;
    pub mod neighbour_maximum;
    pub mod pointnet_grouping;
    pub mod surface_sampling;
}

mod motion {
    pub mod point_motion;
}

mod fit {
    pub mod amodal_box;
    pub mod bounding_boxes;
    pub mod box_iou;
    pub mod symmetries;
}

mod contact {
    pub mod interaction_region;
    pub mod part_distance;
    pub mod sweep;
}

mod pose {
    pub mod manhattan_frame;
    pub mod poses;
}

mod raster {
    pub mod depth_renderer;
}

use pyo3::prelude::*;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<mesh::meshes::Meshes>()?;
    for register in [
        contact::interaction_region::register,
        contact::part_distance::register,
        contact::sweep::register,
        fit::amodal_box::register,
        fit::bounding_boxes::register,
        fit::box_iou::register,
        fit::symmetries::register,
        mesh::point_projection::register,
        mesh::surface_patches::register,
        motion::point_motion::register,
        points::nearest_neighbours::register,
        points::neighbour_maximum::register,
        points::pointnet_grouping::register,
        points::surface_sampling::register,
        pose::manhattan_frame::register,
        pose::poses::register,
        raster::depth_renderer::register,
    ] {
        register(module)?;
    }
    Ok(())
}
