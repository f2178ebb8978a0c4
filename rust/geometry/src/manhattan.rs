//! The three directions at right angles that the surfaces of a scan face.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wide::f32x8;

use crate::normals::{Normal, normals};
use crate::rectangle::{flush_axes, perpendicular_basis};
use crate::similarity::nearest_rotation;

/// Points that tell the normal at each.
pub(crate) const NEIGHBOURS: usize = 12;
/// Frames that are tried, each through two normals drawn at random.
const HYPOTHESES: usize = 200;
/// Of the normals that judge them.
const JUDGES: usize = 256;
/// Judges that count at a time.
const LANES: usize = 8;
/// Normals count that are off an axis by less than the sine of these: first all that may be meant, then those that are.
const REACHES: [f64; 7] = [0.4, 0.3, 0.2, 0.15, 0.1, 0.1, 0.1];
/// A scan of which less than this share (of what faces the first axis) faces the others shows one side alone.
const ONE_SIDED: f64 = 0.05;
/// Of the draws: the same points always give the same frame.
const SEED: u64 = 1;

/// The frame whose axes (columns, in no order and of no sign) most of the surface that `points` were drawn from faces.
///
/// What shows one flat side alone has its other axes along the rectangle of least area about it. Straub et al., The Manhattan
/// Frame Model, 2018, define the frame; it is looked for among pairs of normals, and fitted to those that are near to an axis.
pub fn manhattan_frame(points: &[Point3<f64>]) -> Rotation3<f64> {
    let normals = normals(points, NEIGHBOURS);
    let Some(found) = through_two_normals(&normals) else { return Rotation3::identity() };
    let found = fitted(found, &normals, &REACHES);
    let faced = faced(&found, &normals, REACHES[REACHES.len() - 1]);
    let first = faced.imax();
    if faced.sum() - faced[first] >= ONE_SIDED * faced[first] {
        return found;
    }
    let axes = flush_axes(points, found.matrix().column(first).into());
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&axes))
}

/// How much of `normals` is nearer to each axis of `frame` than by the sine `reach`, what is on it counted whole.
pub(crate) fn faced(frame: &Rotation3<f64>, normals: &[Normal], reach: f64) -> Vector3<f64> {
    let mut faced = Vector3::zeros();
    for normal in normals {
        let (axis, _, weight) = faced_axis(frame, normal, reach);
        faced[axis] += weight;
    }
    faced
}

/// `frame`, turned so that `normals` near to its axes are nearest to them; each of `reaches` is a round.
pub(crate) fn fitted(frame: Rotation3<f64>, normals: &[Normal], reaches: &[f64]) -> Rotation3<f64> {
    reaches.iter().fold(frame, |frame, reach| {
        let mut sums = Matrix3::zeros();
        let mut total = 0.0;
        for normal in normals {
            let (axis, sign, weight) = faced_axis(&frame, normal, *reach);
            let mut sum = sums.column_mut(axis);
            sum += normal.direction * (sign * weight);
            total += weight;
        }
        if total == 0.0 {
            return frame;
        }
        // An axis that nothing faces stays as near as can be to where it is.
        nearest_rotation(sums + frame.matrix() * (1e-6 * total)).map_or(frame, |(nearest, _)| nearest)
    })
}

/// The axis of `frame` that a normal is nearest to, its sign, and how much that counts.
fn faced_axis(frame: &Rotation3<f64>, normal: &Normal, reach: f64) -> (usize, f64, f64) {
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
    let judges = Judges::new(normals.iter().step_by(normals.len().div_ceil(JUDGES)).collect());
    let mut best: Option<(f32, Rotation3<f64>)> = None;
    for _ in 0..HYPOTHESES {
        let [first, second] = [0; 2].map(|_| normals[rng.random_range(0..normals.len())].direction);
        let across = second - first * first.dot(&second);
        // Of a plane alone the second axis is any.
        let across = across.try_normalize(0.2).unwrap_or_else(|| perpendicular_basis(first).0);
        let axes = [first, across, first.cross(&across)];
        let frame = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&axes));
        let score = judges.faced(&axes);
        if best.as_ref().is_none_or(|(highest, _)| score > *highest) {
            best = Some((score, frame));
        }
    }
    best.map(|(_, frame)| frame)
}

/// Normals that judge frames, several at a time; in single precision, which tells good frames from bad ones.
struct Judges {
    /// Their directions and weights; of no weight where the last lanes have none.
    lanes: Vec<[f32x8; 4]>,
}

impl Judges {
    fn new(normals: Vec<&Normal>) -> Self {
        let value_of = |normal: Option<&&Normal>, at: usize| {
            normal.map_or(0.0, |normal| if at < 3 { normal.direction[at] } else { normal.weight }) as f32
        };
        let lanes_of =
            |chunk: &[&Normal]| [0, 1, 2, 3].map(|at| f32x8::from(std::array::from_fn(|i| value_of(chunk.get(i), at))));
        Self { lanes: normals.chunks(LANES).map(lanes_of).collect() }
    }

    /// How much of them is near to some of three axes at right angles, as [`faced_axis`] counts it.
    fn faced(&self, axes: &[Vector3<f64>; 3]) -> f32 {
        let axes = axes.map(|axis| [0, 1, 2].map(|i| f32x8::splat(axis[i] as f32)));
        let per_squared_reach = f32x8::splat((REACHES[1] * REACHES[1]).recip() as f32);
        let add = |sum: f32x8, [x, y, z, weight]: &[f32x8; 4]| {
            let [a, b, c] = axes.map(|axis| axis[0] * *x + axis[1] * *y + axis[2] * *z);
            let squared_sine = f32x8::ONE - (a * a).fast_max(b * b).fast_max(c * c);
            sum + *weight * (f32x8::ONE - squared_sine * per_squared_reach).fast_max(f32x8::ZERO)
        };
        self.lanes.iter().fold(f32x8::ZERO, add).reduce_add()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Points on three sides of a box, on a door of it that is turned, and anywhere.
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

    /// The angle between two frames whose axes have no order and no sign.
    fn apart(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
        let between = a.inverse() * b;
        (0..3).map(|axis| between.matrix().column(axis).amax().min(1.0).acos()).fold(0.0, f64::max)
    }

    proptest! {
        #[test]
        fn judges_count_what_faces_a_frame(
            (turn, _) in scan(0.0),
            normals in prop::collection::vec((prop::array::uniform3(-1.0..1.0), 0.0..1.0), 1..40),
        ) {
            let normal = |(along, weight): &([f64; 3], f64)| Normal {
                direction: Vector3::from(*along).try_normalize(1e-9).unwrap_or(Vector3::x()), weight: *weight,
            };
            let normals: Vec<Normal> = normals.iter().map(normal).collect();
            let axes = [0, 1, 2].map(|axis| turn.matrix().column(axis).into_owned());
            let found = Judges::new(normals.iter().collect()).faced(&axes);
            prop_assert!((f64::from(found) - faced(&turn, &normals, REACHES[1]).sum()).abs() < 1e-3);
        }

        #[test]
        fn a_box_with_an_open_door_tells_its_axes((turn, points) in scan(0.002)) {
            prop_assert!(apart(&manhattan_frame(&points), &turn) < 0.05);
        }

        #[test]
        fn a_frame_turns_with_the_points((_, points) in scan(0.0), turn in prop::array::uniform3(-3.0..3.0)) {
            let turn = Rotation3::new(Vector3::from(turn));
            let turned: Vec<_> = points.iter().map(|point| turn * point).collect();
            prop_assert!(apart(&manhattan_frame(&turned), &(turn * manhattan_frame(&points))) < 0.05);
        }

        #[test]
        fn a_single_side_has_its_axes_along_its_edges(
            turn in prop::array::uniform3(-3.0..3.0), places in prop::collection::vec(prop::array::uniform2(-0.5..0.5), 100)
        ) {
            let turn = Rotation3::new(Vector3::from(turn));
            let corners = [[-0.5, -0.5], [-0.5, 0.5], [0.5, -0.5], [0.5, 0.5]];
            let points = corners.iter().chain(&places).map(|[x, y]| turn * Point3::new(*x, 2.0 * y, 0.3));
            prop_assert!(apart(&manhattan_frame(&points.collect::<Vec<_>>()), &turn) < 1e-6);
        }
    }

    #[test]
    fn too_few_points_stay_as_they_are() {
        assert_eq!(manhattan_frame(&[]), Rotation3::identity());
        let one = manhattan_frame(&[Point3::new(1.0, 2.0, 3.0)]);
        assert!((one.matrix().determinant() - 1.0).abs() < 1e-9);
    }
}
