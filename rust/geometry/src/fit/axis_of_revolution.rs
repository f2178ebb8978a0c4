//! Axis of a surface of revolution.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use crate::points::surface_sample::SurfaceSample;

/// Number of fitting rounds. Each omits the samples that the last fit explains worst.
const ROUNDS: usize = 5;

/// Share of the samples that are fitted after the first round.
const TRUSTED: f64 = 0.8;

type Line = (Point3<f64>, Vector3<f64>);

/// Axis about which a surface slides along itself best: a point on the axis and its unit direction.
///
/// A rotation with angular velocity `w` and velocity `v` at the centroid moves sample `p` along its normal by `n·v +
/// w·(p × n)`. The rotations with a stationary sum of squares are the eigenvectors of a 3 x 3 matrix. From each of
/// them, the fit is repeated on the samples that agree best. A pointer on a knob or a spout on a stem therefore does
/// not tilt the axis.
///
/// Returns `None` if the samples have no extent.
///
/// Sources: Pottmann and Randrup, Rotational and helical surface approximation, 1998; Gelfand and Guibas, Slippage
/// analysis, 2004.
pub fn axis_of_revolution(samples: &[SurfaceSample]) -> Option<Line> {
    let trusted = (TRUSTED * samples.len() as f64).ceil() as usize;
    let mut ranked: Vec<(f64, SurfaceSample)> = samples.iter().map(|sample| (0.0, *sample)).collect();
    let mut best: Option<(f64, Line)> = None;
    for start in stationary_turns(&ranked)? {
        let mut axis = start;
        for _ in 0..ROUNDS {
            rank_by_slip(&mut ranked, axis, trusted);
            axis = stationary_turns(&ranked[..trusted])?[0];
        }
        rank_by_slip(&mut ranked, axis, trusted);
        let slip = ranked[..trusted].iter().map(|(slip, _)| slip * slip).sum();
        if best.is_none_or(|(least, _)| slip < least) {
            best = Some((slip, axis));
        }
    }
    best.map(|(_, axis)| axis)
}

/// Moves the `trusted` samples with the smallest slip to the front: those that a rotation about `axis` moves least
/// along their normals.
fn rank_by_slip(ranked: &mut [(f64, SurfaceSample)], (point, direction): Line, trusted: usize) {
    for (slip, sample) in ranked.iter_mut() {
        *slip = direction.cross(&(sample.point - point)).dot(&sample.normal).abs();
    }
    if trusted < ranked.len() {
        ranked.select_nth_unstable_by(trusted, |a, b| a.0.total_cmp(&b.0));
    }
}

/// Axes of the rotations with a stationary sum of squared slips, by ascending sum.
fn stationary_turns(ranked: &[(f64, SurfaceSample)]) -> Option<[Line; 3]> {
    let (_, SurfaceSample { point: first, .. }) = ranked.first()?;
    let mean = ranked.iter().map(|(_, s)| s.point - first).sum::<Vector3<f64>>() / ranked.len() as f64;
    let centroid = first + mean;
    let size = ranked.iter().map(|(_, s)| (s.point - centroid).norm()).fold(0.0, f64::max);
    if size == 0.0 {
        return None;
    }
    let (mut turning, mut mixed, mut sliding) = (Matrix3::zeros(), Matrix3::zeros(), Matrix3::zeros());
    for (_, sample) in ranked {
        let moment = ((sample.point - centroid) / size).cross(&sample.normal);
        turning += moment * moment.transpose();
        mixed += moment * sample.normal.transpose();
        sliding += sample.normal * sample.normal.transpose();
    }
    // The best velocity follows from the rotation. Directions in which the surface slides freely get no velocity.
    let freely = 1e-6 * ranked.len() as f64;
    let velocity_of_turn = sliding.pseudo_inverse(freely).ok()? * mixed.transpose();
    let eigen = SymmetricEigen::new(turning - mixed * velocity_of_turn);
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    Some(order.map(|i| {
        let direction = eigen.eigenvectors.column(i).normalize();
        let velocity = -(velocity_of_turn * direction);
        (centroid + direction.cross(&velocity) * size, direction)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Unit};
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    /// Samples of a cone frustum, with some clutter beside it.
    fn frustum(count: usize, clutter: usize) -> Vec<SurfaceSample> {
        let on_side = |i: usize| {
            let (angle, height) = (TAU * 0.618 * i as f64, (i as f64 * 0.754).fract() * 3.0);
            let outward = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let point = Point3::from(outward * (1.0 + 0.2 * height) + Vector3::z() * height);
            SurfaceSample { point, normal: (outward - Vector3::z() * 0.2).normalize(), face: 0 }
        };
        let beside = |i: usize| SurfaceSample {
            point: Point3::new(2.0 + (i as f64 * 0.31).fract(), 0.2, 1.0 + (i as f64 * 0.57).fract()),
            normal: Vector3::y(),
            face: 1,
        };
        (0..count).map(on_side).chain((0..clutter).map(beside)).collect()
    }

    proptest! {
        #[test]
        fn the_axis_of_a_frustum_is_found_despite_clutter(
            axis in prop::array::uniform3(-1.0..1.0f64),
            angle in 0.0..TAU,
            shift in prop::array::uniform3(-10.0..10.0f64),
            scale in 1e-3..1e3f64,
        ) {
            let Some(axis) = Unit::try_new(Vector3::from(axis), 0.1) else { return Ok(()) };
            let turn = Rotation3::from_axis_angle(&axis, angle);
            let place = |p: Point3<f64>| Point3::from((turn * p).coords * scale + Vector3::from(shift));
            let samples: Vec<_> = frustum(400, 40)
                .into_iter()
                .map(|s| SurfaceSample { point: place(s.point), normal: turn * s.normal, ..s })
                .collect();
            let (point, direction) = axis_of_revolution(&samples).expect("the samples have an extent");
            prop_assert!((turn * Vector3::z()).cross(&direction).norm() < 1e-3);
            prop_assert!((place(Point3::origin()) - point).cross(&direction).norm() < 1e-2 * scale);
        }
    }
}
