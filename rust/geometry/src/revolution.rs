//! The axis that a surface of revolution turns about.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use crate::sampling::SurfaceSample;

/// Rounds of fitting, each without the samples that the last fit explains worst.
const ROUNDS: usize = 6;

/// Share of the samples that a fit is made from, after the first round.
const TRUSTED: f64 = 0.8;

/// The axis that the surface slides along itself about, as well as it can: a point of it and its unit direction.
///
/// A turn with angular velocity `w` and velocity `v` at the centroid moves sample `p` along its normal by `n·v + w·(p × n)`. The turn that
/// minimises the sum of squares is the smallest eigenvector of a 3 x 3 matrix (after Pottmann and Randrup, Rotational and
/// helical surface approximation, 1998; Gelfand and Guibas, Slippage analysis, 2004). The fit is repeated on the samples that agree
/// best with it, so that a pointer on a knob or a spout on a stem does not tilt the axis.
pub fn axis_of_revolution(samples: &[SurfaceSample]) -> Option<(Point3<f64>, Vector3<f64>)> {
    let mut trusted: Vec<&SurfaceSample> = samples.iter().collect();
    let mut axis = fit(&trusted)?;
    let count = (TRUSTED * samples.len() as f64).ceil() as usize;
    for _ in 0..ROUNDS {
        let residual = |sample: &SurfaceSample| {
            let (point, direction) = axis;
            direction.cross(&(sample.point - point)).dot(&sample.normal).abs()
        };
        trusted = samples.iter().collect();
        trusted.sort_by(|a, b| residual(a).total_cmp(&residual(b)));
        trusted.truncate(count);
        axis = fit(&trusted)?;
    }
    Some(axis)
}

fn fit(samples: &[&SurfaceSample]) -> Option<(Point3<f64>, Vector3<f64>)> {
    let first = samples.first()?.point;
    let mean = samples.iter().map(|s| s.point - first).sum::<Vector3<f64>>() / samples.len() as f64;
    let centroid = first + mean;
    let size = samples.iter().map(|s| (s.point - centroid).norm()).fold(0.0, f64::max);
    if size == 0.0 {
        return None;
    }
    let (mut turning, mut mixed, mut sliding) = (Matrix3::zeros(), Matrix3::zeros(), Matrix3::zeros());
    for sample in samples {
        let moment = ((sample.point - centroid) / size).cross(&sample.normal);
        turning += moment * moment.transpose();
        mixed += moment * sample.normal.transpose();
        sliding += sample.normal * sample.normal.transpose();
    }
    // The velocity that serves a given turn best follows from it; directions in which the surface slides freely get none.
    let freely = 1e-6 * samples.len() as f64;
    let velocity_of_turn = sliding.pseudo_inverse(freely).ok()? * mixed.transpose();
    let eigen = SymmetricEigen::new(turning - mixed * velocity_of_turn);
    let direction = eigen.eigenvectors.column(eigen.eigenvalues.imin()).normalize();
    let velocity = -(velocity_of_turn * direction);
    let point = centroid + direction.cross(&velocity) * size;
    Some((point, direction))
}
