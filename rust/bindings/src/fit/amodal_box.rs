//! `adjust_amodal_boxes`: predicted boxes adjusted to scans.

use std::ops::Range;

use kinmo_geometry::fit::amodal_box::{ScanView, adjust_amodal_box};
use kinmo_geometry::fit::oriented_box::OrientedBox;
use kinmo_geometry::{GeometryError, Result};
use nalgebra::Point3;
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, check_shape, points_of};
use crate::arguments::boxes::{Boxes, boxes_of, to_arrays};
use crate::arguments::groups::ranges_of;
use crate::batches::map_in_batches;
use crate::errors::value_error;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(adjust_amodal_boxes, module)?)
}

#[pyfunction]
#[pyo3(signature = (points, offsets, owners, cameras, centers, axes, half, *, frames))]
#[allow(clippy::too_many_arguments)]
fn adjust_amodal_boxes<'py>(
    py: Python<'py>,
    points: Array<'py, f64>,
    offsets: Array<'py, i64>,
    owners: Array<'py, i64>,
    cameras: Array<'py, f64>,
    centers: Array<'py, f64>,
    axes: Array<'py, f64>,
    half: Array<'py, f64>,
    frames: Array<'py, i64>,
) -> PyResult<Boxes<'py>> {
    let predicted = boxes_of("", &centers, &axes, &half).map_err(value_error)?;
    let frames = ranges_of("frames", &frames, predicted.len()).map_err(value_error)?;
    let scans = scans_of(&points, &offsets, &owners, &cameras, &frames).map_err(value_error)?;
    let adjusted = map_in_batches(py, scans.into_iter().zip(frames), |(scan, frame)| scan.adjust(&predicted[frame]))?;
    to_arrays(py, &adjusted.into_iter().flatten().collect::<Vec<_>>())
}

/// One scan: its points, the box index of each point (`None` for background), and the camera position.
struct Scan {
    points: Vec<Point3<f64>>,
    owners: Vec<Option<usize>>,
    camera: Point3<f64>,
}

impl Scan {
    fn adjust(&self, predicted: &[OrientedBox]) -> Vec<OrientedBox> {
        let view = ScanView::new(&self.points, self.camera);
        let own = |part: usize| -> Vec<Point3<f64>> {
            let pairs = self.points.iter().zip(&self.owners);
            pairs.filter(|(_, owner)| **owner == Some(part)).map(|(point, _)| *point).collect()
        };
        predicted.iter().enumerate().map(|(part, predicted)| adjust_amodal_box(&view, &own(part), predicted)).collect()
    }
}

fn scans_of(
    points: &Array<'_, f64>,
    offsets: &Array<'_, i64>,
    owners: &Array<'_, i64>,
    cameras: &Array<'_, f64>,
    frames: &[Range<usize>],
) -> Result<Vec<Scan>> {
    let count = points.view().shape().first().copied().unwrap_or(0);
    let points = points_of("points", points.view(), count)?;
    let cameras = points_of("cameras", cameras.view(), frames.len())?;
    check_shape("owners", &owners.view(), &[count])?;
    let owners: Vec<Option<usize>> = owners.view().iter().map(|owner| usize::try_from(*owner).ok()).collect();
    let ranges = ranges_of("offsets", offsets, count)?;
    if ranges.len() != frames.len() {
        let problem = format!("{} scans, but frames has {}", ranges.len(), frames.len());
        return Err(GeometryError::new("offsets", problem));
    }
    let scan = |((range, camera), frame): ((Range<usize>, Point3<f64>), &Range<usize>)| {
        let own = &owners[range.clone()];
        if let Some(row) = own.iter().position(|owner| owner.is_some_and(|owner| owner >= frame.len())) {
            let problem = format!("row {} is no box of its scan, which has {}", range.start + row, frame.len());
            return Err(GeometryError::new("owners", problem));
        }
        Ok(Scan { points: points[range].to_vec(), owners: own.to_vec(), camera })
    };
    ranges.into_iter().zip(cameras).zip(frames).map(scan).collect()
}
