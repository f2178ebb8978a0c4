//! Principal axes of a surface.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use crate::Mesh;
use crate::points::surface_sample::SurfaceSample;

/// Centroid and principal axes of a surface. For a part without area, those of its samples.
pub(crate) fn principal_axes(mesh: &Mesh, samples: &[SurfaceSample]) -> (Point3<f64>, [Vector3<f64>; 3]) {
    // The integral of a quadratic function over a triangle is a sum over the midpoints of its sides.
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
