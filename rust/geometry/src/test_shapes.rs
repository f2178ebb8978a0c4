//! Random and regular meshes for tests.

use std::f64::consts::TAU;

use nalgebra::{IsometryMatrix3, Point3, Rotation3, Vector3};
use proptest::prelude::*;

use crate::Mesh;

/// Triangle soup: `faces` random triangles in [-1, 1]^3.
pub fn triangle_soup(faces: usize) -> impl Strategy<Value = Mesh> {
    prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 3 * faces).prop_map(move |corners| {
        let faces = (0..faces as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        Mesh::new(corners.into_iter().map(Point3::from).collect(), faces).expect("finite")
    })
}

/// A random rotation followed by a random translation.
pub fn isometry() -> impl Strategy<Value = IsometryMatrix3<f64>> {
    let vector = || prop::array::uniform3(-3.0..3.0f64).prop_map(Vector3::from);
    (vector(), vector()).prop_map(|(turn, shift)| IsometryMatrix3::from_parts(shift.into(), Rotation3::new(turn)))
}

/// The mesh with every vertex mapped.
pub fn mapped(mesh: &Mesh, map: impl Fn(&Point3<f64>) -> Point3<f64>) -> Mesh {
    Mesh::new(mesh.vertices().iter().map(map).collect(), mesh.faces().to_vec()).expect("finite")
}

/// An axis-aligned block. Its faces are counter-clockwise seen from outside.
pub fn block(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let corner = |i: usize| Point3::from([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] }));
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let faces = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh::new((0..8).map(corner).collect(), faces).expect("finite")
}

/// A regular prism around the z axis, of radius 1, from z = 0 to 3.
pub fn prism(sides: u32) -> Mesh {
    let corner = |i: u32, z: f64| {
        let angle = TAU * i as f64 / sides as f64;
        Point3::new(angle.cos(), angle.sin(), z)
    };
    let vertices = (0..sides).flat_map(|i| [corner(i, 0.0), corner(i, 3.0)]).collect();
    let side = |i: u32| {
        let (a, b) = (2 * i, 2 * ((i + 1) % sides));
        [[a, b, a + 1], [b, b + 1, a + 1]]
    };
    let caps = |i: u32| [[0, 2 * i + 2, 2 * i], [1, 2 * i + 1, 2 * i + 3]];
    let faces = (0..sides).flat_map(side).chain((1..sides - 1).flat_map(caps)).collect();
    Mesh::new(vertices, faces).expect("a valid mesh")
}
