//! Round pieces of a mesh, such as pins, barrels, axles and knobs.

use nalgebra::{Point3, Vector3};

use crate::Mesh;
use crate::fit::axis_of_revolution::axis_of_revolution;
use crate::fit::principal_axes::principal_axes;
use crate::fit::symmetry_test::{SymmetryTest, TestOptions};
use crate::mesh::bvh::Bvh;
use crate::mesh::connected_components::connected_components;
use crate::mesh::part_surface::PartSurface;
use crate::points::perpendicular::any_perpendicular;
use crate::points::surface_sampling::sample_surface;

/// A connected component that is a solid of revolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundPiece {
    /// Point on the axis halfway between the ends of the piece.
    pub middle: Point3<f64>,
    /// Unit direction of the axis.
    pub direction: Vector3<f64>,
    /// Largest distance from the axis.
    pub radius: f64,
    /// Half of the length along the axis.
    pub half_length: f64,
}

/// Smallest number of faces of a round piece. An open prism with four sides has eight faces.
const MIN_FACES: usize = 9;

/// Number of samples from which the axis is fitted.
const FITTED_SAMPLES: usize = 256;

/// Round pieces of a mesh, in the order of their first faces.
///
/// Balls are excluded, because they are round about any axis.
pub fn round_pieces(mesh: &Mesh, options: &TestOptions) -> Vec<RoundPiece> {
    let pieces = connected_components(mesh);
    pieces.iter().filter(|piece| piece.faces().len() >= MIN_FACES).filter_map(|piece| round(piece, options)).collect()
}

fn round(piece: &Mesh, options: &TestOptions) -> Option<RoundPiece> {
    let fitted = sample_surface(piece, FITTED_SAMPLES, options.seed);
    let (centroid, principal) = principal_axes(piece, &fitted);
    let tree = Bvh::new(piece);
    let surface = PartSurface::new(&[piece], vec![&tree]);
    let test = SymmetryTest::new(&surface, options);
    // For a fully round piece, a principal axis is exact. A pointer or a notch tilts it, but not the fitted axis. For a
    // thin disc, the fit determines only the direction.
    let (own_point, slipping) = axis_of_revolution(&fitted)?;
    let lines = principal.map(|axis| (centroid, axis)).into_iter().chain([(centroid, slipping), (own_point, slipping)]);
    let turned = lines.filter_map(|(point, axis)| Some((test.revolution_error(point, axis)?, point, axis)));
    let (_, point, direction) = turned.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let (mut low, mut high, mut radius) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
    for vertex in piece.vertices() {
        let offset = vertex - point;
        let along = offset.dot(&direction);
        (low, high) = (low.min(along), high.max(along));
        radius = radius.max((offset - direction * along).norm());
    }
    let middle = point + direction * (0.5 * (low + high));
    let is_ball = test.revolution_error(middle, any_perpendicular(direction)).is_some();
    (!is_ball).then_some(RoundPiece { middle, direction, radius, half_length: 0.5 * (high - low) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_shapes::{block, isometry, mapped, prism};
    use proptest::prelude::*;
    use std::f64::consts::{PI, TAU};

    const OPTIONS: TestOptions = TestOptions { samples: 100, tolerance: 0.02, seed: 1 };

    /// A ball of radius 1 around the origin.
    fn ball() -> Mesh {
        let (rings, sides) = (12u32, 24u32);
        let at = |ring: u32, side: u32| {
            let (tilt, turn) = (PI * ring as f64 / rings as f64, TAU * side as f64 / sides as f64);
            Point3::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos())
        };
        let vertices = (0..=rings).flat_map(|ring| (0..sides).map(move |side| at(ring, side))).collect();
        let quad = |ring: u32, side: u32| {
            let (a, b) = (ring * sides + side, ring * sides + (side + 1) % sides);
            [[a, a + sides, b], [b, a + sides, b + sides]]
        };
        let faces = (0..rings).flat_map(|ring| (0..sides).flat_map(move |side| quad(ring, side))).collect();
        Mesh::new(vertices, faces).expect("finite")
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// The pin of a hinge is the only round one of three pieces, in any orientation.
        #[test]
        fn a_pin_beside_blocks_is_found_with_its_line_and_size(
            sides in 16u32..40,
            radius in 0.05..0.3f64,
            length in 0.1..2.0f64,
            place in isometry(),
        ) {
            let pin = mapped(&prism(sides), |p| Point3::new(radius * p.x, radius * p.y, length * p.z / 3.0));
            let whole = Mesh::union([&block([1.0, -1.0, 0.0], [3.0, 1.0, 0.2]), &pin, &block([-3.0, -1.0, 0.0], [-1.0, 1.0, 0.5])]);
            let found = round_pieces(&mapped(&whole, |p| place * p), &OPTIONS);
            prop_assert_eq!(found.len(), 1);
            let RoundPiece { middle, direction, radius: reach, half_length } = found[0];
            prop_assert!((place * Vector3::z()).cross(&direction).norm() < 0.02);
            prop_assert!((place * Point3::new(0.0, 0.0, 0.5 * length) - middle).norm() < 0.02 * (length + radius));
            prop_assert!((reach - radius).abs() < 0.05 * (length + radius));
            prop_assert!((half_length - 0.5 * length).abs() < 0.05 * (length + radius));
        }
    }

    #[test]
    fn neither_blocks_nor_balls_are_round_about_a_line() {
        assert!(round_pieces(&block([0.0; 3], [1.0, 1.0, 3.0]), &OPTIONS).is_empty());
        assert!(round_pieces(&ball(), &OPTIONS).is_empty());
    }
}
