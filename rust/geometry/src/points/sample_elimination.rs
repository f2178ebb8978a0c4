//! Weighted sample elimination: an evenly spaced subset of dense surface samples.
//!
//! Source: Cem Yuksel, Sample Elimination for Generating Poisson Disk Sample Sets, Computer Graphics Forum 34(2), 2015.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use crate::points::surface_sample::SurfaceSample;

/// Exponent of the weight function (section 3.3 of the paper).
const SHARPNESS: i32 = 8;

/// Keeps `count` of `samples` of a surface of the given area, and drops the most crowded sample again and again.
pub fn eliminate(samples: &[SurfaceSample], count: usize, area: f64) -> Vec<SurfaceSample> {
    // The radius of `count` discs in the densest packing. Weights reach twice as far.
    let reach = 2.0 * (area / (2.0 * 3f64.sqrt() * count.max(1) as f64)).sqrt();
    let neighbours = neighbours_within(samples, reach);
    let mut crowding: Vec<f64> = neighbours.iter().map(|list| list.iter().map(|n| n.weight).sum()).collect();
    let mut queue: BinaryHeap<QueueEntry> =
        crowding.iter().enumerate().map(|(sample, &crowding)| QueueEntry { crowding, sample }).collect();
    let mut alive = vec![true; samples.len()];
    let mut left = samples.len();
    while left > count {
        let Some(entry) = queue.pop() else { break };
        if !alive[entry.sample] {
            continue;
        }
        // Queue entries are updated late: a sample that has lost neighbours goes back with its current value.
        if entry.crowding > crowding[entry.sample] {
            queue.push(QueueEntry { crowding: crowding[entry.sample], ..entry });
            continue;
        }
        alive[entry.sample] = false;
        left -= 1;
        for neighbour in &neighbours[entry.sample] {
            let rest = &mut crowding[neighbour.sample];
            *rest = (*rest - neighbour.weight).max(0.0);
        }
    }
    samples.iter().zip(alive).filter_map(|(sample, alive)| alive.then_some(*sample)).collect()
}

struct WeightedNeighbour {
    sample: usize,
    weight: f64,
}

#[derive(Clone, Copy)]
struct QueueEntry {
    crowding: f64,
    sample: usize,
}

impl Ord for QueueEntry {
    fn cmp(&self, other: &Self) -> Ordering {
        self.crowding.total_cmp(&other.crowding).then(self.sample.cmp(&other.sample))
    }
}

impl PartialOrd for QueueEntry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for QueueEntry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for QueueEntry {}

/// Neighbours of every sample within `reach`, found in a grid with cells of that size.
fn neighbours_within(samples: &[SurfaceSample], reach: f64) -> Vec<Vec<WeightedNeighbour>> {
    let cell_of = |sample: &SurfaceSample| {
        let cell = ((sample.point - samples[0].point) / reach).map(|x| x.floor() as i64);
        [cell.x, cell.y, cell.z]
    };
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (index, sample) in samples.iter().enumerate() {
        cells.entry(cell_of(sample)).or_default().push(index);
    }
    let near = |index: usize| {
        let [x, y, z] = cell_of(&samples[index]);
        let mut found = Vec::new();
        for (i, j, k) in (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| (i, j, k)))) {
            for &other in cells.get(&[x + i, y + j, z + k]).into_iter().flatten() {
                let distance = (samples[other].point - samples[index].point).norm();
                if other != index && distance < reach {
                    found.push(WeightedNeighbour { sample: other, weight: (1.0 - distance / reach).powi(SHARPNESS) });
                }
            }
        }
        found
    };
    (0..samples.len()).map(near).collect()
}
