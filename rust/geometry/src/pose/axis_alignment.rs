//! Rotations of axis-aligned parts, corrected by surface normals.
//!
//! A part is axis-aligned if most of its surface is perpendicular to its axes, as that of a door or a drawer.

use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};

use crate::points::normal_estimation::{Normal, estimate_normals};
use crate::pose::manhattan_frame::{NEIGHBOURS, aligned_weights, fit_frame, manhattan_frame};
use crate::pose::nearest_rotation::angle_between;
use crate::pose::similarity::PointPair;

/// Sines of the largest angles between a normal and an axis, round by round.
const MAX_SINES: [f64; 6] = [0.45, 0.35, 0.25, 0.15, 0.1, 0.1];
/// Sine of the largest angle between a normal and an axis, for rotations about a given direction.
const MAX_SINE_ABOUT: f64 = 0.2;
/// Smallest share of a part's observed normals that must align with the axes that are found.
const MIN_SHARE: f64 = 0.3;
/// Smallest ratio of normals along other axes to normals along the main axis. Below it, only one axis is observed.
const ONE_SIDED: f64 = 0.15;
/// Largest correction of a rotation, in radians.
const MAX_CORRECTION: f64 = 0.5;
/// Largest correction about a given direction, in radians.
const MAX_CORRECTION_ABOUT: f64 = 0.3;
/// Step between angles that are tried about a given direction, in radians.
const ANGLE_STEP: f64 = 0.01;
/// Penalty for the largest correction, as a share of the normals. Among equally good corrections the smallest wins.
const CORRECTION_PENALTY: f64 = 0.02;
/// Cosine of the smallest angle between a normal and a given direction. Closer normals do not determine the rotation
/// about it.
const PARALLEL: f64 = 0.7;

/// Observed points and normals of the parts of one object, and a flag per part: true if it is axis-aligned.
pub struct AxisAlignment<'a> {
    points: Vec<Vec<Point3<f64>>>,
    normals: Vec<Vec<Normal>>,
    axis_aligned: &'a [bool],
}

impl<'a> AxisAlignment<'a> {
    /// Estimates normals from the targets of the pairs of all parts, which are points of one surface.
    pub fn new(parts: &[&[PointPair]], axis_aligned: &'a [bool]) -> Self {
        let points: Vec<Vec<Point3<f64>>> =
            parts.iter().map(|pairs| pairs.iter().map(|pair| pair.1).collect()).collect();
        let observed = if axis_aligned.contains(&true) { points.concat() } else { Vec::new() };
        let mut all = estimate_normals(&observed, NEIGHBOURS).into_iter();
        let normals = points.iter().map(|own| all.by_ref().take(own.len()).collect()).collect();
        Self { points, normals, axis_aligned }
    }

    /// Rotation of a part, corrected so that its observed surface aligns with its axes.
    ///
    /// The rotation stays as it is if the part is not axis-aligned, if too few normals align, or if the correction is
    /// too large.
    pub fn rotated(&self, part: usize, rotation: Rotation3<f64>) -> Rotation3<f64> {
        if !self.axis_aligned[part] {
            return rotation;
        }
        let normals = &self.normals[part];
        let found = fit_frame(rotation, normals, &MAX_SINES);
        let aligned = aligned_weights(&found, normals, MAX_SINES[MAX_SINES.len() - 1]);
        let (most, all) = (aligned.imax(), normals.iter().map(|normal| normal.weight).sum::<f64>());
        let is_one_sided = aligned.sum() - aligned[most] < ONE_SIDED * aligned[most];
        // One observed axis determines the tilt, but not the rotation about that axis.
        let axis = |frame: &Rotation3<f64>| frame.matrix().column(most).into_owned();
        let tilted = || Rotation3::rotation_between(&axis(&rotation), &axis(&found)).map(|tilt| tilt * rotation);
        let found = if is_one_sided { tilted().unwrap_or(rotation) } else { found };
        let is_near = angle_between(&found, &rotation) <= MAX_CORRECTION;
        if is_near && aligned.sum() >= MIN_SHARE * all && all > 0.0 { found } else { rotation }
    }

    /// The 24 rotations that align the observed surface of a part with its axes; none if too few normals align.
    pub fn aligned_rotations(&self, part: usize) -> Vec<Rotation3<f64>> {
        if !self.axis_aligned[part] {
            return Vec::new();
        }
        let frame = manhattan_frame(&self.points[part]);
        let all: f64 = self.normals[part].iter().map(|normal| normal.weight).sum();
        if all == 0.0
            || aligned_weights(&frame, &self.normals[part], MAX_SINES[MAX_SINES.len() - 1]).sum() < MIN_SHARE * all
        {
            return Vec::new();
        }
        let signed = [1.0, -1.0].into_iter().flat_map(|sign| (0..3).map(move |axis| (axis, sign)));
        let column = |(axis, sign): (usize, f64)| frame.matrix().column(axis) * sign;
        let pairs = signed.clone().flat_map(|first| signed.clone().map(move |second| (first, second)));
        let frames = pairs.filter(|(first, second)| first.0 != second.0).map(|(first, second)| {
            let (x, y) = (column(first), column(second));
            Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]))
        });
        frames.collect()
    }

    /// Rotation of a part, corrected like [`Self::rotated`], but only about a `direction` in the part's frame.
    pub fn rotated_about(
        &self,
        part: usize,
        rotation: Rotation3<f64>,
        direction: &Unit<Vector3<f64>>,
    ) -> Rotation3<f64> {
        if !self.axis_aligned[part] {
            return rotation;
        }
        let line = rotation * direction;
        let across = self.normals[part].iter().filter(|normal| normal.direction.dot(&line).abs() < PARALLEL);
        let across: Vec<Normal> = across.copied().collect();
        let all: f64 = self.normals[part].iter().map(|normal| normal.weight).sum();
        let steps = (MAX_CORRECTION_ABOUT / ANGLE_STEP).round() as i32;
        let tried = (-steps..=steps).map(|step| {
            let rotated = rotation * Rotation3::from_axis_angle(direction, f64::from(step) * ANGLE_STEP);
            let share = aligned_weights(&rotated, &across, MAX_SINE_ABOUT).sum() / all.max(f64::MIN_POSITIVE);
            (share, share - CORRECTION_PENALTY * f64::from(step.abs()) / f64::from(steps), rotated)
        });
        match tried.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((share, _, found)) if share >= MIN_SHARE => found,
            _ => rotation,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Observed points on three sides of a box.
    fn sides(places: &[[f64; 3]], rotation: Rotation3<f64>) -> Vec<PointPair> {
        let side = |(row, place): (usize, &[f64; 3])| {
            let mut place = Point3::from(*place);
            place[row % 3] = 1.0;
            (place, rotation * place)
        };
        places.iter().enumerate().map(side).collect()
    }

    proptest! {
        #[test]
        fn a_box_is_aligned_with_its_sides(
            turn in prop::array::uniform3(-3.0..3.0),
            wrong in prop::array::uniform3(-0.15..0.15),
            places in prop::collection::vec(prop::array::uniform3(0.0..1.0), 200),
        ) {
            let truth = Rotation3::new(turn.into());
            let pairs = sides(&places, truth);
            let start = truth * Rotation3::new(wrong.into());
            let found = AxisAlignment::new(&[&pairs], &[true]).rotated(0, start);
            prop_assert!(angle_between(&found, &truth) < 0.01);
            prop_assert_eq!(AxisAlignment::new(&[&pairs], &[false]).rotated(0, start), start);
        }

        #[test]
        fn a_box_has_24_aligned_rotations(
            turn in prop::array::uniform3(-3.0..3.0), places in prop::collection::vec(prop::array::uniform3(0.0..1.0), 200)
        ) {
            let truth = Rotation3::new(turn.into());
            let pairs = sides(&places, truth);
            let found = AxisAlignment::new(&[&pairs], &[true]).aligned_rotations(0);
            prop_assert_eq!(found.len(), 24);
            prop_assert_eq!(found.iter().filter(|found| angle_between(found, &truth) < 0.01).count(), 1);
            prop_assert!(found.iter().all(|found| (found.matrix().determinant() - 1.0).abs() < 1e-9));
            prop_assert!(AxisAlignment::new(&[&pairs], &[false]).aligned_rotations(0).is_empty());
            prop_assert!(AxisAlignment::new(&[&[]], &[true]).aligned_rotations(0).is_empty());
        }

        #[test]
        fn a_door_is_aligned_about_its_hinge(
            turn in prop::array::uniform3(-3.0..3.0),
            wrong in -0.25..0.25,
            places in prop::collection::vec(prop::array::uniform3(0.0..1.0), 200),
        ) {
            let truth = Rotation3::new(turn.into());
            let pairs = sides(&places, truth);
            let start = truth * Rotation3::from_axis_angle(&Vector3::y_axis(), wrong);
            let found = AxisAlignment::new(&[&pairs], &[true]).rotated_about(0, start, &Vector3::y_axis());
            prop_assert!(angle_between(&found, &truth) < 2.0 * ANGLE_STEP);
        }
    }

    /// Observed points on one flat, slightly uneven side.
    fn side(places: &[[f64; 3]], rotation: Rotation3<f64>) -> Vec<PointPair> {
        let place = |place: &[f64; 3]| Point3::new(place[0], place[1], 0.02 * place[2]);
        places.iter().map(|at| (place(at), rotation * place(at))).collect()
    }

    proptest! {
        #[test]
        fn a_single_side_corrects_the_tilt_only(
            turn in prop::array::uniform3(-3.0..3.0),
            tilt in -0.15..0.15,
            places in prop::collection::vec(prop::array::uniform3(0.0..1.0), 300),
        ) {
            let truth = Rotation3::new(turn.into());
            let pairs = side(&places, truth);
            let alignment = AxisAlignment::new(&[&pairs], &[true]);
            let found = alignment.rotated(0, truth * Rotation3::from_axis_angle(&Vector3::x_axis(), tilt));
            prop_assert!(angle_between(&found, &truth) < 0.03);
            prop_assert_eq!(alignment.rotated_about(0, truth, &Vector3::z_axis()), truth);
        }
    }

    #[test]
    fn a_ball_keeps_its_rotation() {
        let ball = (0..500).map(|row| {
            let (height, angle) = (1.0 - f64::from(row) / 250.0, f64::from(row) * 2.4);
            let radius = (1.0 - height * height).sqrt();
            let place = Point3::new(radius * angle.cos(), radius * angle.sin(), height);
            (place, place)
        });
        let ball: Vec<PointPair> = ball.collect();
        let alignment = AxisAlignment::new(&[&ball, &[]], &[true, true]);
        let rotation = Rotation3::new(Vector3::new(0.1, 0.2, 0.3));
        assert_eq!(alignment.rotated(0, rotation), rotation);
        assert_eq!(alignment.rotated(1, rotation), rotation);
        assert_eq!(alignment.rotated_about(1, rotation, &Vector3::x_axis()), rotation);
    }
}
