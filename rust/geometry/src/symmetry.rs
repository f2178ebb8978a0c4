//! Symmetries of a part.

use std::cmp::Ordering;
use std::f64::consts::TAU;

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use crate::obb::BoxFitter;
use crate::revolution::axis_of_revolution;
use crate::sampling::{SurfaceSample, sample_surface};
use crate::surface::Surface;
use crate::symmetric_box::most_symmetric_box;
use crate::symmetry_test::SymmetryTest;

/// A mirror or a turn that maps a part onto itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Symmetry {
    /// Mirror or turn.
    pub kind: SymmetryKind,
    /// A point of the plane or axis.
    pub point: Point3<f64>,
    /// Unit normal of the plane, or unit direction of the axis.
    pub direction: Vector3<f64>,
    /// 90th percentile of the distances of mapped surface samples to the surface, over the part's diagonal.
    pub error: f64,
}

/// The kinds of [`Symmetry`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SymmetryKind {
    /// Mirrored in a plane.
    Reflection,
    /// Turned by a full turn over this many steps.
    Rotation(u32),
    /// Turned by any angle.
    Revolution,
}

/// Samples from which candidate axes are fitted: they cost less than those that are tested.
const FITTED_SAMPLES: usize = 512;

/// Turns tried, the finest first: of an axis only the finest is reported.
const ORDERS: [u32; 6] = [8, 6, 5, 4, 3, 2];

/// Angles that are no fraction of a turn with a small denominator.
const REVOLUTION_ANGLES: [f64; 4] = [0.0901699 * TAU, 0.2360680 * TAU, 0.3819660 * TAU, 0.4721360 * TAU];

/// Candidate directions nearer than this (sine of the angle) are one.
const SAME_CANDIDATE: f64 = 1e-3;

/// Of symmetries along directions nearer than this (sine of the angle) the best is reported.
const SAME_DIRECTION: f64 = 0.1;

/// Candidate points nearer than this share of the tolerance are one.
const SAME_POINT: f64 = 0.2;

/// Mirror planes and axes of rotation of a part, mirrors first.
///
/// Candidates are the axis of revolution of the surface, the axes of the boxes of minimum volume and of Fish's, and the principal axes,
/// each where it was found, through the centroid of the surface and through the middle of the box. Reported are those with an
/// error below `tolerance`; of an axis, the finest order; of nearly parallel ones, the best.
pub fn find_symmetries(surface: &Surface<'_>, samples: usize, tolerance: f64, seed: u64) -> Vec<Symmetry> {
    let fitter = BoxFitter::new(surface.mesh().vertices());
    let minimal = fitter.minimum_volume();
    if minimal.half_extents.x == 0.0 {
        return Vec::new();
    }
    let test = SymmetryTest::new(surface, samples, tolerance, seed);
    let (symmetric, _) = most_symmetric_box(&fitter, minimal, &test);
    let fitted = sample_surface(surface.mesh(), FITTED_SAMPLES, seed);
    let (centroid, principal) = principal_axes(&fitted);
    let mut lines: Vec<(Point3<f64>, Vector3<f64>)> = axis_of_revolution(&fitted).into_iter().collect();
    for candidate in [symmetric, minimal] {
        lines.extend(candidate.axes.iter().map(|axis| (candidate.center, *axis)));
    }
    lines.extend(principal.iter().map(|axis| (centroid, *axis)));
    let (mut tried, mut mirrors, mut turns) = (Vec::new(), Vec::new(), Vec::new());
    for (own_point, direction) in lines {
        if !is_new(&tried, &direction, SAME_CANDIDATE) {
            continue;
        }
        tried.push(direction);
        let points = distinct_points([own_point, symmetric.center, centroid], SAME_POINT * test.reach());
        mirrors.extend(best_of(&points, |point| mirror_at(&test, point, direction)));
        turns.extend(best_of(&points, |point| turn_about(&test, point, direction)));
    }
    let mut found = best_of_neighbours(mirrors);
    found.extend(best_of_neighbours(turns));
    found
}

/// Drops what is nearly along a better symmetry of the same kind: candidates a degree off hold within the tolerance, too.
fn best_of_neighbours(mut symmetries: Vec<Symmetry>) -> Vec<Symmetry> {
    symmetries.sort_by(better_first);
    let mut kept: Vec<Symmetry> = Vec::new();
    for symmetry in symmetries {
        let directions: Vec<_> = kept.iter().map(|better| better.direction).collect();
        if is_new(&directions, &symmetry.direction, SAME_DIRECTION) {
            kept.push(symmetry);
        }
    }
    kept
}

fn is_new(known: &[Vector3<f64>], direction: &Vector3<f64>, sine: f64) -> bool {
    known.iter().all(|other| other.cross(direction).norm() > sine)
}

fn distinct_points(points: [Point3<f64>; 3], distance: f64) -> Vec<Point3<f64>> {
    let mut kept: Vec<Point3<f64>> = Vec::with_capacity(points.len());
    for point in points {
        if kept.iter().all(|known| (known - point).norm() > distance) {
            kept.push(point);
        }
    }
    kept
}

fn best_of(points: &[Point3<f64>], find: impl Fn(Point3<f64>) -> Option<Symmetry>) -> Option<Symmetry> {
    let found = points.iter().filter_map(|point| find(*point));
    found.min_by(better_first)
}

fn better_first(a: &Symmetry, b: &Symmetry) -> Ordering {
    coarseness(a).cmp(&coarseness(b)).then(a.error.total_cmp(&b.error))
}

/// Least for what holds at any angle, then by descending order.
fn coarseness(symmetry: &Symmetry) -> u32 {
    match symmetry.kind {
        SymmetryKind::Reflection | SymmetryKind::Revolution => 0,
        SymmetryKind::Rotation(order) => u32::MAX - order,
    }
}

fn mirror_at(test: &SymmetryTest<'_>, point: Point3<f64>, direction: Vector3<f64>) -> Option<Symmetry> {
    let error = test.mirror_error(point, direction)?;
    Some(Symmetry { kind: SymmetryKind::Reflection, point, direction, error })
}

fn turn_about(test: &SymmetryTest<'_>, point: Point3<f64>, direction: Vector3<f64>) -> Option<Symmetry> {
    let error_at = |angle: f64| test.turn_error(point, direction, angle);
    let any_angle = REVOLUTION_ANGLES.iter().try_fold(0.0, |worst: f64, &angle| Some(worst.max(error_at(angle)?)));
    if let Some(error) = any_angle {
        return Some(Symmetry { kind: SymmetryKind::Revolution, point, direction, error });
    }
    ORDERS.into_iter().find_map(|order| {
        let error = error_at(TAU / order as f64)?;
        Some(Symmetry { kind: SymmetryKind::Rotation(order), point, direction, error })
    })
}

/// Centroid and principal axes of the samples.
fn principal_axes(samples: &[SurfaceSample]) -> (Point3<f64>, [Vector3<f64>; 3]) {
    let first = samples[0].point;
    let mean = samples.iter().map(|s| s.point - first).sum::<Vector3<f64>>() / samples.len() as f64;
    let centroid = first + mean;
    let offsets = samples.iter().map(|s| s.point - centroid);
    let scatter: Matrix3<f64> = offsets.map(|offset| offset * offset.transpose()).sum();
    let vectors = SymmetricEigen::new(scatter).eigenvectors;
    (centroid, [0, 1, 2].map(|i| vectors.column(i).into_owned()))
}
