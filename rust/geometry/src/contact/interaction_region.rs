//! Interaction region of two parts, by the interaction bisector surface (IBS) of Hu et al. 2015.
//!
//! The IBS comes from the Voronoi diagram of the samples of both parts and of points on a sphere around them. It
//! consists of the ridges that separate samples of different parts. A ridge is divided into the triangles between its
//! mean corner and its edges. Each triangle adds this score to both samples of its ridge, or 0 where a factor is
//! negative:
//!
//! `area * (1 - d / (D / 2))^20 * (1 - alpha / (pi / 3))`
//!
//! * `D` is the diagonal of the box of all samples.
//! * `d` is the distance from the triangle's centroid to the two samples.
//! * `alpha` is the angle at the centroid between the ridge's normal and the direction to a sample.
//!
//! The score of a sample is the sum over its triangles. The region consists of the samples with a score. Its centroid
//! is the mean of the moving part's samples, weighted by score.
//!
//! The power makes all but the nearest ridges vanish, so the Delaunay diagram covers only samples near the other part.
//! The ridge of two samples has one corner per tetrahedron in the ring around their edge.

use std::f64::consts::{FRAC_PI_3, PI};
use std::sync::LazyLock;

use nalgebra::{Point3, Vector3};

use crate::points::delaunay::{Delaunay, HULL_POINTS};
use crate::points::kd_tree::{KdTree, Neighbour};

/// Radius of the bounding sphere in diagonals, and its numbers of latitudes and longitudes.
const SPHERE_RADIUS: f64 = 2.0 / 3.0;
const SPHERE_GRID: [usize; 2] = [20, 40];
/// Gap, in diagonals, below which a coarse sphere suffices. It then only bounds ridges with a negligible score.
const SPHERE_MATTERS_FROM: f64 = 0.05;
const COARSE_SPHERE_GRID: [usize; 2] = [4, 8];
/// Exponent of the nearness weight.
const NEARNESS_POWER: i32 = 20;
/// Smallest base of the nearness weight, as a share of the base of the nearest pair. Ridges below it are omitted.
const NEGLIGIBLE_NEARNESS: f64 = 0.8;
/// Largest gap of parts in contact, in diagonals.
const CONTACT_SHARE: f64 = 0.01;
/// Corners of the edges of a tetrahedron.
const EDGES: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
/// Number of nearest cross pairs per part that define the centroid if no sample has a score.
const FALLBACK_PAIRS: usize = 10;

/// Interaction region of a moving part and a reference part.
#[derive(Debug, Clone, PartialEq)]
pub struct InteractionRegion {
    /// Mean of the moving part's samples, weighted by score.
    pub centroid: Point3<f64>,
    /// True if a sample of the moving part has a score. If not, the centroid is the mean of the nearest cross pairs.
    pub scored: bool,
    /// True if the nearest samples of the two parts are within a hundredth of the diagonal.
    pub touching: bool,
    /// Samples with a positive score, by ascending index, each with its score.
    ///
    /// The moving part's samples come first, then the reference part's. Scores are areas over the squared diagonal, so
    /// they do not depend on scale.
    pub samples: Vec<(u32, f64)>,
}

/// Interaction region of the samples of two parts, in the frame of the samples. Neither list may be empty.
pub fn interaction_region(moving: &[Point3<f64>], reference: &[Point3<f64>]) -> InteractionRegion {
    let pair = SamplePair::new(moving, reference);
    let mut scores = vec![0.0; pair.samples.len()];
    pair.add_scores(&mut scores);
    let samples: Vec<(u32, f64)> = (0..).zip(scores).filter(|&(_, score)| score > 0.0).collect();

    let mut sum = (Vector3::zeros(), 0.0);
    for &(sample, score) in samples.iter().take_while(|&&(sample, _)| (sample as usize) < pair.split) {
        sum = (sum.0 + pair.samples[sample as usize].coords * score, sum.1 + score);
    }
    let scored = sum.1 > 0.0;
    let centroid = if scored { Point3::from(sum.0 / sum.1) } else { pair.mean_of_nearest_pairs() };
    InteractionRegion {
        centroid: pair.center + centroid.coords * pair.diagonal,
        scored,
        touching: pair.gap <= CONTACT_SHARE,
        samples,
    }
}

/// Samples of two parts, centered and in units of the diagonal, with k-d trees.
struct SamplePair {
    /// Samples of the moving part, then of the reference part.
    samples: Vec<Point3<f64>>,
    split: usize,
    center: Point3<f64>,
    diagonal: f64,
    /// k-d trees of the moving part's samples and of the reference part's.
    trees: [KdTree; 2],
    /// Distance between the nearest samples of the two parts.
    gap: f64,
}

impl SamplePair {
    fn new(moving: &[Point3<f64>], reference: &[Point3<f64>]) -> Self {
        let all = || moving.iter().chain(reference);
        let (low, high) = all().fold((moving[0], moving[0]), |(low, high), p| (low.inf(p), high.sup(p)));
        let center = nalgebra::center(&low, &high);
        let length = (high - low).norm();
        let diagonal = if length > 0.0 { length } else { 1.0 };
        let samples: Vec<Point3<f64>> = all().map(|p| Point3::from((p - center) / diagonal)).collect();
        let split = moving.len();
        let (first, second) = samples.split_at(split);
        let trees = [KdTree::new(first), KdTree::new(second)];
        let gap = trees[0].squared_gap(&trees[1]).sqrt();
        Self { samples, split, center, diagonal, trees, gap }
    }

    /// Samples within `distance` of the other part.
    fn near(&self, distance: f64) -> Vec<u32> {
        let [moving, reference] = &self.trees;
        let mut near = reference.any_within(moving, distance * distance);
        near.extend(moving.any_within(reference, distance * distance));
        (0..).zip(near).filter(|&(_, near)| near).map(|(sample, _)| sample).collect()
    }

    fn add_scores(&self, scores: &mut [f64]) {
        let reach = reach(self.gap);
        let order = insertion_order(&self.samples, self.near(2.0 * reach));
        let mut diagram = if self.gap < SPHERE_MATTERS_FROM { COARSE_SPHERE.clone() } else { SPHERE.clone() };
        let first = diagram.next_number();
        diagram.extend(order.iter().map(|&sample| self.samples[sample as usize]));
        let sample_of = |corner: u32| order[(corner - first) as usize] as usize;
        let is_moving = |corner: u32| sample_of(corner) < self.split;
        let mut ring = Vec::new();
        let mut vertices = Vec::new();
        for start in diagram.tetrahedra() {
            let corners = diagram.corners(start);
            for (i, j) in EDGES {
                let edge = [corners[i], corners[j]];
                if edge[0].min(edge[1]) < first || is_moving(edge[0]) == is_moving(edge[1]) {
                    continue;
                }
                let across = diagram.point(edge[1]) - diagram.point(edge[0]);
                if across.norm_squared() >= 4.0 * reach * reach || !diagram.ring(start, edge, &mut ring) {
                    continue;
                }
                let bounded = |&t: &u32| diagram.corners(t).iter().all(|&corner| corner >= HULL_POINTS);
                if !ring.iter().all(bounded) {
                    continue;
                }
                let middle = diagram.point(edge[0]) + across * 0.5;
                vertices.clear();
                vertices.extend(ring.iter().map(|&t| diagram.circumcenter(t) - middle));
                let score = ridge_score(&vertices, 0.25 * across.norm_squared());
                for corner in edge {
                    scores[sample_of(corner)] += score;
                }
            }
        }
    }

    /// Mean of the points of the nearest cross pairs.
    fn mean_of_nearest_pairs(&self) -> Point3<f64> {
        let mut sum = (Vector3::zeros(), 0.0);
        let (first, second) = self.samples.split_at(self.split);
        let [moving, reference] = &self.trees;
        for (own, other, partners) in
            [(first, second, reference.nearest_of_each(moving)), (second, first, moving.nearest_of_each(reference))]
        {
            let mut pairs: Vec<(&Point3<f64>, Neighbour)> = own.iter().zip(partners).collect();
            pairs.sort_by(|a, b| a.1.squared.total_cmp(&b.1.squared));
            for (sample, partner) in pairs.into_iter().take(FALLBACK_PAIRS) {
                sum = (sum.0 + sample.coords + other[partner.point as usize].coords, sum.1 + 2.0);
            }
        }
        Point3::from(sum.0 / sum.1)
    }
}

/// Largest distance from a ridge to its samples at which the ridge still counts, for parts that are `gap` apart.
fn reach(gap: f64) -> f64 {
    0.5 - NEGLIGIBLE_NEARNESS * (0.5 - 0.5 * gap).max(0.0)
}

/// Diagram of the bounding sphere. All scenes share it, because they are centered and have a unit diagonal.
static SPHERE: LazyLock<Delaunay> = LazyLock::new(|| sphere(SPHERE_GRID));
static COARSE_SPHERE: LazyLock<Delaunay> = LazyLock::new(|| sphere(COARSE_SPHERE_GRID));

fn sphere([latitudes, longitudes]: [usize; 2]) -> Delaunay {
    let mut diagram = Delaunay::new();
    diagram.extend((0..latitudes).flat_map(|row| {
        let (sin, cos) = (PI * (row as f64 + 0.5) / latitudes as f64).sin_cos();
        (0..longitudes).map(move |column| {
            let azimuth = 2.0 * PI * column as f64 / longitudes as f64;
            Point3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos) * SPHERE_RADIUS
        })
    }));
    diagram
}

/// Insertion order of the samples `chosen`: rounds of doubling size, in which neighbours follow each other (Morton
/// order).
fn insertion_order(samples: &[Point3<f64>], mut chosen: Vec<u32>) -> Vec<u32> {
    let key = |sample: u32| -> u64 {
        let cell = samples[sample as usize].coords.map(|x| ((x + 0.5) * 1023.0) as u64);
        let hash = (u64::from(sample) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32;
        let round = 6 - u64::from((hash as u32).leading_zeros().min(6));
        (round << 32) | (spread_bits(cell.x) << 2) | (spread_bits(cell.y) << 1) | spread_bits(cell.z)
    };
    chosen.sort_by_cached_key(|&sample| key(sample));
    chosen
}

/// The ten lowest bits, with two zeros before each.
fn spread_bits(value: u64) -> u64 {
    (0..10).fold(0, |bits, i| bits | ((value >> i & 1) << (3 * i)))
}

/// Score of a ridge. Its vertices are in order and relative to the middle of its two samples.
///
/// The samples are the square root of `squared_height` away from the middle.
fn ridge_score(vertices: &[Vector3<f64>], squared_height: f64) -> f64 {
    let mean = vertices.iter().sum::<Vector3<f64>>() / vertices.len() as f64;
    let mut total = 0.0;
    let mut from = vertices[vertices.len() - 1];
    for &to in vertices {
        let squared_radius = ((from + to + mean) / 3.0).norm_squared();
        // The weight is zero at alpha = pi / 3.
        if squared_radius < 3.0 * squared_height {
            let area = 0.5 * (from - mean).cross(&(to - mean)).norm();
            let nearness = (1.0 - 2.0 * (squared_height + squared_radius).sqrt()).max(0.0).powi(NEARNESS_POWER);
            let alpha = (squared_radius / squared_height).sqrt().atan();
            total += area * nearness * (1.0 - alpha / FRAC_PI_3);
        }
        from = to;
    }
    total
}

#[cfg(test)]
mod tests {
    use nalgebra::{IsometryMatrix3, Rotation3};
    use proptest::prelude::*;

    use super::*;

    /// Samples of a board, and of a second board at distance `gap` in front of it.
    fn boards() -> impl Strategy<Value = (Vec<Point3<f64>>, Vec<Point3<f64>>, f64)> {
        let board = |count| prop::collection::vec(prop::array::uniform3(0.0..1.0f64), count);
        (board(60), board(90), 0.02..0.3f64).prop_map(|(moving, reference, gap)| {
            let place = |p: &[f64; 3]| Point3::new(p[0], p[1], 0.05 * p[2]);
            let before = |p: &[f64; 3]| place(p) + Vector3::new(0.4, 0.3, 0.05 + gap);
            (moving.iter().map(before).collect(), reference.iter().map(place).collect(), gap)
        })
    }

    fn distance(a: &InteractionRegion, b: &InteractionRegion) -> f64 {
        (a.centroid - b.centroid).norm()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn the_scores_are_symmetric_in_the_parts((moving, reference, _) in boards()) {
            let forth = interaction_region(&moving, &reference);
            let back = interaction_region(&reference, &moving);
            prop_assert_eq!(forth.touching, back.touching);
            let mut scores = vec![0.0; moving.len() + reference.len()];
            forth.samples.iter().for_each(|&(sample, score)| scores[sample as usize] = score);
            let total: f64 = scores.iter().sum();
            for &(sample, score) in &back.samples {
                let own = (sample as usize + moving.len()) % scores.len();
                scores[own] -= score;
            }
            // The two diagrams differ in the order of insertion and hence in the jitter.
            prop_assert!(scores.iter().map(|difference| difference.abs()).sum::<f64>() < 1e-3 * total);
        }

        #[test]
        fn regions_scale_and_rotate_with_the_parts((moving, reference, _) in boards(), exponent in -30i32..30) {
            let found = interaction_region(&moving, &reference);
            let map = |points: &[Point3<f64>], f: &dyn Fn(&Point3<f64>) -> Point3<f64>| points.iter().map(f).collect::<Vec<_>>();
            let scale = 2f64.powi(exponent);
            let scaled = |p: &Point3<f64>| p * scale;
            let larger = interaction_region(&map(&moving, &scaled), &map(&reference, &scaled));
            prop_assert_eq!(larger.centroid / scale, found.centroid);
            prop_assert_eq!(larger.samples, found.samples.clone());
            // Quarter turns keep the box of all samples. The sphere around it is oriented differently, which matters
            // little.
            let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.5 * PI) * Rotation3::from_axis_angle(&Vector3::z_axis(), PI);
            let motion = IsometryMatrix3::from_parts(Vector3::new(5.0, -3.0, 2.0).into(), turn);
            let moved = |p: &Point3<f64>| motion * p;
            let mut turned = interaction_region(&map(&moving, &moved), &map(&reference, &moved));
            turned.centroid = motion.inverse() * turned.centroid;
            prop_assert!(distance(&turned, &found) < 0.02, "{}", distance(&turned, &found));
        }

        #[test]
        fn only_samples_near_the_other_part_score((moving, reference, gap) in boards()) {
            let region = interaction_region(&moving, &reference);
            prop_assert!(region.scored && !region.samples.is_empty());
            let all: Vec<Point3<f64>> = moving.iter().chain(&reference).copied().collect();
            let (low, high) = all.iter().fold((all[0], all[0]), |(low, high), p| (low.inf(p), high.sup(p)));
            let diagonal = (high - low).norm();
            let nearest = |p: &Point3<f64>, others: &[Point3<f64>]| {
                others.iter().map(|other| (other - p).norm()).fold(f64::INFINITY, f64::min)
            };
            let least = moving.iter().map(|p| nearest(p, &reference)).fold(f64::INFINITY, f64::min);
            prop_assert_eq!(region.touching, least <= CONTACT_SHARE * diagonal);
            prop_assert!(least >= gap);
            for &(sample, score) in &region.samples {
                let other = if (sample as usize) < moving.len() { &reference } else { &moving };
                prop_assert!(score > 0.0);
                prop_assert!(nearest(&all[sample as usize], other) < 2.0 * reach(least / diagonal) * diagonal * (1.0 + 1e-6));
            }
            let inside = |axis: usize| {
                let along = moving.iter().map(|p| p[axis]);
                let (low, high) = (along.clone().fold(f64::MAX, f64::min), along.fold(f64::MIN, f64::max));
                (low - 1e-9..=high + 1e-9).contains(&region.centroid[axis])
            };
            prop_assert!((0..3).all(inside));
        }
    }
}
