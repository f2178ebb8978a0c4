//! Whether a motion or a mirror maps a part onto itself.

use nalgebra::{Point3, Rotation3, Unit, Vector3};

use crate::sampling::{SurfaceSample, sample_surface};
use crate::surface::Surface;

/// Share of the mapped samples that must lie on the surface.
const QUANTILE: f64 = 0.9;

/// How closely to look, and from where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TestOptions {
    /// Surface samples that are mapped.
    pub samples: usize,
    /// Error, over the part's diagonal, that a symmetry has to stay below.
    pub tolerance: f64,
    /// Seed of the samples.
    pub seed: u64,
}

/// Samples of a surface and the distances to it.
pub struct SymmetryTest<'a> {
    surface: &'a Surface<'a>,
    samples: Vec<SurfaceSample>,
    diagonal: f64,
    /// How far mapped samples may be from the surface.
    reach: f64,
    /// How many of them may be farther.
    outliers: usize,
}

impl<'a> SymmetryTest<'a> {
    /// Draws the samples.
    pub fn new(surface: &'a Surface<'a>, options: &TestOptions) -> Self {
        let samples = sample_surface(surface.mesh(), options.samples, options.seed);
        let diagonal = surface.mesh().diagonal();
        let outliers = options.samples - (QUANTILE * options.samples as f64).ceil() as usize;
        Self { surface, samples, diagonal, reach: options.tolerance * diagonal, outliers }
    }

    /// How far mapped samples may be from the surface.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Whether mirroring at the plane through `point` with unit `normal` maps the part onto itself.
    pub fn has_mirror(&self, point: Point3<f64>, normal: Vector3<f64>) -> bool {
        self.holds(mirror(point, normal))
    }

    /// The error of that mirror, if it is one.
    pub fn mirror_error(&self, point: Point3<f64>, normal: Vector3<f64>) -> Option<f64> {
        self.error(mirror(point, normal))
    }

    /// The error of a turn by `angle` about the axis through `point` along the unit vector `axis`, if it maps the part onto itself.
    pub fn turn_error(&self, point: Point3<f64>, axis: Vector3<f64>, angle: f64) -> Option<f64> {
        let turn = Rotation3::from_axis_angle(&Unit::new_unchecked(axis), angle);
        self.error(|p| point + turn * (p - point))
    }

    fn holds(&self, map: impl Fn(Point3<f64>) -> Point3<f64>) -> bool {
        let misses = self.samples.iter().filter(|sample| !self.surface.is_near(&map(sample.point), self.reach));
        misses.take(self.outliers + 1).count() <= self.outliers
    }

    /// The 90th percentile of the distances of the mapped samples, over the diagonal, if it is below the tolerance.
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
