//! Pieces of a mesh that are round about a line: pins, barrels, axles, knobs.

use nalgebra::{Point3, Vector3};

use crate::Mesh;
use crate::bvh::Bvh;
use crate::pieces::connected_pieces;
use crate::rectangle::any_perpendicular;
use crate::revolution::axis_of_revolution;
use crate::sampling::sample_surface;
use crate::surface::Surface;
use crate::symmetry::{principal_axes, revolution_error};
use crate::symmetry_test::{SymmetryTest, TestOptions};

/// A piece that may be turned about a line by any angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundPiece {
    /// The point of the line half way between the ends of the piece.
    pub middle: Point3<f64>,
    /// Unit direction of the line.
    pub direction: Vector3<f64>,
    /// How far the piece reaches from the line.
    pub radius: f64,
    /// How far it reaches from the middle, along the line.
    pub half_length: f64,
}

/// A piece of fewer faces is not round: a prism of four sides has eight faces without its ends.
const FEWEST_FACES: usize = 9;

/// Samples from which the line is fitted.
const FITTED_SAMPLES: usize = 256;

/// The round pieces of a mesh, in the order of their first faces. Balls, which are round about any line, are none.
pub fn round_pieces(mesh: &Mesh, options: &TestOptions) -> Vec<RoundPiece> {
    let pieces = connected_pieces(mesh);
    pieces
        .iter()
        .filter(|piece| piece.faces().len() >= FEWEST_FACES)
        .filter_map(|piece| round(piece, options))
        .collect()
}

fn round(piece: &Mesh, options: &TestOptions) -> Option<RoundPiece> {
    let fitted = sample_surface(piece, FITTED_SAMPLES, options.seed);
    let (centroid, principal) = principal_axes(piece, &fitted);
    let tree = Bvh::new(piece);
    let surface = Surface::new(&[piece], vec![&tree]);
    let test = SymmetryTest::new(&surface, options);
    // The principal axes of what is round all along are exact; a pointer or a notch tilts them, but not the fitted line. Of a thin
    // disc the fit sees the direction alone.
    let (own_point, slipping) = axis_of_revolution(&fitted)?;
    let lines = principal.map(|axis| (centroid, axis)).into_iter().chain([(centroid, slipping), (own_point, slipping)]);
    let turned = lines.filter_map(|(point, axis)| Some((revolution_error(&test, point, axis)?, point, axis)));
    let (_, point, direction) = turned.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let (mut low, mut high, mut radius) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
    for vertex in piece.vertices() {
        let offset = vertex - point;
        let along = offset.dot(&direction);
        (low, high) = (low.min(along), high.max(along));
        radius = radius.max((offset - direction * along).norm());
    }
    let middle = point + direction * (0.5 * (low + high));
    let is_ball = revolution_error(&test, middle, any_perpendicular(direction)).is_some();
    (!is_ball).then_some(RoundPiece { middle, direction, radius, half_length: 0.5 * (high - low) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::soup::{block, isometry, mapped, prism};
    use proptest::prelude::*;
    use std::f64::consts::{PI, TAU};

    const OPTIONS: TestOptions = TestOptions { samples: 100, tolerance: 0.02, seed: 1 };

    /// A ball of radius 1 about the origin.
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

        /// The pin of a hinge, the only round one of three pieces, however all lie.
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
