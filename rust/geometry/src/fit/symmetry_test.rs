//! Test if a reflection or a rotation maps a part to itself.

use std::f64::consts::TAU;

use nalgebra::{Point3, Rotation3, Unit, Vector3};

use crate::mesh::part_surface::PartSurface;
use crate::points::surface_sample::SurfaceSample;
use crate::points::surface_sampling::sample_surface;

/// Share of the mapped samples that must lie on the surface.
const QUANTILE: f64 = 0.9;

/// Test angles for any rotation, in radians. None is a fraction of a turn with a small denominator.
const REVOLUTION_ANGLES: [f64; 4] = [0.0901699 * TAU, 0.2360680 * TAU, 0.3819660 * TAU, 0.4721360 * TAU];

/// Options of a symmetry test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TestOptions {
    /// Number of surface samples that are mapped.
    pub samples: usize,
    /// Largest error of a symmetry, over the part's diagonal.
    pub tolerance: f64,
    /// Seed of the samples.
    pub seed: u64,
}

/// Samples of a surface, and tolerances for their images.
pub struct SymmetryTest<'a> {
    surface: &'a PartSurface<'a>,
    samples: Vec<SurfaceSample>,
    diagonal: f64,
    /// Largest distance of mapped samples from the surface.
    reach: f64,
    /// Number of samples that may be farther away.
    outliers: usize,
}

impl<'a> SymmetryTest<'a> {
    /// Draws the samples.
    pub fn new(surface: &'a PartSurface<'a>, options: &TestOptions) -> Self {
        let samples = sample_surface(surface.mesh(), options.samples, options.seed);
        let diagonal = surface.mesh().diagonal();
        let outliers = options.samples - (QUANTILE * options.samples as f64).ceil() as usize;
        Self { surface, samples, diagonal, reach: options.tolerance * diagonal, outliers }
    }

    /// Largest distance of mapped samples from the surface.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// True if the reflection in the plane through `point` with unit `normal` maps the part to itself.
    pub fn has_mirror(&self, point: Point3<f64>, normal: Vector3<f64>) -> bool {
        self.holds(mirror(point, normal))
    }

    /// Error of that reflection; `None` if it does not map the part to itself.
    pub fn mirror_error(&self, point: Point3<f64>, normal: Vector3<f64>) -> Option<f64> {
        self.error(mirror(point, normal))
    }

    /// Error of a rotation about the axis through `point` along the unit vector `axis`, by `angle` in radians.
    ///
    /// Returns `None` if it does not map the part to itself.
    pub fn turn_error(&self, point: Point3<f64>, axis: Vector3<f64>, angle: f64) -> Option<f64> {
        let turn = Rotation3::from_axis_angle(&Unit::new_unchecked(axis), angle);
        self.error(|p| point + turn * (p - point))
    }

    /// Largest error of rotations by several angles about an axis; `None` if one of them does not map the part to itself.
    pub fn revolution_error(&self, point: Point3<f64>, axis: Vector3<f64>) -> Option<f64> {
        REVOLUTION_ANGLES
            .iter()
            .try_fold(0.0, |worst: f64, &angle| Some(worst.max(self.turn_error(point, axis, angle)?)))
    }

    fn holds(&self, map: impl Fn(Point3<f64>) -> Point3<f64>) -> bool {
        let misses = self.samples.iter().filter(|sample| !self.surface.is_near(&map(sample.point), self.reach));
        misses.take(self.outliers + 1).count() <= self.outliers
    }

    /// 90th percentile of the distances of mapped samples over the diagonal; `None` unless it is below the tolerance.
    fn error(&self, map: impl Fn(Point3<f64>) -> Point3<f64>) -> Option<f64> {
        if !self.holds(&map) {
            return None;
        }
        let distance = |sample: &SurfaceSample| self.surface.distance_within(&map(sample.point), self.reach);
        let mut distances: Vec<f64> = self.samples.iter().filter_map(distance).collect();
        distances.sort_by(f64::total_cmp);
        let rank = self.samples.len() - self.outliers - 1;
        Some(distances.get(rank)? / self.diagonal)
    }
}

fn mirror(point: Point3<f64>, normal: Vector3<f64>) -> impl Fn(Point3<f64>) -> Point3<f64> {
    move |p| p - normal * (2.0 * normal.dot(&(p - point)))
}
