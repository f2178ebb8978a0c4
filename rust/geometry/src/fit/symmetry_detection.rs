//! Mirror planes and rotation axes of a part.

use std::cmp::Ordering;
use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};

use crate::fit::axis_of_revolution::axis_of_revolution;
use crate::fit::minimum_volume_box::BoxFitter;
use crate::fit::principal_axes::principal_axes;
use crate::fit::symmetric_box::most_symmetric_box;
use crate::fit::symmetry_test::{SymmetryTest, TestOptions};
use crate::mesh::part_surface::PartSurface;
use crate::points::surface_sampling::sample_surface;

/// A reflection or a rotation that maps a part to itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Symmetry {
    /// Reflection or rotation.
    pub kind: SymmetryKind,
    /// A point on the plane or axis.
    pub point: Point3<f64>,
    /// Unit normal of the plane, or unit direction of the axis.
    pub direction: Vector3<f64>,
    /// 90th percentile of the distances of mapped surface samples to the surface, over the part's diagonal.
    pub error: f64,
}

/// Kind of a [`Symmetry`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SymmetryKind {
    /// Reflection in a plane.
    Reflection,
    /// Rotation by a full turn divided by this order.
    Rotation(u32),
    /// Rotation by any angle.
    Revolution,
}

/// Number of samples from which candidate axes are fitted. They cost less than tested samples.
const FITTED_SAMPLES: usize = 512;

/// Orders of rotation, the finest first. Only the finest order of an axis is reported.
const ORDERS: [u32; 6] = [8, 6, 5, 4, 3, 2];

/// Sine of the largest angle between directions that count as one candidate.
const SAME_CANDIDATE: f64 = 1e-3;

/// Sine of the largest angle between directions of which only the best symmetry is reported.
const SAME_DIRECTION: f64 = 0.1;

/// Error of a nearly exact mirror plane, as a share of the tolerance. Candidates near its normal are skipped.
const NEARLY_EXACT: f64 = 0.01;

/// Largest distance between points that count as one candidate, as a share of the tolerance.
const SAME_POINT: f64 = 0.2;

/// Mirror planes and rotation axes of a part, mirror planes first.
///
/// Candidates are the axis of revolution of the surface, the axes of the symmetric box and of the smallest box, and the
/// principal axes. Each is tried at its own position, through the centroid of the surface, and through the center of
/// the symmetric box.
///
/// Reported symmetries have an error below the tolerance. Each axis has its finest order only. Of nearly parallel
/// symmetries only the best is reported.
pub fn find_symmetries(surface: &PartSurface<'_>, options: &TestOptions) -> Vec<Symmetry> {
    let fitter = BoxFitter::new(surface.mesh().vertices());
    let minimal = fitter.minimum_volume();
    if minimal.half_extents.x == 0.0 {
        return Vec::new();
    }
    let test = SymmetryTest::new(surface, options);
    let (symmetric, _) = most_symmetric_box(&fitter, minimal, &test);
    let fitted = sample_surface(surface.mesh(), FITTED_SAMPLES, options.seed);
    let (centroid, principal) = principal_axes(surface.mesh(), &fitted);
    let mut lines: Vec<(Point3<f64>, Vector3<f64>)> = axis_of_revolution(&fitted).into_iter().collect();
    for candidate in [symmetric, minimal] {
        lines.extend(candidate.axes.iter().map(|axis| (candidate.center, *axis)));
    }
    lines.extend(principal.iter().map(|axis| (centroid, *axis)));
    let (mut tried, mut mirrors, mut turns) = (Vec::new(), Vec::new(), Vec::new());
    for (own_point, direction) in lines {
        let is_known = mirrors.iter().any(|mirror: &Symmetry| {
            mirror.error < NEARLY_EXACT * options.tolerance && !is_new(&[mirror.direction], &direction, SAME_DIRECTION)
        });
        if is_known || !is_new(&tried, &direction, SAME_CANDIDATE) {
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

/// Drops symmetries that are nearly parallel to a better one of the same kind. Even a degree off, they are within the
/// tolerance.
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

/// Sort key: 0 for any angle, and larger for lower orders.
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
    if let Some(error) = test.revolution_error(point, direction) {
        return Some(Symmetry { kind: SymmetryKind::Revolution, point, direction, error });
    }
    ORDERS.into_iter().find_map(|order| {
        let error = test.turn_error(point, direction, TAU / order as f64)?;
        Some(Symmetry { kind: SymmetryKind::Rotation(order), point, direction, error })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::symmetric_box::symmetric_box;
    use crate::mesh::bvh::Bvh;
    use crate::test_shapes::{block, isometry, mapped, prism};
    use proptest::prelude::*;

    const OPTIONS: TestOptions = TestOptions { samples: 200, tolerance: 0.005, seed: 1 };

    /// Half extents with ratios of at least 1.2, so that a block has only half turns as rotations.
    fn unequal_extents() -> impl Strategy<Value = [f64; 3]> {
        (0.1..1.0f64, 1.2..2.0f64, 1.2..2.0f64).prop_map(|(x, y, z)| [x, x * y, x * y * z])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// A block has three mirror planes and three half turns in any pose.
        #[test]
        fn a_placed_block_has_the_symmetries_of_a_block(half in unequal_extents(), place in isometry()) {
            let mesh = mapped(&block(half.map(|h| -h), half), |p| place * p);
            let tree = Bvh::new(&mesh);
            let found = find_symmetries(&PartSurface::new(&[&mesh], vec![&tree]), &OPTIONS);
            for kind in [SymmetryKind::Reflection, SymmetryKind::Rotation(2)] {
                let along: Vec<_> = found.iter().filter(|symmetry| symmetry.kind == kind).collect();
                prop_assert_eq!(along.len(), 3, "{:?}", found);
                for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                    let nearest = along.iter().map(|s| s.direction.cross(&(place * axis)).norm()).fold(f64::MAX, f64::min);
                    prop_assert!(nearest < SAME_CANDIDATE, "{nearest}");
                }
            }
            prop_assert_eq!(found.len(), 6);
        }

        #[test]
        fn the_symmetric_box_of_a_placed_block_is_the_block(half in unequal_extents(), place in isometry()) {
            let mesh = mapped(&block(half.map(|h| -h), half), |p| place * p);
            let tree = Bvh::new(&mesh);
            let (found, planes) = symmetric_box(&PartSurface::new(&[&mesh], vec![&tree]), &OPTIONS);
            prop_assert_eq!(planes, 3);
            let mut sides: Vec<f64> = found.half_extents.iter().copied().collect();
            sides.sort_by(f64::total_cmp);
            for (side, wanted) in sides.iter().zip(half) {
                prop_assert!((side - wanted).abs() < 1e-9);
            }
            prop_assert!((found.center - place * Point3::origin()).norm() < 1e-9);
        }
    }

    fn finest_turn_about_z(sides: u32) -> Option<SymmetryKind> {
        let mesh = prism(sides);
        let tree = Bvh::new(&mesh);
        let surface = PartSurface::new(&[&mesh], vec![&tree]);
        let found = find_symmetries(&surface, &TestOptions { samples: 200, tolerance: 0.005, seed: 1 });
        let about_z = |s: &&Symmetry| s.kind != SymmetryKind::Reflection && s.direction.z.abs() > 0.999;
        found.iter().find(about_z).map(|symmetry| symmetry.kind)
    }

    #[test]
    fn prisms_have_the_rotation_order_of_their_sides() {
        for sides in 3..=6 {
            assert_eq!(finest_turn_about_z(sides), Some(SymmetryKind::Rotation(sides)), "{sides} sides");
        }
        assert_eq!(finest_turn_about_z(60), Some(SymmetryKind::Revolution));
    }
}
