//! Symmetries of a part.

use std::cmp::Ordering;
use std::f64::consts::TAU;

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use crate::Mesh;
use crate::obb::BoxFitter;
use crate::revolution::axis_of_revolution;
use crate::sampling::{SurfaceSample, sample_surface};
use crate::surface::Surface;
use crate::symmetric_box::most_symmetric_box;
use crate::symmetry_test::{SymmetryTest, TestOptions};

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

/// Candidates along about the normal of a mirror with an error below this share of the tolerance are not tried.
const SETTLED: f64 = 0.01;

/// Candidate points nearer than this share of the tolerance are one.
const SAME_POINT: f64 = 0.2;

/// Mirror planes and axes of rotation of a part, mirrors first.
///
/// Candidates are the axis of revolution of the surface, the axes of the boxes of minimum volume and of Fish's, and the principal axes,
/// each where it was found, through the centroid of the surface and through the middle of the box. Reported are those with an
/// error below the tolerance; of an axis, the finest order; of nearly parallel ones, the best.
pub fn find_symmetries(surface: &Surface<'_>, options: &TestOptions) -> Vec<Symmetry> {
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
        let is_settled = mirrors.iter().any(|mirror: &Symmetry| {
            mirror.error < SETTLED * options.tolerance && !is_new(&[mirror.direction], &direction, SAME_DIRECTION)
        });
        if is_settled || !is_new(&tried, &direction, SAME_CANDIDATE) {
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
    if let Some(error) = revolution_error(test, point, direction) {
        return Some(Symmetry { kind: SymmetryKind::Revolution, point, direction, error });
    }
    ORDERS.into_iter().find_map(|order| {
        let error = test.turn_error(point, direction, TAU / order as f64)?;
        Some(Symmetry { kind: SymmetryKind::Rotation(order), point, direction, error })
    })
}

/// The worst error of turns by any angle, if all map the part onto itself.
pub(crate) fn revolution_error(test: &SymmetryTest<'_>, point: Point3<f64>, direction: Vector3<f64>) -> Option<f64> {
    REVOLUTION_ANGLES
        .iter()
        .try_fold(0.0, |worst: f64, &angle| Some(worst.max(test.turn_error(point, direction, angle)?)))
}

/// Centroid and principal axes of the surface; of a part without area, of its samples.
pub(crate) fn principal_axes(mesh: &Mesh, samples: &[SurfaceSample]) -> (Point3<f64>, [Vector3<f64>; 3]) {
    // Integrals of quadratic functions over a triangle are sums over the middles of its sides.
    let middles = (0..mesh.faces().len()).flat_map(|face| {
        let [a, b, c] = mesh.triangle(face);
        let weight = mesh.scaled_normal(face).norm();
        [(a, b), (b, c), (c, a)].map(|(p, q)| (weight, p + (q - p) / 2.0))
    });
    let mut points: Vec<(f64, Point3<f64>)> = middles.collect();
    if points.iter().all(|(weight, _)| *weight == 0.0) {
        points = samples.iter().map(|sample| (1.0, sample.point)).collect();
    }
    let total: f64 = points.iter().map(|(weight, _)| weight).sum();
    let first = points[0].1;
    let centroid = first + points.iter().map(|(weight, p)| (p - first) * (weight / total)).sum::<Vector3<f64>>();
    let scatter: Matrix3<f64> = points
        .iter()
        .map(|(weight, p)| {
            let offset = p - centroid;
            offset * offset.transpose() * (weight / total)
        })
        .sum();
    let vectors = SymmetricEigen::new(scatter).eigenvectors;
    (centroid, [0, 1, 2].map(|i| vectors.column(i).into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Bvh;
    use crate::soup::{block, isometry, mapped, prism};
    use crate::symmetric_box::symmetric_box;
    use proptest::prelude::*;

    const OPTIONS: TestOptions = TestOptions { samples: 200, tolerance: 0.005, seed: 1 };

    /// Half extents whose least ratio is 1.2, so that a block has no turns but half ones.
    fn unequal_extents() -> impl Strategy<Value = [f64; 3]> {
        (0.1..1.0f64, 1.2..2.0f64, 1.2..2.0f64).prop_map(|(x, y, z)| [x, x * y, x * y * z])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Three mirrors and three half turns, wherever the block is and however it lies.
        #[test]
        fn a_placed_block_has_the_symmetries_of_a_block(half in unequal_extents(), place in isometry()) {
            let mesh = mapped(&block(half.map(|h| -h), half), |p| place * p);
            let tree = Bvh::new(&mesh);
            let found = find_symmetries(&Surface::new(&[&mesh], vec![&tree]), &OPTIONS);
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
            let (found, planes) = symmetric_box(&Surface::new(&[&mesh], vec![&tree]), &OPTIONS);
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
        let surface = Surface::new(&[&mesh], vec![&tree]);
        let found = find_symmetries(&surface, &TestOptions { samples: 200, tolerance: 0.005, seed: 1 });
        let about_z = |s: &&Symmetry| s.kind != SymmetryKind::Reflection && s.direction.z.abs() > 0.999;
        found.iter().find(about_z).map(|symmetry| symmetry.kind)
    }

    #[test]
    fn prisms_turn_by_their_number_of_sides() {
        for sides in 3..=6 {
            assert_eq!(finest_turn_about_z(sides), Some(SymmetryKind::Rotation(sides)), "{sides} sides");
        }
        assert_eq!(finest_turn_about_z(60), Some(SymmetryKind::Revolution));
    }
}
