//! Points on surfaces, uniform by area.

use nalgebra::{Point3, Vector3};
use rand::seq::SliceRandom;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::Mesh;
use crate::rectangle::any_perpendicular;
use crate::sample_elimination::eliminate;
use crate::strata::Strata;

/// Blue noise is thinned from this many times as many uniform samples.
const OVERSAMPLING: usize = 5;

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSample {
    /// Position.
    pub point: Point3<f64>,
    /// Unit normal of the face; of a mesh without area, a unit vector perpendicular to the edge.
    pub normal: Vector3<f64>,
    /// Index of the face.
    pub face: u32,
}

/// `count` samples of the surface, uniform by area, in random order: every prefix is uniform too.
///
/// The draws are stratified: the surface, its faces strung in a row, is cut into `count` pieces of equal area, with one sample
/// in each. A mesh without area is sampled along its edges by length, and one without length at its vertices.
pub fn sample_surface(mesh: &Mesh, count: usize, seed: u64) -> Vec<SurfaceSample> {
    let mut samples = Vec::with_capacity(count);
    visit_samples(mesh, count, seed, |sample| samples.push(sample));
    samples
}

/// As [`sample_surface`], handing the samples to `visit` one by one.
pub fn visit_samples(mesh: &Mesh, count: usize, seed: u64, mut visit: impl FnMut(SurfaceSample)) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    match area_strata(mesh, count) {
        Some(areas) => {
            for face in areas.draw_shuffled(count, &mut rng) {
                visit(sample_face(mesh, face, &mut rng));
            }
        }
        None => sample_without_area(mesh, count, &mut rng).into_iter().for_each(visit),
    }
}

/// As [`sample_surface`], but evenly spaced: samples are removed from a five times denser set, the most crowded first.
///
/// Yuksel, Sample Elimination for Generating Poisson Disk Sample Sets, 2015.
pub fn sample_surface_evenly(mesh: &Mesh, count: usize, seed: u64) -> Vec<SurfaceSample> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let dense = count.saturating_mul(OVERSAMPLING);
    let Some(areas) = area_strata(mesh, dense) else {
        return sample_without_area(mesh, count, &mut rng);
    };
    let drawn = areas.draw_shuffled(dense, &mut rng);
    let dense: Vec<_> = drawn.into_iter().map(|face| sample_face(mesh, face, &mut rng)).collect();
    let mut kept = eliminate(&dense, count, 0.5 * areas.total());
    kept.shuffle(&mut rng);
    kept
}

/// The faces as strata by twice their area, unless their areas are no more than the rounding of the coordinates.
fn area_strata(mesh: &Mesh, draws: usize) -> Option<Strata<impl Fn(usize) -> f64>> {
    let strata = Strata::new(mesh.faces().len(), draws, |face| mesh.scaled_normal(face).norm());
    let (low, high) = mesh.bounds();
    let rounding = 4.0 * f64::EPSILON * low.coords.amax().max(high.coords.amax());
    (strata.total() > rounding * (high - low).norm()).then_some(strata)
}

/// A point of the face, uniform: two draws cut the unit interval into its barycentric coordinates.
#[inline]
fn sample_face(mesh: &Mesh, face: u32, rng: &mut ChaCha8Rng) -> SurfaceSample {
    const UNIT: f64 = 1.0 / (1u64 << 32) as f64;
    let bits = rng.next_u64();
    let (s, t) = ((bits >> 32) as f64 * UNIT, (bits & 0xffff_ffff) as f64 * UNIT);
    let (u, v) = (s.min(t), (s - t).abs());
    let [a, b, c] = mesh.triangle(face as usize);
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(&ac);
    SurfaceSample { point: a + ab * u + ac * v, normal: normal * normal.norm().recip(), face }
}

/// Samples of a line-like mesh along its edges, and of a point-like one at its vertices.
fn sample_without_area(mesh: &Mesh, count: usize, rng: &mut ChaCha8Rng) -> Vec<SurfaceSample> {
    let edge = |index: usize| {
        let corners = mesh.triangle(index / 3);
        (corners[index % 3], corners[(index + 1) % 3])
    };
    let edges = 3 * mesh.faces().len();
    let length = |index: usize| {
        let (a, b) = edge(index);
        (b - a).norm()
    };
    let lengths = Strata::new(edges, count, length);
    let drawn = if lengths.total() > 0.0 {
        lengths.draw_shuffled(count, rng)
    } else {
        Strata::new(edges, count, |_| 1.0).draw_shuffled(count, rng)
    };
    let sample = |index: u32| {
        let (a, b) = edge(index as usize);
        let point = a + (b - a) * rng.random::<f64>();
        SurfaceSample { point, normal: any_perpendicular(b - a), face: index / 3 }
    };
    drawn.into_iter().map(sample).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::soup::soup;
    use proptest::prelude::*;

    fn lies_on_its_face(mesh: &Mesh, sample: &SurfaceSample) -> bool {
        let corners = mesh.triangle(sample.face as usize);
        let sides = [0, 1, 2].map(|i| (corners[(i + 1) % 3] - corners[i]).cross(&(sample.point - corners[i])));
        let whole = mesh.scaled_normal(sample.face as usize);
        let inside = sides.iter().all(|side| side.dot(&whole) >= -1e-9 * whole.norm_squared());
        inside && (sample.point - corners[0]).dot(&sample.normal).abs() < 1e-9
    }

    proptest! {
        #[test]
        fn samples_lie_on_the_faces_they_name(mesh in soup(7), count in 1usize..80, seed in any::<u64>()) {
            for samples in [sample_surface(&mesh, count, seed), sample_surface_evenly(&mesh, count, seed)] {
                prop_assert_eq!(samples.len(), count);
                for sample in &samples {
                    prop_assert!((sample.normal.norm() - 1.0).abs() < 1e-12);
                    prop_assert!(lies_on_its_face(&mesh, sample), "{:?}", sample);
                }
            }
        }

        /// No face is off its share by a sample or more at either end of its stretch.
        #[test]
        fn every_face_gets_its_share_of_the_area(mesh in soup(5), seed in any::<u64>()) {
            let count = 2000;
            let areas = mesh.face_areas();
            let total: f64 = areas.iter().sum();
            let mut drawn = vec![0usize; areas.len()];
            for sample in sample_surface(&mesh, count, seed) {
                drawn[sample.face as usize] += 1;
            }
            for (number, area) in drawn.iter().zip(&areas) {
                prop_assert!((*number as f64 - area / total * count as f64).abs() <= 2.0, "{drawn:?} {areas:?}");
            }
        }

        #[test]
        fn a_seed_decides_the_samples(mesh in soup(4), seed in any::<u64>()) {
            prop_assert_eq!(sample_surface(&mesh, 30, seed), sample_surface(&mesh, 30, seed));
            prop_assert_eq!(sample_surface_evenly(&mesh, 30, seed), sample_surface_evenly(&mesh, 30, seed));
            prop_assert!(sample_surface(&mesh, 30, seed) != sample_surface(&mesh, 30, seed ^ 1));
        }
    }
}
