//! Search for the best box around a convex polyhedron.

use std::collections::HashSet;

use nalgebra::{Point2, Point3, Vector3};

use crate::hull::Polyhedron;
use crate::rectangle::{flush_axes_of_projection, perpendicular_basis};

/// Boxes whose volumes differ by no more than this share are equally good.
const TIE: f64 = 1e-5;

/// Directions are tried once per cell of this size, which grows until there are no more than `MAX_DIRECTIONS`.
const DIRECTION_CELL: f64 = 1e-6;
const MAX_DIRECTIONS: usize = 1024;

/// Edges between facets that differ by less than this (sine) are diagonals of one face.
const FLAT_EDGE: f64 = 1e-6;

/// Hulls with at most this many edges are also tried along the directions across two of them.
const CROSSED_EDGES: usize = 24;

/// So many of the best boxes are refined.
const REFINED: usize = 4;
const REFINEMENT_ROUNDS: usize = 20;

/// Axes of a box and its volume.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    pub axes: [Vector3<f64>; 3],
    pub volume: f64,
}

/// A polyhedron with what is needed to find the best box along a direction, again and again.
pub struct BoxSearch<'a> {
    hull: &'a Polyhedron,
    area_vectors: Vec<Vector3<f64>>,
    /// Whether each facet faces along the present direction.
    facing: Vec<bool>,
    on_outline: Vec<bool>,
    outline: Vec<Point2<f64>>,
}

impl<'a> BoxSearch<'a> {
    pub fn new(hull: &'a Polyhedron) -> Self {
        let area_vectors: Vec<_> = (0..hull.facets.len()).map(|facet| hull.area_vector(facet as u32)).collect();
        Self {
            hull,
            facing: vec![false; area_vectors.len()],
            area_vectors,
            on_outline: vec![false; hull.vertices.len()],
            outline: Vec::new(),
        }
    }

    /// Axes of the box of minimum volume.
    pub fn minimum_volume(&mut self) -> [Vector3<f64>; 3] {
        let mut directions = self.facet_directions();
        directions.extend(self.edge_directions());
        directions.extend([Vector3::x(), Vector3::y(), Vector3::z()]);
        let mut found = self.best_along(&distinct(directions, MAX_DIRECTIONS));
        found.sort_by(|a, b| a.volume.total_cmp(&b.volume));
        let refined: Vec<_> = found.iter().take(REFINED).map(|&candidate| self.refine(candidate)).collect();
        found.extend(refined);
        most_aligned(&found).map_or([Vector3::x(), Vector3::y(), Vector3::z()], |best| best.axes)
    }

    /// The best box along each facet's normal, by ascending volume, for at most `limit` distinct normals.
    pub fn facet_boxes(&mut self, limit: usize) -> Vec<Candidate> {
        let directions = distinct(self.facet_directions(), limit);
        let mut boxes: Vec<_> = directions.iter().map(|&direction| self.best_box(direction)).collect();
        boxes.sort_by(|a, b| a.volume.total_cmp(&b.volume));
        boxes
    }

    /// Normals of the facets, those of the largest first: they stand for the slivers beside them.
    fn facet_directions(&self) -> Vec<Vector3<f64>> {
        let mut vectors = self.area_vectors.clone();
        vectors.sort_by(|a, b| b.norm_squared().total_cmp(&a.norm_squared()));
        vectors.iter().filter_map(|vector| vector.try_normalize(0.0)).collect()
    }

    /// Directions of the edges, and for hulls of few edges the directions perpendicular to two of them.
    fn edge_directions(&self) -> Vec<Vector3<f64>> {
        let is_sharp = |facets: [u32; 2]| {
            let [a, b] = facets.map(|facet| self.area_vectors[facet as usize]);
            a.cross(&b).norm() > FLAT_EDGE * a.norm() * b.norm() || a.dot(&b) < 0.0
        };
        let direction = |[a, b]: [u32; 2]| self.hull.vertices[b as usize] - self.hull.vertices[a as usize];
        let edges = self.hull.edges.iter().filter(|edge| is_sharp(edge.facets));
        let directions: Vec<_> = edges.filter_map(|edge| direction(edge.vertices).try_normalize(0.0)).collect();
        let mut directions = distinct(directions, MAX_DIRECTIONS);
        if directions.len() <= CROSSED_EDGES {
            let pairs =
                directions.iter().enumerate().flat_map(|(i, a)| directions[..i].iter().map(move |b| a.cross(b)));
            let across: Vec<_> = pairs.filter_map(|cross| cross.try_normalize(FLAT_EDGE)).collect();
            directions.extend(across);
        }
        directions
    }

    /// The best box along those of `directions` that can compete: height times projected area is a lower bound of the volume.
    fn best_along(&mut self, directions: &[Vector3<f64>]) -> Vec<Candidate> {
        let mut bounded: Vec<_> =
            directions.iter().map(|direction| (self.height(direction) * self.shadow(direction), direction)).collect();
        bounded.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut found: Vec<Candidate> = Vec::new();
        let mut least = f64::INFINITY;
        for (bound, direction) in bounded {
            if bound > least * (1.0 + TIE) {
                break;
            }
            let candidate = self.best_box(*direction);
            least = least.min(candidate.volume);
            found.push(candidate);
        }
        found
    }

    /// Turns the box about each axis in turn to the best rectangle, until that no longer helps.
    fn refine(&mut self, mut candidate: Candidate) -> Candidate {
        for _ in 0..REFINEMENT_ROUNDS {
            let before = candidate.volume;
            for axis in 0..3 {
                let turned = self.best_box(candidate.axes[axis]);
                if turned.volume < candidate.volume {
                    candidate = turned;
                }
            }
            if candidate.volume > before * (1.0 - 1e-9) {
                break;
            }
        }
        candidate
    }

    /// The best box with an axis along `direction`.
    fn best_box(&mut self, direction: Vector3<f64>) -> Candidate {
        let (x, y) = perpendicular_basis(direction);
        self.find_outline(&direction, |p| Point2::new(x.dot(&p.coords), y.dot(&p.coords)));
        let (axes, area) = flush_axes_of_projection(&mut self.outline, [x, y, direction]);
        Candidate { axes, volume: area * self.height(&direction) }
    }

    fn height(&self, direction: &Vector3<f64>) -> f64 {
        let (low, high) = self.hull.vertices.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), vertex| {
            let along = direction.dot(&vertex.coords);
            (low.min(along), high.max(along))
        });
        high - low
    }

    /// Area of the projection along `direction`.
    fn shadow(&self, direction: &Vector3<f64>) -> f64 {
        0.5 * self.area_vectors.iter().map(|vector| vector.dot(direction).abs()).sum::<f64>()
    }

    /// Projects the corners on edges between facets that face along `direction` and facets that do not.
    fn find_outline(&mut self, direction: &Vector3<f64>, project: impl Fn(&Point3<f64>) -> Point2<f64>) {
        for (facing, vector) in self.facing.iter_mut().zip(&self.area_vectors) {
            *facing = vector.dot(direction) > 0.0;
        }
        self.on_outline.fill(false);
        self.outline.clear();
        for edge in &self.hull.edges {
            if self.facing[edge.facets[0] as usize] != self.facing[edge.facets[1] as usize] {
                for vertex in edge.vertices.map(|v| v as usize) {
                    if !std::mem::replace(&mut self.on_outline[vertex], true) {
                        self.outline.push(project(&self.hull.vertices[vertex]));
                    }
                }
            }
        }
    }
}

/// One of each group of directions (or opposite ones) that fall into one cell of a grid, in the order given.
fn distinct(mut directions: Vec<Vector3<f64>>, limit: usize) -> Vec<Vector3<f64>> {
    let mut cell = DIRECTION_CELL;
    loop {
        let mut seen = HashSet::with_capacity(directions.len());
        directions.retain(|direction| {
            let cells = (direction / cell).map(|x| x.round() as i64);
            let leading = cells.iter().find(|x| **x != 0).copied().unwrap_or(1);
            seen.insert(if leading < 0 { -cells } else { cells })
        });
        if directions.len() <= limit {
            return directions;
        }
        cell = (2.0 * cell).max(1e-3);
    }
}

/// Of the candidates of least volume the one whose axes are nearest to the coordinate axes.
fn most_aligned(candidates: &[Candidate]) -> Option<&Candidate> {
    let least = candidates.iter().map(|c| c.volume).fold(f64::INFINITY, f64::min);
    let alignment = |c: &Candidate| c.axes.iter().map(|axis| axis.abs().max()).sum::<f64>();
    let best = candidates.iter().filter(|c| c.volume <= least * (1.0 + TIE));
    best.max_by(|a, b| alignment(a).total_cmp(&alignment(b)).then(b.volume.total_cmp(&a.volume)))
}
