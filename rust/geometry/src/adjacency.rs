//! Exact distances between parts.

use nalgebra::Point3;
use rayon::prelude::*;

use crate::aabb::Aabb;
use crate::bvh::Bvh;
use crate::triangle::ClosestPoints;

/// Distances below this many units in the last place of the largest coordinate are rounding: the surfaces touch.
const TOUCHING_ULPS: f64 = 4.0;

/// Distance of two parts with the points at which it is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartDistance {
    /// Distance of the surfaces; 0 where they touch or cross.
    pub distance: f64,
    /// Nearest point on the first part.
    pub witness_a: Point3<f64>,
    /// Nearest point on the second part.
    pub witness_b: Point3<f64>,
}

/// Distance of the surfaces of two parts, each the union of some meshes; `None` if it is more than `max_distance`.
///
/// It is the distance of *surfaces*: a closed part wholly inside another is as far away as its surface is.
/// Meshes are taken by the distance of their boxes, so most pairs of meshes are never looked at.
pub fn part_distance(a: &[&Bvh], b: &[&Bvh], max_distance: f64) -> Option<PartDistance> {
    let largest = a.iter().chain(b).flat_map(|tree| [tree.bounds().low, tree.bounds().high]);
    let largest = largest.fold(0.0f64, |largest, corner| largest.max(corner.coords.amax()));
    let touching = (TOUCHING_ULPS * f64::EPSILON * largest).powi(2);

    let mut pairs: Vec<(f64, usize, usize)> = Vec::with_capacity(a.len() * b.len());
    for (i, first) in a.iter().enumerate() {
        for (j, second) in b.iter().enumerate() {
            pairs.push((first.bounds().squared_distance(second.bounds()), i, j));
        }
    }
    pairs.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));

    // The least upward step keeps pairs at exactly `max_distance`.
    let mut bound = (max_distance * max_distance).max(touching).next_up();
    let mut best: Option<ClosestPoints> = None;
    for (squared, i, j) in pairs {
        if squared >= bound || bound <= touching {
            break;
        }
        if let Some(found) = a[i].closest(b[j], bound, touching) {
            bound = found.squared;
            best = Some(found);
        }
    }
    best.map(|points| PartDistance {
        distance: if points.squared <= touching { 0.0 } else { points.squared.sqrt() },
        witness_a: points.a,
        witness_b: points.b,
    })
}

/// Distances of many pairs of parts, in the order of `pairs`.
pub fn part_distances(parts: &[Vec<&Bvh>], pairs: &[(usize, usize)], max_distance: f64) -> Vec<Option<PartDistance>> {
    let bounds: Vec<Aabb> = parts.iter().map(|part| bounds_of(part)).collect();
    pairs
        .par_iter()
        .map(|&(a, b)| {
            let near = bounds[a].squared_distance(&bounds[b]).sqrt() <= max_distance;
            near.then(|| part_distance(&parts[a], &parts[b], max_distance)).flatten()
        })
        .collect()
}

fn bounds_of(part: &[&Bvh]) -> Aabb {
    part.iter().fold(Aabb::empty(), |bounds, tree| bounds.merged(tree.bounds()))
}
