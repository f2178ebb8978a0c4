//! Turns of parts whose surfaces face their axes, corrected by the normals of what is seen of them.

use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};

use crate::manhattan::{NEIGHBOURS, faced, fitted, manhattan_frame};
use crate::normals::{Normal, normals};
use crate::ransac::Pair;
use crate::similarity::angle_between;

/// Sines of the angles within which normals count, round after round.
const REACHES: [f64; 6] = [0.45, 0.35, 0.25, 0.15, 0.1, 0.1];
/// Sine of the angle within which normals tell how far a part is turned about a given axis.
const REACH_ABOUT: f64 = 0.2;
/// At least this share of what is seen of a part must face the axes that were found.
const LEAST_SHARE: f64 = 0.3;
/// What is seen of a part of which less than this share (of what faces the first axis) faces another tells of one axis alone.
const ONE_SIDED: f64 = 0.15;
/// Farther than this, in radians, no part is turned.
const FARTHEST: f64 = 0.5;
/// Farther than this, none is turned about a given axis.
const FARTHEST_ABOUT: f64 = 0.3;
/// Between the angles that are tried about a given axis.
const STEP: f64 = 0.01;
/// So much of the share is the largest turn about a given axis worth: of turns that are as good the least is taken.
const PRICE: f64 = 0.02;
/// Cosine to a given axis from which on normals do not tell how far a part is turned about it.
const ALONG: f64 = 0.7;

/// What is seen of the parts of one object, and which of them are `square`: those whose surfaces face their axes.
pub struct Facing<'a> {
    points: Vec<Vec<Point3<f64>>>,
    normals: Vec<Vec<Normal>>,
    square: &'a [bool],
}

impl<'a> Facing<'a> {
    /// From the targets of the pairs of all parts, which are points of one surface.
    pub fn new(parts: &[&[Pair]], square: &'a [bool]) -> Self {
        let points: Vec<Vec<Point3<f64>>> =
            parts.iter().map(|pairs| pairs.iter().map(|pair| pair.1).collect()).collect();
        let seen = if square.contains(&true) { points.concat() } else { Vec::new() };
        let mut all = normals(&seen, NEIGHBOURS).into_iter();
        let normals = points.iter().map(|own| all.by_ref().take(own.len()).collect()).collect();
        Self { points, normals, square }
    }

    /// `rotation` of a part, turned a little, so that what is seen of it faces its axes; as it is if too little would.
    pub fn turned(&self, part: usize, rotation: Rotation3<f64>) -> Rotation3<f64> {
        if !self.square[part] {
            return rotation;
        }
        let normals = &self.normals[part];
        let found = fitted(rotation, normals, &REACHES);
        let faced = faced(&found, normals, REACHES[REACHES.len() - 1]);
        let (most, all) = (faced.imax(), normals.iter().map(|normal| normal.weight).sum::<f64>());
        let is_one_sided = faced.sum() - faced[most] < ONE_SIDED * faced[most];
        // Of one axis, how it is tilted is known, and not how the part is turned about it.
        let axis = |frame: &Rotation3<f64>| frame.matrix().column(most).into_owned();
        let tilted = || Rotation3::rotation_between(&axis(&rotation), &axis(&found)).map(|tilt| tilt * rotation);
        let found = if is_one_sided { tilted().unwrap_or(rotation) } else { found };
        let is_near = angle_between(&found, &rotation) <= FARTHEST;
        if is_near && faced.sum() >= LEAST_SHARE * all && all > 0.0 { found } else { rotation }
    }

    /// The 24 rotations that make what is seen of a part face its axes; none if too little does.
    pub fn rotations(&self, part: usize) -> Vec<Rotation3<f64>> {
        if !self.square[part] {
            return Vec::new();
        }
        let frame = manhattan_frame(&self.points[part]);
        let all: f64 = self.normals[part].iter().map(|normal| normal.weight).sum();
        if all == 0.0 || faced(&frame, &self.normals[part], REACHES[REACHES.len() - 1]).sum() < LEAST_SHARE * all {
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

    /// As [`Self::turned`], about a `direction` of the part alone.
    pub fn turned_about(
        &self,
        part: usize,
        rotation: Rotation3<f64>,
        direction: &Unit<Vector3<f64>>,
    ) -> Rotation3<f64> {
        if !self.square[part] {
            return rotation;
        }
        let line = rotation * direction;
        let across = self.normals[part].iter().filter(|normal| normal.direction.dot(&line).abs() < ALONG);
        let across: Vec<Normal> = across.copied().collect();
        let all: f64 = self.normals[part].iter().map(|normal| normal.weight).sum();
        let steps = (FARTHEST_ABOUT / STEP).round() as i32;
        let tried = (-steps..=steps).map(|step| {
            let turned = rotation * Rotation3::from_axis_angle(direction, f64::from(step) * STEP);
            let share = faced(&turned, &across, REACH_ABOUT).sum() / all.max(f64::MIN_POSITIVE);
            (share, share - PRICE * f64::from(step.abs()) / f64::from(steps), turned)
        });
        match tried.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((share, _, found)) if share >= LEAST_SHARE => found,
            _ => rotation,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// What is seen of three sides of a box.
    fn sides(places: &[[f64; 3]], rotation: Rotation3<f64>) -> Vec<Pair> {
        let side = |(row, place): (usize, &[f64; 3])| {
            let mut place = Point3::from(*place);
            place[row % 3] = 1.0;
            (place, rotation * place)
        };
        places.iter().enumerate().map(side).collect()
    }

    proptest! {
        #[test]
        fn a_box_is_turned_to_where_its_sides_face(
            turn in prop::array::uniform3(-3.0..3.0),
            wrong in prop::array::uniform3(-0.15..0.15),
            places in prop::collection::vec(prop::array::uniform3(0.0..1.0), 200),
        ) {
            let truth = Rotation3::new(turn.into());
            let pairs = sides(&places, truth);
            let start = truth * Rotation3::new(wrong.into());
            let found = Facing::new(&[&pairs], &[true]).turned(0, start);
            prop_assert!(angle_between(&found, &truth) < 0.01);
            prop_assert_eq!(Facing::new(&[&pairs], &[false]).turned(0, start), start);
        }

        #[test]
        fn a_box_faces_its_axes_in_24_ways(
            turn in prop::array::uniform3(-3.0..3.0), places in prop::collection::vec(prop::array::uniform3(0.0..1.0), 200)
        ) {
            let truth = Rotation3::new(turn.into());
            let pairs = sides(&places, truth);
            let found = Facing::new(&[&pairs], &[true]).rotations(0);
            prop_assert_eq!(found.len(), 24);
            prop_assert_eq!(found.iter().filter(|found| angle_between(found, &truth) < 0.01).count(), 1);
            prop_assert!(found.iter().all(|found| (found.matrix().determinant() - 1.0).abs() < 1e-9));
            prop_assert!(Facing::new(&[&pairs], &[false]).rotations(0).is_empty());
            prop_assert!(Facing::new(&[&[]], &[true]).rotations(0).is_empty());
        }

        #[test]
        fn a_door_is_turned_about_its_hinge(
            turn in prop::array::uniform3(-3.0..3.0),
            wrong in -0.25..0.25,
            places in prop::collection::vec(prop::array::uniform3(0.0..1.0), 200),
        ) {
            let truth = Rotation3::new(turn.into());
            let pairs = sides(&places, truth);
            let start = truth * Rotation3::from_axis_angle(&Vector3::y_axis(), wrong);
            let found = Facing::new(&[&pairs], &[true]).turned_about(0, start, &Vector3::y_axis());
            prop_assert!(angle_between(&found, &truth) < 2.0 * STEP);
        }
    }

    /// What is seen of a flat side, a little uneven.
    fn side(places: &[[f64; 3]], rotation: Rotation3<f64>) -> Vec<Pair> {
        let place = |place: &[f64; 3]| Point3::new(place[0], place[1], 0.02 * place[2]);
        places.iter().map(|at| (place(at), rotation * place(at))).collect()
    }

    proptest! {
        #[test]
        fn of_one_side_alone_a_part_is_tilted_and_not_turned_about_its_normal(
            turn in prop::array::uniform3(-3.0..3.0),
            tilt in -0.15..0.15,
            places in prop::collection::vec(prop::array::uniform3(0.0..1.0), 300),
        ) {
            let truth = Rotation3::new(turn.into());
            let pairs = side(&places, truth);
            let facing = Facing::new(&[&pairs], &[true]);
            let found = facing.turned(0, truth * Rotation3::from_axis_angle(&Vector3::x_axis(), tilt));
            prop_assert!(angle_between(&found, &truth) < 0.03);
            prop_assert_eq!(facing.turned_about(0, truth, &Vector3::z_axis()), truth);
        }
    }

    #[test]
    fn what_faces_no_axes_stays_as_it_is() {
        let ball = (0..500).map(|row| {
            let (height, angle) = (1.0 - f64::from(row) / 250.0, f64::from(row) * 2.4);
            let radius = (1.0 - height * height).sqrt();
            let place = Point3::new(radius * angle.cos(), radius * angle.sin(), height);
            (place, place)
        });
        let ball: Vec<Pair> = ball.collect();
        let facing = Facing::new(&[&ball, &[]], &[true, true]);
        let rotation = Rotation3::new(Vector3::new(0.1, 0.2, 0.3));
        assert_eq!(facing.turned(0, rotation), rotation);
        assert_eq!(facing.turned(1, rotation), rotation);
        assert_eq!(facing.turned_about(1, rotation, &Vector3::x_axis()), rotation);
    }
}
