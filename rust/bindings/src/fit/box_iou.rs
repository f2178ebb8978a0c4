//! `box_intersection_volume` and `box_iou`: exact overlap of oriented boxes.

use kinmo_geometry::GeometryError;
use kinmo_geometry::fit::box_iou as iou;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arguments::arrays::Array;
use crate::arguments::boxes::boxes_of;
use crate::batches::map_in_batches;
use crate::errors::value_error;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(box_intersection_volume, module)?)?;
    module.add_function(wrap_pyfunction!(box_iou, module)?)
}

/// Defines a Python function that measures pairs of boxes from two lists of equal length.
macro_rules! measure_of_box_pairs {
    ($name:ident, $measure:path) => {
        #[pyfunction]
        fn $name<'py>(
            py: Python<'py>,
            centers_a: Array<'py, f64>,
            axes_a: Array<'py, f64>,
            half_a: Array<'py, f64>,
            centers_b: Array<'py, f64>,
            axes_b: Array<'py, f64>,
            half_b: Array<'py, f64>,
        ) -> PyResult<Bound<'py, PyArray1<f64>>> {
            let a = boxes_of("_a", &centers_a, &axes_a, &half_a).map_err(value_error)?;
            let b = boxes_of("_b", &centers_b, &axes_b, &half_b).map_err(value_error)?;
            if a.len() != b.len() {
                let problem = format!("{} boxes, but centers_a has {}", b.len(), a.len());
                return Err(value_error(GeometryError::new("centers_b", problem)));
            }
            let values = map_in_batches(py, a.iter().zip(&b), |(a, b)| $measure(a, b))?;
            Ok(PyArray1::from_vec(py, values))
        }
    };
}

measure_of_box_pairs!(box_intersection_volume, iou::intersection_volume);
measure_of_box_pairs!(box_iou, iou::box_iou);
