//! Interaction region of two parts, after the interaction bisector surface (IBS) of Hu et al. 2015.
//!
//! The IBS is the part of the Voronoi diagram of the samples of both parts, and of points on a sphere around them, that
//! separates samples of different parts. A ridge between two samples is cut into the triangles that its mean corner makes
//! with its edges. With `D` the diagonal of the box of all samples, `d` the distance of a triangle's centroid to the two
//! samples and `alpha` the angle there between the ridge's normal and the direction to a sample, a triangle gives both
//!
//! `area * (1 - d / (D / 2))^20 * (1 - alpha / (pi / 3))`, 0 where a factor is negative.
//!
//! The score of a sample is the sum over its triangles; the region is what has a score; its centroid is the mean of the
//! moving part's samples, weighted by score.
//!
//! The power makes all but the nearest ridges vanish, so only cells near the other part are built, each cut out of a small
//! box by the bisectors of its neighbours; a cell corner is final once no sample is nearer to it than the cell's own.

use std::f64::consts::{FRAC_PI_3, PI};

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::convex::ConvexPolyhedron;
use crate::point_tree::{Neighbour, PointTree};

/// Radius of the bounding sphere in diagonals, and its points by latitude and longitude.
const SPHERE_RADIUS: f64 = 2.0 / 3.0;
const SPHERE_LATITUDES: usize = 20;
const SPHERE_LONGITUDES: usize = 40;
/// Exponent of the weight of nearness.
const NEARNESS_POWER: i32 = 20;
/// Ridges are left out once the base of the nearness weight falls below this share of the nearest pair's.
const NEGLIGIBLE_NEARNESS: f64 = 0.6;
/// Parts whose samples come as near as this share of the diagonal are in contact.
const CONTACT_SHARE: f64 = 0.01;
/// Neighbours that a cell is cut by before its corners are checked one by one.
const FIRST_NEIGHBOURS: usize = 24;
/// A sample has to be nearer than the cell's own by this share of the squared distance to cut a corner off.
const CORNER_SLACK: f64 = 1e-9;
/// Nearest cross pairs that stand in, from either side, where no sample has a score.
const FALLBACK_PAIRS: usize = 10;
/// Tag of the faces of the box that a cell is cut out of.
const NO_SAMPLE: u32 = u32::MAX;

/// The interaction region of a moving and a reference part.
#[derive(Debug, Clone, PartialEq)]
pub struct InteractionRegion {
    /// Mean of the moving part's samples, weighted by score.
    pub centroid: Point3<f64>,
    /// Whether a sample of the moving part has a score; if not, the centroid is the mean of the nearest cross pairs.
    pub scored: bool,
    /// Whether the nearest samples of the two parts are within a hundredth of the diagonal.
    pub touching: bool,
    /// Samples with a positive score, ascending: number (the moving part's first, then the reference's) and score. Scores
    /// are areas over the squared diagonal, so free of scale.
    pub samples: Vec<(u32, f64)>,
}

/// Surface samples of two parts.
#[derive(Debug, Clone, PartialEq)]
pub struct PairSamples {
    /// Samples of the part that moves.
    pub moving: Vec<Point3<f64>>,
    /// Samples of the part that it moves against.
    pub reference: Vec<Point3<f64>>,
}

/// Interaction regions of many pairs.
pub fn interaction_regions(pairs: &[PairSamples]) -> Vec<InteractionRegion> {
    pairs.par_iter().map(|pair| interaction_region(&pair.moving, &pair.reference)).collect()
}

/// Interaction region of the samples of two parts; neither may be empty.
pub fn interaction_region(moving: &[Point3<f64>], reference: &[Point3<f64>]) -> InteractionRegion {
    let scene = Scene::new(moving, reference);
    let mut scores = vec![0.0; scene.samples.len()];
    scene.add_scores(&mut scores);
    let samples: Vec<(u32, f64)> = (0..).zip(scores).filter(|&(_, score)| score > 0.0).collect();

    let mut sum = (Vector3::zeros(), 0.0);
    for &(sample, score) in samples.iter().take_while(|&&(sample, _)| (sample as usize) < scene.split) {
        sum = (sum.0 + scene.samples[sample as usize].coords * score, sum.1 + score);
    }
    let scored = sum.1 > 0.0;
    let centroid = if scored { Point3::from(sum.0 / sum.1) } else { scene.mean_of_nearest_pairs() };
    InteractionRegion {
        centroid: scene.center + centroid.coords * scene.diagonal,
        scored,
        touching: scene.gap <= CONTACT_SHARE,
        samples,
    }
}

/// Samples of a pair, centred and in units of the diagonal, with what is needed to find neighbours.
struct Scene {
    /// The moving part's samples, then the reference's.
    samples: Vec<Point3<f64>>,
    split: usize,
    center: Point3<f64>,
    diagonal: f64,
    /// Of every sample, the nearest one of the other part.
    partners: Vec<Neighbour>,
    /// Distance of the nearest samples of the two parts.
    gap: f64,
}

impl Scene {
    fn new(moving: &[Point3<f64>], reference: &[Point3<f64>]) -> Self {
        let all = || moving.iter().chain(reference);
        let (low, high) = all().fold((moving[0], moving[0]), |(low, high), p| (low.inf(p), high.sup(p)));
        let center = nalgebra::center(&low, &high);
        let length = (high - low).norm();
        let diagonal = if length > 0.0 { length } else { 1.0 };
        let samples: Vec<Point3<f64>> = all().map(|p| Point3::from((p - center) / diagonal)).collect();
        let split = moving.len();
        let (first, second) = samples.split_at(split);
        let nearest_in = |tree: PointTree, from: &[Point3<f64>], offset: usize| -> Vec<Neighbour> {
            from.iter()
                .filter_map(|p| tree.nearest(p, f64::INFINITY))
                .map(|found| Neighbour { point: found.point + offset as u32, ..found })
                .collect()
        };
        let mut partners = nearest_in(PointTree::new(second), first, split);
        partners.extend(nearest_in(PointTree::new(first), second, 0));
        let gap = partners.iter().fold(f64::INFINITY, |gap, partner| gap.min(partner.squared)).sqrt();
        Self { samples, split, center, diagonal, partners, gap }
    }

    /// Distance of a ridge to its samples beyond which it is left out.
    fn reach(&self) -> f64 {
        0.5 - NEGLIGIBLE_NEARNESS * (0.5 - 0.5 * self.gap).max(0.0)
    }

    fn add_scores(&self, scores: &mut [f64]) {
        let reach = self.reach();
        let mut sites = self.samples.clone();
        sites.extend(sphere());
        let tree = PointTree::new(&sites);
        let near = |sample: &usize| self.partners[*sample].squared < (2.0 * reach).powi(2);
        let moving: Vec<usize> = (0..self.split).filter(near).collect();
        let reference: Vec<usize> = (self.split..self.samples.len()).filter(near).collect();
        // A ridge belongs to a cell of either part: the part with fewer cells to build gives all of them.
        let cells = if moving.len() <= reference.len() { moving } else { reference };
        let mut cell = ConvexPolyhedron::default();
        let mut neighbours = Vec::new();
        for own in cells {
            self.build_cell(own, &sites, &tree, reach, &mut cell, &mut neighbours);
            for (tag, corners) in cell.faces() {
                let other = tag as usize;
                if other < self.samples.len() && (other < self.split) != (own < self.split) {
                    let score = ridge_score(corners, &(self.samples[other] - self.samples[own]));
                    scores[own] += score;
                    scores[other] += score;
                }
            }
        }
    }

    /// The Voronoi cell of a sample, relative to it, cut down to what lies within `reach` along each axis.
    fn build_cell(
        &self,
        own: usize,
        sites: &[Point3<f64>],
        tree: &PointTree,
        reach: f64,
        cell: &mut ConvexPolyhedron,
        neighbours: &mut Vec<Neighbour>,
    ) {
        let site = sites[own];
        let edges = [Vector3::x() * reach, Vector3::y() * reach, Vector3::z() * reach];
        cell.set_box(&Point3::origin(), &edges, NO_SAMPLE);
        let cut = |cell: &mut ConvexPolyhedron, other: u32| {
            let offset = sites[other as usize] - site;
            cell.cut(&offset, 0.5 * offset.norm_squared(), other)
        };
        cut(cell, self.partners[own].point);
        tree.nearest_many(&site, FIRST_NEIGHBOURS, f64::INFINITY, neighbours);
        for neighbour in neighbours.iter() {
            cut(cell, neighbour.point);
        }
        while let Some(corner) = cell.unmarked() {
            let offset = cell.corners()[corner].coords;
            match tree.nearest(&(site + offset), offset.norm_squared() * (1.0 - CORNER_SLACK)) {
                Some(nearer) if cut(cell, nearer.point) => {}
                _ => cell.mark(corner),
            }
        }
    }

    /// Mean of the points of the nearest pairs of samples of different parts.
    fn mean_of_nearest_pairs(&self) -> Point3<f64> {
        let mut sum = (Vector3::zeros(), 0.0);
        for side in [0..self.split, self.split..self.samples.len()] {
            let mut nearest: Vec<usize> = side.collect();
            nearest.sort_by(|&a, &b| self.partners[a].squared.total_cmp(&self.partners[b].squared));
            for &sample in nearest.iter().take(FALLBACK_PAIRS) {
                let partner = self.partners[sample].point as usize;
                sum = (sum.0 + self.samples[sample].coords + self.samples[partner].coords, sum.1 + 2.0);
            }
        }
        Point3::from(sum.0 / sum.1)
    }
}

/// Points of the sphere around the scene.
fn sphere() -> impl Iterator<Item = Point3<f64>> {
    (0..SPHERE_LATITUDES).flat_map(|row| {
        let polar = PI * (row as f64 + 0.5) / SPHERE_LATITUDES as f64;
        (0..SPHERE_LONGITUDES).map(move |column| {
            let azimuth = 2.0 * PI * column as f64 / SPHERE_LONGITUDES as f64;
            let (sin, cos) = polar.sin_cos();
            Point3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos) * SPHERE_RADIUS
        })
    })
}

/// Score of a ridge, its corners relative to one of its samples, `across` the way to the other one.
fn ridge_score(corners: impl ExactSizeIterator<Item = Point3<f64>> + Clone, across: &Vector3<f64>) -> f64 {
    let count = corners.len() as f64;
    let mean = corners.clone().fold(Vector3::zeros(), |sum, corner| sum + corner.coords) / count;
    let height = 0.5 * across.norm();
    let rotated = corners.clone().cycle().skip(1);
    corners
        .zip(rotated)
        .map(|(from, to)| {
            let area = 0.5 * (from.coords - mean).cross(&(to.coords - mean)).norm();
            let distance = ((from.coords + to.coords + mean) / 3.0).norm();
            let nearness = (1.0 - 2.0 * distance).max(0.0).powi(NEARNESS_POWER);
            // The normal points at the sample, which is `height` below the ridge's plane.
            let alpha = (height / distance).min(1.0).acos();
            area * nearness * (1.0 - alpha / FRAC_PI_3).max(0.0)
        })
        .sum()
}
