//! Search for the smallest box around a convex polyhedron.

use nalgebra::{Point2, Vector3};

use crate::fit::minimum_area_rectangle::minimum_area_axes_of_projection;
use crate::fit::polyhedron::Polyhedron;
use crate::fit::vector_columns::VectorColumns;
use crate::points::perpendicular::perpendicular_basis;

/// Relative tolerance of volumes. Boxes within it count as equally good.
const VOLUME_TOLERANCE: f64 = 1e-5;

/// Size of the grid cells that merge nearly equal directions. If there are too many directions, cells start at
/// `COARSE_CELL` and double.
const DIRECTION_CELL: f64 = 2e-6;
const COARSE_CELL: f64 = 1e-3;
const MAX_FACET_DIRECTIONS: usize = 256;
const MAX_EDGE_DIRECTIONS: usize = 128;

/// Sine of the largest angle between the facets of a diagonal inside one flat face.
const FLAT_EDGE: f64 = 1e-6;

/// Largest number of edges for which the search also tries the cross products of all pairs of edges.
const CROSSED_EDGES: usize = 24;

/// Number of best boxes that are refined, and the limit on their refinement steps.
const REFINED_BOXES: usize = 16;
const REFINEMENT_STEPS: usize = 50;

/// Axes of a box, and its volume.
#[derive(Debug, Clone, Copy)]
pub struct CandidateBox {
    pub axes: [Vector3<f64>; 3],
    pub volume: f64,
}

/// A polyhedron with the buffers that searches along many directions share.
pub struct BoxSearch<'a> {
    hull: &'a Polyhedron,
    area_vectors: Vec<Vector3<f64>>,
    facet_columns: VectorColumns,
    vertex_columns: VectorColumns,
    /// One flag per facet: true if it faces along the current direction.
    facing: Vec<bool>,
    on_silhouette: Vec<bool>,
    silhouette: Vec<Point2<f64>>,
}

impl<'a> BoxSearch<'a> {
    pub fn new(hull: &'a Polyhedron) -> Self {
        let area_vectors: Vec<_> = (0..hull.facets.len()).map(|facet| hull.area_vector(facet as u32)).collect();
        let vertices: Vec<_> = hull.vertices.iter().map(|vertex| vertex.coords).collect();
        Self {
            hull,
            facet_columns: VectorColumns::new(&area_vectors, Vector3::zeros()),
            vertex_columns: VectorColumns::new(&vertices, vertices[0]),
            facing: Vec::new(),
            area_vectors,
            on_silhouette: vec![false; hull.vertices.len()],
            silhouette: Vec::new(),
        }
    }

    /// Axes of the box of minimum volume.
    pub fn minimum_volume(&mut self) -> [Vector3<f64>; 3] {
        let mut directions = distinct(self.facet_directions(), MAX_FACET_DIRECTIONS);
        directions.extend(self.edge_directions());
        let mut found = self.best_along(&distinct(directions, usize::MAX));
        found.sort_by(|a, b| a.volume.total_cmp(&b.volume));
        // Each of its faces finds the same box, which needs one refinement.
        let mut starts = found.clone();
        starts.dedup_by(|a, b| a.volume <= b.volume * (1.0 + VOLUME_TOLERANCE));
        found.extend(starts.into_iter().take(REFINED_BOXES).map(|candidate| self.refine(candidate)));
        most_aligned(&found).map_or([Vector3::x(), Vector3::y(), Vector3::z()], |best| best.axes)
    }

    /// Best boxes along the normals of the facets, by ascending volume, for at most `limit` distinct normals.
    pub fn facet_boxes(&mut self, limit: usize) -> Vec<CandidateBox> {
        let directions = distinct(self.facet_directions(), limit);
        let mut boxes: Vec<_> = directions.iter().map(|&direction| self.best_box(direction)).collect();
        boxes.sort_by(|a, b| a.volume.total_cmp(&b.volume));
        boxes
    }

    /// Normals of the facets, by descending area. Large facets represent the slivers beside them.
    fn facet_directions(&self) -> Vec<Vector3<f64>> {
        let mut vectors = self.area_vectors.clone();
        vectors.sort_by(|a, b| b.norm_squared().total_cmp(&a.norm_squared()));
        vectors.iter().filter_map(|vector| vector.try_normalize(0.0)).collect()
    }

    /// Directions of the edges. For hulls with few edges, also the directions perpendicular to two edges.
    fn edge_directions(&self) -> Vec<Vector3<f64>> {
        let is_sharp = |facets: [u32; 2]| {
            let [a, b] = facets.map(|facet| self.area_vectors[facet as usize]);
            a.cross(&b).norm() > FLAT_EDGE * a.norm() * b.norm() || a.dot(&b) < 0.0
        };
        let direction = |[a, b]: [u32; 2]| self.hull.vertices[b as usize] - self.hull.vertices[a as usize];
        let edges = self.hull.edges.iter().filter(|edge| is_sharp(edge.facets));
        let directions: Vec<_> = edges.filter_map(|edge| direction(edge.vertices).try_normalize(0.0)).collect();
        let mut directions = distinct(directions, MAX_EDGE_DIRECTIONS);
        if directions.len() <= CROSSED_EDGES {
            let pairs =
                directions.iter().enumerate().flat_map(|(i, a)| directions[..i].iter().map(move |b| a.cross(b)));
            let across: Vec<_> = pairs.filter_map(|cross| cross.try_normalize(FLAT_EDGE)).collect();
            directions.extend(across);
        }
        directions
    }

    /// Best boxes along the directions whose lower bound is small enough.
    fn best_along(&mut self, directions: &[Vector3<f64>]) -> Vec<CandidateBox> {
        let mut bounded: Vec<_> =
            directions.iter().map(|direction| (self.volume_bound_along(direction), direction)).collect();
        bounded.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut found: Vec<CandidateBox> = Vec::new();
        let mut least = f64::INFINITY;
        for (bound, direction) in bounded {
            if bound > least * (1.0 + VOLUME_TOLERANCE) {
                break;
            }
            let candidate = self.best_box(*direction);
            least = least.min(candidate.volume);
            found.push(candidate);
        }
        found
    }

    /// Lower bound on the volume of boxes with an axis along `direction`: height times projected area.
    fn volume_bound_along(&self, direction: &Vector3<f64>) -> f64 {
        0.5 * self.facet_columns.sum_of_absolute_dots(direction) * self.vertex_columns.spread_along(direction)
    }

    /// Rotates the box about one axis after another to the best rectangle, until the volume no longer shrinks.
    fn refine(&mut self, mut candidate: CandidateBox) -> CandidateBox {
        for _ in 0..REFINEMENT_STEPS {
            // The box is already optimal about its third axis, along which it was found.
            let [x, y, _] = candidate.axes;
            let [about_x, about_y] = [self.best_box(x), self.best_box(y)];
            let turned = if about_y.volume < about_x.volume { about_y } else { about_x };
            if turned.volume > candidate.volume * (1.0 - 1e-9) {
                break;
            }
            candidate = turned;
        }
        candidate
    }

    /// Best box with an axis along `direction`.
    fn best_box(&mut self, direction: Vector3<f64>) -> CandidateBox {
        let (x, y) = perpendicular_basis(direction);
        self.find_silhouette(&direction, &x, &y);
        let (axes, area) = minimum_area_axes_of_projection(&mut self.silhouette, [x, y, direction]);
        CandidateBox { axes, volume: area * self.vertex_columns.spread_along(&direction) }
    }

    /// Projects the silhouette: the ends of edges between a facet that faces along `direction` and one that does not.
    fn find_silhouette(&mut self, direction: &Vector3<f64>, x: &Vector3<f64>, y: &Vector3<f64>) {
        self.facet_columns.mark_facing(direction, &mut self.facing);
        self.on_silhouette.fill(false);
        self.silhouette.clear();
        for edge in &self.hull.edges {
            if self.facing[edge.facets[0] as usize] != self.facing[edge.facets[1] as usize] {
                for vertex in edge.vertices.map(|v| v as usize) {
                    if !std::mem::replace(&mut self.on_silhouette[vertex], true) {
                        let corner = self.hull.vertices[vertex].coords;
                        self.silhouette.push(Point2::new(x.dot(&corner), y.dot(&corner)));
                    }
                }
            }
        }
    }
}

/// One direction per grid cell, in the given order. Opposite directions share a cell.
fn distinct(mut directions: Vec<Vector3<f64>>, limit: usize) -> Vec<Vector3<f64>> {
    let mut cell = DIRECTION_CELL;
    loop {
        let mut keys: Vec<_> = directions.iter().map(|direction| cell_key(direction, cell)).zip(0..).collect();
        keys.sort_unstable();
        keys.dedup_by_key(|(key, _)| *key);
        let mut kept: Vec<usize> = keys.into_iter().map(|(_, index)| index).collect();
        kept.sort_unstable();
        directions = kept.into_iter().map(|index| directions[index]).collect();
        if directions.len() <= limit {
            return directions;
        }
        cell = (2.0 * cell).max(COARSE_CELL);
    }
}

/// Key of the grid cell of a direction and its opposite.
fn cell_key(direction: &Vector3<f64>, cell: f64) -> u64 {
    let cells = (direction / cell).map(|x| x.round() as i64);
    let leading = cells.iter().find(|x| **x != 0).copied().unwrap_or(1);
    let canonical = if leading < 0 { -cells } else { cells };
    canonical.iter().fold(0, |key, x| key << 21 | (x & 0x1f_ffff) as u64)
}

/// The candidate of least volume whose axes are nearest to the coordinate axes.
fn most_aligned(candidates: &[CandidateBox]) -> Option<&CandidateBox> {
    let least = candidates.iter().map(|c| c.volume).fold(f64::INFINITY, f64::min);
    let alignment = |c: &CandidateBox| c.axes.iter().map(|axis| axis.abs().max()).sum::<f64>();
    let best = candidates.iter().filter(|c| c.volume <= least * (1.0 + VOLUME_TOLERANCE));
    best.max_by(|a, b| alignment(a).total_cmp(&alignment(b)).then(b.volume.total_cmp(&a.volume)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::convex_hull::Hull;
    use nalgebra::Point3;
    use proptest::prelude::*;

    prop_compose! {
        fn hulls()(points in prop::collection::vec(prop::array::uniform3(-0.5..0.5f64), 8..40)) -> Polyhedron {
            let points: Vec<_> = points.into_iter().map(Point3::from).collect();
            match Hull::of(&points, 1e-9) {
                Hull::Solid(hull) => hull,
                flat => panic!("points in general position span a solid, not {flat:?}"),
            }
        }
    }

    proptest! {
        #[test]
        fn volumes_are_exact_and_at_least_the_bound(hull in hulls()) {
            let mut search = BoxSearch::new(&hull);
            for direction in search.facet_directions() {
                let CandidateBox { axes, volume } = search.best_box(direction);
                let sides = axes.map(|axis| search.vertex_columns.spread_along(&axis));
                prop_assert!((sides.iter().product::<f64>() / volume - 1.0).abs() < 1e-9);
                prop_assert!(search.volume_bound_along(&direction) <= volume * (1.0 + 1e-9));
            }
        }

        #[test]
        fn no_box_on_a_facet_is_smaller_than_the_result(hull in hulls()) {
            let mut search = BoxSearch::new(&hull);
            let axes = search.minimum_volume();
            let found: f64 = axes.map(|axis| search.vertex_columns.spread_along(&axis)).iter().product();
            for direction in search.facet_directions() {
                prop_assert!(found <= search.best_box(direction).volume * (1.0 + 2.0 * VOLUME_TOLERANCE));
            }
        }
    }
}
