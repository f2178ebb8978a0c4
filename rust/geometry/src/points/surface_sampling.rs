//! Random and evenly spaced points on surfaces, uniform by area.

use rand::seq::SliceRandom;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::Mesh;
use crate::points::perpendicular::any_perpendicular;
use crate::points::sample_elimination::eliminate;
use crate::points::stratified_sampling::StratifiedSampler;
use crate::points::surface_sample::SurfaceSample;

/// Number of uniform samples per evenly spaced sample before elimination.
const OVERSAMPLING: usize = 5;

/// Samples of the surface, uniform by area and in random order, so that every prefix is uniform too.
///
/// The draws are stratified: the list of faces is divided into `count` pieces of equal area, with one sample in each. A
/// mesh without area is sampled along its edges by length. A mesh without length is sampled at its vertices.
pub fn sample_surface(mesh: &Mesh, count: usize, seed: u64) -> Vec<SurfaceSample> {
    let mut samples = Vec::with_capacity(count);
    visit_samples(mesh, count, seed, |sample| samples.push(sample));
    samples
}

/// Passes the samples of [`sample_surface`] to `visit` one by one.
pub fn visit_samples(mesh: &Mesh, count: usize, seed: u64, mut visit: impl FnMut(SurfaceSample)) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    match area_sampler(mesh, count) {
        Some(areas) => {
            for face in areas.draw_shuffled(count, &mut rng) {
                visit(sample_face(mesh, face, &mut rng));
            }
        }
        None => sample_without_area(mesh, count, &mut rng).into_iter().for_each(visit),
    }
}

/// Evenly spaced samples of the surface: the most crowded samples of a five times denser set are removed.
///
/// Source: Yuksel, Sample Elimination for Generating Poisson Disk Sample Sets, 2015.
pub fn sample_surface_evenly(mesh: &Mesh, count: usize, seed: u64) -> Vec<SurfaceSample> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let dense = count.saturating_mul(OVERSAMPLING);
    let Some(areas) = area_sampler(mesh, dense) else {
        return sample_without_area(mesh, count, &mut rng);
    };
    let drawn = areas.draw_shuffled(dense, &mut rng);
    let dense: Vec<_> = drawn.into_iter().map(|face| sample_face(mesh, face, &mut rng)).collect();
    let mut kept = eliminate(&dense, count, 0.5 * areas.total());
    kept.shuffle(&mut rng);
    kept
}

/// Sampler of faces by twice their area; `None` if the areas are within the rounding of the coordinates.
fn area_sampler(mesh: &Mesh, draws: usize) -> Option<StratifiedSampler<impl Fn(usize) -> f64>> {
    let sampler = StratifiedSampler::new(mesh.faces().len(), draws, |face| mesh.scaled_normal(face).norm());
    let (low, high) = mesh.bounds();
    let rounding = 4.0 * f64::EPSILON * low.coords.amax().max(high.coords.amax());
    (sampler.total() > rounding * (high - low).norm()).then_some(sampler)
}

/// A uniform point on a face. Two draws split the unit interval into its barycentric coordinates.
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

/// Samples of a line-like mesh along its edges, or of a point-like mesh at its vertices.
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
    let lengths = StratifiedSampler::new(edges, count, length);
    let drawn = if lengths.total() > 0.0 {
        lengths.draw_shuffled(count, rng)
    } else {
        StratifiedSampler::new(edges, count, |_| 1.0).draw_shuffled(count, rng)
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
    use crate::test_shapes::triangle_soup;
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
        fn samples_lie_on_the_faces_they_name(mesh in triangle_soup(7), count in 1usize..80, seed in any::<u64>()) {
            for samples in [sample_surface(&mesh, count, seed), sample_surface_evenly(&mesh, count, seed)] {
                prop_assert_eq!(samples.len(), count);
                for sample in &samples {
                    prop_assert!((sample.normal.norm() - 1.0).abs() < 1e-12);
                    prop_assert!(lies_on_its_face(&mesh, sample), "{:?}", sample);
                }
            }
        }

        /// The number of samples on a face deviates from its share by less than one at either end of its stratum range.
        #[test]
        fn every_face_gets_its_share_of_the_area(mesh in triangle_soup(5), seed in any::<u64>()) {
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
        fn a_seed_determines_the_samples(mesh in triangle_soup(4), seed in any::<u64>()) {
            prop_assert_eq!(sample_surface(&mesh, 30, seed), sample_surface(&mesh, 30, seed));
            prop_assert_eq!(sample_surface_evenly(&mesh, 30, seed), sample_surface_evenly(&mesh, 30, seed));
            prop_assert!(sample_surface(&mesh, 30, seed) != sample_surface(&mesh, 30, seed ^ 1));
        }
    }
}
