//! The Python module `kinmo._core`: one thin file a geometry module. Documentation and types: `python/kinmo/_core.pyi`.
#![allow(missing_docs)]

mod adjacency;
mod arrays;
mod batches;
mod boxes;
mod convert;
mod grouping;
mod groups;
mod interaction;
mod iou;
mod joints;
mod manhattan;
mod meshes;
mod motion;
mod neighbours;
mod numbers;
mod obb;
mod poses;
mod proximity;
mod raster;
mod sampling;
mod seen_boxes;
mod sweep;
mod symmetry;

use pyo3::prelude::*;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<meshes::Meshes>()?;
    for register in [
        adjacency::register,
        grouping::register,
        interaction::register,
        iou::register,
        manhattan::register,
        motion::register,
        neighbours::register,
        obb::register,
        poses::register,
        proximity::register,
        raster::register,
        sampling::register,
        seen_boxes::register,
        sweep::register,
        symmetry::register,
    ] {
        register(module)?;
    }
    Ok(())
}
