//! Symmetries of a part, and the box that shows them.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Point3, Rotation3, SymmetricEigen, Unit, Vector3};

use crate::Mesh;
use crate::box_search::BoxSearch;
use crate::hull::Hull;
use crate::obb::{FLATNESS, OrientedBox, UnitFrame, degenerate_axes, minimum_volume_box};
use crate::parry::Surface;
use crate::revolution::axis_of_revolution;
use crate::sampling::{SurfaceSample, sample_surface};

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

/// Share of the mapped samples that must lie on the surface.
const QUANTILE: f64 = 0.9;

/// Turns tried, the finest first: of an axis only the finest is reported.
const ORDERS: [u32; 7] = [12, 8, 6, 5, 4, 3, 2];

/// Angles that are no fraction of a turn with a small denominator.
const REVOLUTION_ANGLES: [f64; 4] = [0.0901699 * TAU, 0.2360680 * TAU, 0.3819660 * TAU, 0.4721360 * TAU];

/// Candidate directions nearer than this (sine of the angle) are one.
const SAME_DIRECTION: f64 = 0.01;

/// At most this many candidate boxes of a hull are looked at.
const CANDIDATE_BOXES: usize = 48;

/// Samples of a surface and the distances to it: what it takes to judge a symmetry.
struct Judge {
    samples: Vec<SurfaceSample>,
    surface: Surface,
    diagonal: f64,
}

impl Judge {
    fn new(mesh: &Mesh, samples: usize, seed: u64) -> Self {
        let samples = sample_surface(mesh, samples, seed);
        let surface = Surface::new((0..mesh.faces().len()).map(|face| mesh.triangle(face)));
        Self { samples, surface, diagonal: mesh.diagonal() }
    }

    /// Error of the mapping, over the diagonal, or nothing if it is not below `tolerance`.
    fn error(&self, tolerance: f64, map: impl Fn(Point3<f64>) -> Point3<f64>) -> Option<f64> {
        let allowed_misses = self.samples.len() - (QUANTILE * self.samples.len() as f64).ceil() as usize;
        let reach = tolerance * self.diagonal;
        let mut misses = 0;
        let mut distances = Vec::with_capacity(self.samples.len());
        for sample in &self.samples {
            match self.surface.distance_within(map(sample.point), reach) {
                Some(distance) => distances.push(distance),
                None => misses += 1,
            }
            if misses > allowed_misses {
                return None;
            }
        }
        distances.sort_by(f64::total_cmp);
        let rank = self.samples.len() - allowed_misses - 1;
        Some(distances.get(rank)? / self.diagonal)
    }

    fn mirror_error(&self, tolerance: f64, point: Point3<f64>, normal: Vector3<f64>) -> Option<f64> {
        self.error(tolerance, |p| p - normal * (2.0 * normal.dot(&(p - point))))
    }

    fn turn_error(&self, tolerance: f64, point: Point3<f64>, axis: Vector3<f64>, angle: f64) -> Option<f64> {
        let turn = Rotation3::from_axis_angle(&Unit::new_unchecked(axis), angle);
        self.error(tolerance, |p| point + turn * (p - point))
    }

    fn symmetric_planes(&self, tolerance: f64, candidate: &OrientedBox) -> u8 {
        let is_symmetric = |normal: &&Vector3<f64>| self.mirror_error(tolerance, candidate.center, **normal).is_some();
        candidate.axes.iter().filter(is_symmetric).count() as u8
    }
}

/// The box of Fish et al. 2014: that of least volume among those whose three middle planes are symmetry planes of the part, or else
/// two of them, or else one, or else of all. Returned with the number of symmetric planes.
///
/// Candidates are the box of minimum volume and the best boxes along the normals of the hull's facets. A plane counts as symmetric if
/// the 90th percentile of the squared distances of `samples` mirrored samples to the surface, over the squared diagonal, is below
/// `tolerance`.
pub fn symmetric_box(mesh: &Mesh, samples: usize, tolerance: f64, seed: u64) -> (OrientedBox, u8) {
    let minimal = minimum_volume_box(mesh.vertices());
    if mesh.diagonal() == 0.0 {
        return (minimal, 3);
    }
    let judge = Judge::new(mesh, samples, seed);
    let tolerance = tolerance.sqrt();
    let mut best = (minimal, judge.symmetric_planes(tolerance, &minimal));
    for candidate in facet_boxes(mesh.vertices()) {
        if best.1 == 3 {
            break;
        }
        let planes = judge.symmetric_planes(tolerance, &candidate);
        if planes > best.1 {
            best = (candidate, planes);
        }
    }
    best
}

/// The best box along each facet's normal, by ascending volume.
fn facet_boxes(points: &[Point3<f64>]) -> Vec<OrientedBox> {
    let frame = UnitFrame::around(points);
    match Hull::of(&frame.points, FLATNESS) {
        Hull::Solid(hull) => {
            let boxes = BoxSearch::new(&hull).facet_boxes(CANDIDATE_BOXES);
            boxes.into_iter().map(|candidate| frame.ordered_box(candidate.axes)).collect()
        }
        degenerate => vec![frame.ordered_box(degenerate_axes(&frame.points, &degenerate))],
    }
}

/// Mirror planes and axes of rotation of a part, mirrors first.
///
/// Candidates are the axes of the boxes of minimum volume and of [`symmetric_box`], the principal axes of the surface, and its
/// axis of revolution, each through the centroid of the surface and through the middle of the box. Reported are those with an
/// error below `tolerance`; of an axis, the finest order.
pub fn find_symmetries(mesh: &Mesh, samples: usize, tolerance: f64, seed: u64) -> Vec<Symmetry> {
    if mesh.diagonal() == 0.0 {
        return Vec::new();
    }
    let judge = Judge::new(mesh, samples, seed);
    let minimal = minimum_volume_box(mesh.vertices());
    let (symmetric, _) = symmetric_box(mesh, samples, tolerance * tolerance, seed);
    let (centroid, principal) = principal_axes(&judge.samples);
    let mut lines: Vec<(Point3<f64>, Vector3<f64>)> = Vec::new();
    lines.extend(axis_of_revolution(&judge.samples));
    for candidate in [symmetric, minimal] {
        lines.extend(candidate.axes.iter().map(|axis| (candidate.center, *axis)));
    }
    lines.extend(principal.iter().map(|axis| (centroid, *axis)));
    let middles = [centroid, symmetric.center];
    let mut directions: Vec<Vector3<f64>> = Vec::new();
    let (mut mirrors, mut turns) = (Vec::new(), Vec::new());
    for (own_point, direction) in lines {
        if directions.iter().any(|known| known.cross(&direction).norm() < SAME_DIRECTION) {
            continue;
        }
        directions.push(direction);
        let points = [own_point, middles[0], middles[1]];
        mirrors.extend(best_of(points, |point| mirror_at(&judge, tolerance, point, direction)));
        turns.extend(best_of(points, |point| turn_about(&judge, tolerance, point, direction)));
    }
    mirrors.extend(turns);
    mirrors
}

fn best_of(points: [Point3<f64>; 3], find: impl Fn(Point3<f64>) -> Option<Symmetry>) -> Option<Symmetry> {
    points.into_iter().filter_map(find).min_by(|a, b| rank(a).cmp(&rank(b)).then(a.error.total_cmp(&b.error)))
}

/// Revolutions before rotations, and those by descending order.
fn rank(symmetry: &Symmetry) -> u32 {
    match symmetry.kind {
        SymmetryKind::Reflection | SymmetryKind::Revolution => 0,
        SymmetryKind::Rotation(order) => u32::MAX - order,
    }
}

fn mirror_at(judge: &Judge, tolerance: f64, point: Point3<f64>, direction: Vector3<f64>) -> Option<Symmetry> {
    let error = judge.mirror_error(tolerance, point, direction)?;
    Some(Symmetry { kind: SymmetryKind::Reflection, point, direction, error })
}

fn turn_about(judge: &Judge, tolerance: f64, point: Point3<f64>, direction: Vector3<f64>) -> Option<Symmetry> {
    let error_at = |angle: f64| judge.turn_error(tolerance, point, direction, angle);
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
