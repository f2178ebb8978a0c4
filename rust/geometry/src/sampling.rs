//! Points on surfaces, uniform by area.

use nalgebra::{Point3, Vector3};
use rand::seq::SliceRandom;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::Mesh;
use crate::sample_elimination::eliminate;

/// Blue noise is thinned from this many times as many uniform samples.
const OVERSAMPLING: usize = 5;

/// Faces whose weights are summed at once, so that the search for a sample's face skips most of them.
const BLOCK: usize = 32;

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
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    match Weights::by_area(mesh) {
        Some(areas) => draw_from_faces(mesh, &areas, count, &mut rng),
        None => draw_without_area(mesh, count, &mut rng),
    }
}

/// As [`sample_surface`], but evenly spaced: samples are removed from a five times denser set, the most crowded first.
///
/// Yuksel, Sample Elimination for Generating Poisson Disk Sample Sets, 2015.
pub fn sample_surface_evenly(mesh: &Mesh, count: usize, seed: u64) -> Vec<SurfaceSample> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let Some(areas) = Weights::by_area(mesh) else {
        return draw_without_area(mesh, count, &mut rng);
    };
    let dense = draw_from_faces(mesh, &areas, count.saturating_mul(OVERSAMPLING), &mut rng);
    let mut kept = eliminate(&dense, count, areas.total);
    kept.shuffle(&mut rng);
    kept
}

/// What the elements of a mesh weigh, with the sums of blocks of them.
struct Weights {
    single: Vec<f64>,
    blocks: Vec<f64>,
    total: f64,
}

impl Weights {
    fn new(single: Vec<f64>) -> Self {
        let blocks: Vec<f64> = single.chunks(BLOCK).map(|block| block.iter().sum()).collect();
        let total = blocks.iter().sum();
        Self { single, blocks, total }
    }

    /// Areas of the faces, unless they are no more than the rounding of the coordinates.
    fn by_area(mesh: &Mesh) -> Option<Self> {
        let areas = Self::new(mesh.face_areas());
        let (low, high) = mesh.bounds();
        let rounding = 4.0 * f64::EPSILON * low.coords.abs().max().max(high.coords.abs().max());
        (areas.total > rounding * (high - low).norm()).then_some(areas)
    }

    /// One element from each of `count` equal pieces of the total weight, in ascending order.
    fn draw_stratified(&self, count: usize, rng: &mut impl Rng) -> Vec<u32> {
        let last = self.single.iter().rposition(|&weight| weight > 0.0).unwrap_or(0);
        let step = self.total / count as f64;
        let (mut block, mut before_block) = (0, 0.0);
        (0..count)
            .map(|stratum| {
                let target = (stratum as f64 + rng.random::<f64>()) * step;
                while block + 1 < self.blocks.len() && before_block + self.blocks[block] <= target {
                    before_block += self.blocks[block];
                    block += 1;
                }
                let first = block * BLOCK;
                let mut sum = before_block;
                let members = &self.single[first..self.single.len().min(first + BLOCK)];
                let within = members.iter().position(|weight| {
                    sum += weight;
                    sum > target
                });
                // Sums taken in another order may fall short of the target by a rounding error.
                let fallback = || members.iter().rposition(|&weight| weight > 0.0).map_or(last, |i| first + i);
                within.map_or_else(fallback, |i| first + i) as u32
            })
            .collect()
    }
}

fn draw_from_faces(mesh: &Mesh, areas: &Weights, count: usize, rng: &mut impl Rng) -> Vec<SurfaceSample> {
    let mut faces = areas.draw_stratified(count, rng);
    faces.shuffle(rng);
    faces.into_iter().map(|face| sample_face(mesh, face, rng)).collect()
}

fn sample_face(mesh: &Mesh, face: u32, rng: &mut impl Rng) -> SurfaceSample {
    const UNIT: f64 = 1.0 / (1u64 << 32) as f64;
    let bits = rng.next_u64();
    let (mut u, mut v) = ((bits >> 32) as f64 * UNIT, (bits & 0xffff_ffff) as f64 * UNIT);
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    let [a, b, c] = mesh.triangle(face as usize);
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(&ac);
    SurfaceSample { point: a + ab * u + ac * v, normal: normal / normal.norm(), face }
}

/// Samples of a line-like mesh along its edges, and of a point-like one at its vertices.
fn draw_without_area(mesh: &Mesh, count: usize, rng: &mut impl Rng) -> Vec<SurfaceSample> {
    let edges: Vec<_> = (0..mesh.faces().len())
        .flat_map(|face| {
            let [a, b, c] = mesh.triangle(face);
            [(face, a, b), (face, b, c), (face, c, a)]
        })
        .collect();
    let mut lengths = Weights::new(edges.iter().map(|(_, a, b)| (b - a).norm()).collect());
    if lengths.total == 0.0 {
        lengths = Weights::new(vec![1.0; edges.len()]);
    }
    let mut drawn = lengths.draw_stratified(count, rng);
    drawn.shuffle(rng);
    let sample = |edge: u32| {
        let (face, a, b) = edges[edge as usize];
        SurfaceSample { point: a + (b - a) * rng.random::<f64>(), normal: any_perpendicular(b - a), face: face as u32 }
    };
    drawn.into_iter().map(sample).collect()
}

/// Some unit vector perpendicular to `direction`, which may be zero.
fn any_perpendicular(direction: Vector3<f64>) -> Vector3<f64> {
    let mut least_aligned = Vector3::zeros();
    least_aligned[direction.iamin()] = 1.0;
    direction.cross(&least_aligned).try_normalize(0.0).unwrap_or(Vector3::z())
}
