//! Manhattan frame of a scan: the three perpendicular directions that most of its surface is aligned with.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wide::f32x8;

use crate::fit::minimum_area_rectangle::minimum_area_axes;
use crate::points::normal_estimation::{Normal, estimate_normals};
use crate::points::perpendicular::perpendicular_basis;
use crate::pose::nearest_rotation::nearest_rotation;

/// Number of neighbours from which the normal at a point is estimated.
pub(crate) const NEIGHBOURS: usize = 12;
/// Number of candidate frames, each from two random normals.
const HYPOTHESES: usize = 200;
/// Largest number of normals that score a candidate frame.
const SCORING_NORMALS: usize = 256;
/// Normals that are scored at a time.
const BLOCK: usize = 8;
/// Sines of the largest angles between a normal and an axis, round by round: first wide, then narrow.
const MAX_SINES: [f64; 7] = [0.4, 0.3, 0.2, 0.15, 0.1, 0.1, 0.1];
/// Smallest ratio of normals along other axes to normals along the main axis. Below it, the scan shows a single side.
const ONE_SIDED: f64 = 0.05;
/// Seed of the random draws. The same points always give the same frame.
const SEED: u64 = 1;

/// Frame whose axes align with most of the surface that `points` were sampled from.
///
/// The axes are the columns of the result. They have no order and no sign. If the scan shows a single flat side, the
/// other two axes follow the rectangle of least area around it.
///
/// The search draws pairs of normals, and refines the best frame on the normals near its axes. Definition: Straub et
/// al., The Manhattan Frame Model, 2018.
pub fn manhattan_frame(points: &[Point3<f64>]) -> Rotation3<f64> {
    let normals = estimate_normals(points, NEIGHBOURS);
    let Some(found) = through_two_normals(&normals) else { return Rotation3::identity() };
    let found = fit_frame(found, &normals, &MAX_SINES);
    let aligned = aligned_weights(&found, &normals, MAX_SINES[MAX_SINES.len() - 1]);
    let first = aligned.imax();
    if aligned.sum() - aligned[first] >= ONE_SIDED * aligned[first] {
        return found;
    }
    let axes = minimum_area_axes(points, found.matrix().column(first).into());
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&axes))
}

/// Weight of the normals aligned with each axis of `frame`.
///
/// A normal counts fully on an axis, and not at all at an angle with the sine `reach` or more.
pub(crate) fn aligned_weights(frame: &Rotation3<f64>, normals: &[Normal], reach: f64) -> Vector3<f64> {
    let mut aligned = Vector3::zeros();
    for normal in normals {
        let (axis, _, weight) = aligned_axis(frame, normal, reach);
        aligned[axis] += weight;
    }
    aligned
}

/// Rotates `frame` to the normals near its axes, with one round per entry of `reaches`.
pub(crate) fn fit_frame(frame: Rotation3<f64>, normals: &[Normal], reaches: &[f64]) -> Rotation3<f64> {
    reaches.iter().fold(frame, |frame, reach| {
        let mut sums = Matrix3::zeros();
        let mut total = 0.0;
        for normal in normals {
            let (axis, sign, weight) = aligned_axis(&frame, normal, *reach);
            let mut sum = sums.column_mut(axis);
            sum += normal.direction * (sign * weight);
            total += weight;
        }
        if total == 0.0 {
            return frame;
        }
        // A small multiple of the old frame keeps an axis without normals as near as possible to its place.
        nearest_rotation(sums + frame.matrix() * (1e-6 * total)).map_or(frame, |(nearest, _)| nearest)
    })
}

/// Nearest axis of `frame` to a normal, with its sign and weight.
fn aligned_axis(frame: &Rotation3<f64>, normal: &Normal, reach: f64) -> (usize, f64, f64) {
    let along = frame.matrix().tr_mul(&normal.direction);
    let axis = along.iamax();
    let squared_sine = (1.0 - along[axis] * along[axis]).max(0.0);
    (axis, along[axis].signum(), normal.weight * (1.0 - squared_sine / (reach * reach)).max(0.0))
}

fn through_two_normals(normals: &[Normal]) -> Option<Rotation3<f64>> {
    if normals.is_empty() {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let scoring = ScoringNormals::new(normals.iter().step_by(normals.len().div_ceil(SCORING_NORMALS)).collect());
    let mut best: Option<(f32, Rotation3<f64>)> = None;
    for _ in 0..HYPOTHESES {
        let [first, second] = [0; 2].map(|_| normals[rng.random_range(0..normals.len())].direction);
        let across = second - first * first.dot(&second);
        // If all normals are parallel, the second axis is arbitrary.
        let across = across.try_normalize(0.2).unwrap_or_else(|| perpendicular_basis(first).0);
        let axes = [first, across, first.cross(&across)];
        let frame = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&axes));
        let score = scoring.aligned_weights(&axes);
        if best.as_ref().is_none_or(|(highest, _)| score > *highest) {
            best = Some((score, frame));
        }
    }
    best.map(|(_, frame)| frame)
}

/// Normals that score candidate frames, in single precision, which suffices to rank frames.
struct ScoringNormals {
    /// Directions and weights. Unused entries have zero weight.
    blocks: Vec<[f32x8; 4]>,
}

impl ScoringNormals {
    fn new(normals: Vec<&Normal>) -> Self {
        let value_of = |normal: Option<&&Normal>, at: usize| {
            normal.map_or(0.0, |normal| if at < 3 { normal.direction[at] } else { normal.weight }) as f32
        };
        let block_of =
            |chunk: &[&Normal]| [0, 1, 2, 3].map(|at| f32x8::from(std::array::from_fn(|i| value_of(chunk.get(i), at))));
        Self { blocks: normals.chunks(BLOCK).map(block_of).collect() }
    }

    /// Weight of the normals aligned with any of three perpendicular axes, as counted by [`aligned_axis`].
    fn aligned_weights(&self, axes: &[Vector3<f64>; 3]) -> f32 {
        let axes = axes.map(|axis| [0, 1, 2].map(|i| f32x8::splat(axis[i] as f32)));
        let per_squared_reach = f32x8::splat((MAX_SINES[1] * MAX_SINES[1]).recip() as f32);
        let add = |sum: f32x8, [x, y, z, weight]: &[f32x8; 4]| {
            let [a, b, c] = axes.map(|axis| axis[0] * *x + axis[1] * *y + axis[2] * *z);
            let squared_sine = f32x8::ONE - (a * a).fast_max(b * b).fast_max(c * c);
            sum + *weight * (f32x8::ONE - squared_sine * per_squared_reach).fast_max(f32x8::ZERO)
        };
        self.blocks.iter().fold(f32x8::ZERO, add).reduce_add()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Points on three sides of a box, on an open door, and at random places.
    fn scan(noise: f64) -> impl Strategy<Value = (Rotation3<f64>, Vec<Point3<f64>>)> {
        let places =
            prop::collection::vec((prop::array::uniform3(-0.5..0.5), prop::array::uniform3(-noise..=noise)), 400);
        (prop::array::uniform3(-3.0..3.0), 0.3..1.2, places).prop_map(|(turn, opened, places)| {
            let turn = Rotation3::new(Vector3::from(turn));
            let door = Rotation3::from_axis_angle(&Vector3::z_axis(), opened);
            let points = places.iter().enumerate().map(|(row, (place, noise))| {
                let mut place = Vector3::from(*place);
                match row % 10 {
                    9 => (),
                    7..9 => {
                        place.y = 0.5;
                        place = door * (place + Vector3::x() * 0.5);
                    }
                    side => place[side % 3] = 0.5,
                }
                Point3::from(turn * (place + Vector3::from(*noise)))
            });
            (turn, points.collect())
        })
    }

    /// Angle between two frames whose axes have no order and no sign.
    fn apart(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
        let between = a.inverse() * b;
        (0..3).map(|axis| between.matrix().column(axis).amax().min(1.0).acos()).fold(0.0, f64::max)
    }

    proptest! {
        #[test]
        fn single_precision_scores_agree_with_aligned_weights(
            (turn, _) in scan(0.0),
            normals in prop::collection::vec((prop::array::uniform3(-1.0..1.0), 0.0..1.0), 1..40),
        ) {
            let normal = |(along, weight): &([f64; 3], f64)| Normal {
                direction: Vector3::from(*along).try_normalize(1e-9).unwrap_or(Vector3::x()), weight: *weight,
            };
            let normals: Vec<Normal> = normals.iter().map(normal).collect();
            let axes = [0, 1, 2].map(|axis| turn.matrix().column(axis).into_owned());
            let found = ScoringNormals::new(normals.iter().collect()).aligned_weights(&axes);
            prop_assert!((f64::from(found) - aligned_weights(&turn, &normals, MAX_SINES[1]).sum()).abs() < 1e-3);
        }

        #[test]
        fn the_frame_of_a_box_with_an_open_door_is_found((turn, points) in scan(0.002)) {
            prop_assert!(apart(&manhattan_frame(&points), &turn) < 0.05);
        }

        #[test]
        fn a_frame_rotates_with_the_points((_, points) in scan(0.0), turn in prop::array::uniform3(-3.0..3.0)) {
            let turn = Rotation3::new(Vector3::from(turn));
            let turned: Vec<_> = points.iter().map(|point| turn * point).collect();
            prop_assert!(apart(&manhattan_frame(&turned), &(turn * manhattan_frame(&points))) < 0.05);
        }

        #[test]
        fn the_frame_of_a_single_side_follows_its_edges(
            turn in prop::array::uniform3(-3.0..3.0), places in prop::collection::vec(prop::array::uniform2(-0.5..0.5), 100)
        ) {
            let turn = Rotation3::new(Vector3::from(turn));
            let corners = [[-0.5, -0.5], [-0.5, 0.5], [0.5, -0.5], [0.5, 0.5]];
            let points = corners.iter().chain(&places).map(|[x, y]| turn * Point3::new(*x, 2.0 * y, 0.3));
            prop_assert!(apart(&manhattan_frame(&points.collect::<Vec<_>>()), &turn) < 1e-6);
        }
    }

    #[test]
    fn too_few_points_give_a_valid_rotation() {
        assert_eq!(manhattan_frame(&[]), Rotation3::identity());
        let one = manhattan_frame(&[Point3::new(1.0, 2.0, 3.0)]);
        assert!((one.matrix().determinant() - 1.0).abs() < 1e-9);
    }
}
