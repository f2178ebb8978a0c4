//! Quickhull (Barber et al. 1996) with exact visibility tests.
//!
//! Shewchuk's exact predicate decides if a facet is visible from a new point. The horizon is therefore always one
//! simple loop, and coplanar, collinear or repeated points need no special case. Points within a small tolerance of the
//! hull are omitted, because they would only add slivers.

use nalgebra::{Point3, Vector3};
use robust::{Coord3D, orient3d};

use crate::fit::polyhedron::{Edge, Polyhedron};

/// Largest distance of omitted points outside the hull. Coordinates should be of the order of one.
const TOLERANCE: f64 = 1e-10;

const NONE: u32 = u32::MAX;

/// Sign of the side of the facet `[a, b, c]` on which point `d` lies: positive outside, zero if exactly coplanar.
pub fn side_of_facet(points: &[Point3<f64>], [a, b, c]: [usize; 3], d: usize) -> f64 {
    let at = |i: usize| Coord3D { x: points[i].x, y: points[i].y, z: points[i].z };
    -orient3d(at(a), at(b), at(c), at(d))
}

struct Facet {
    vertices: [u32; 3],
    /// Facet beyond the edge from corner `i` to corner `i + 1`.
    neighbours: [u32; 3],
    normal: Vector3<f64>,
    offset: f64,
    /// Points outside this facet, and the farthest of them.
    outside: Vec<u32>,
    farthest: (f64, u32),
    alive: bool,
}

/// An edge between a visible facet and a facet that stays.
struct HorizonEdge {
    vertices: [u32; 2],
    beyond: u32,
}

/// A hull under construction.
pub struct Quickhull<'a> {
    points: &'a [Point3<f64>],
    facets: Vec<Facet>,
    /// Facets that may have points outside.
    pending: Vec<u32>,
}

impl<'a> Quickhull<'a> {
    /// Tetrahedron of four of the points, which must not be coplanar.
    pub fn new(points: &'a [Point3<f64>], [a, b, c, d]: [usize; 4]) -> Self {
        let mut hull = Self { points, facets: Vec::new(), pending: Vec::new() };
        let (b, c) = if side_of_facet(points, [a, b, c], d) < 0.0 { (b, c) } else { (c, b) };
        let [a, b, c, d] = [a, b, c, d].map(|i| i as u32);
        hull.add([a, b, c], [1, 2, 3]);
        hull.add([b, a, d], [0, 3, 2]);
        hull.add([c, b, d], [0, 1, 3]);
        hull.add([a, c, d], [0, 2, 1]);
        hull.assign((0..points.len() as u32).collect(), 0);
        hull
    }

    fn add(&mut self, vertices: [u32; 3], neighbours: [u32; 3]) -> u32 {
        let [a, b, c] = vertices.map(|v| self.points[v as usize]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
        let offset = normal.dot(&a.coords);
        let farthest = (TOLERANCE, NONE);
        self.facets.push(Facet { vertices, neighbours, normal, offset, outside: Vec::new(), farthest, alive: true });
        self.facets.len() as u32 - 1
    }

    /// Assigns each of `candidates` to the first facet, from `first` on, that it lies outside of. The others are inside
    /// the hull.
    fn assign(&mut self, candidates: Vec<u32>, first: usize) {
        for candidate in candidates {
            let point = self.points[candidate as usize].coords;
            for facet in &mut self.facets[first..] {
                let distance = facet.normal.dot(&point) - facet.offset;
                if distance > TOLERANCE {
                    facet.outside.push(candidate);
                    if distance > facet.farthest.0 {
                        facet.farthest = (distance, candidate);
                    }
                    break;
                }
            }
        }
        let with_points = (first..self.facets.len()).filter(|&i| !self.facets[i].outside.is_empty());
        self.pending.extend(with_points.map(|i| i as u32));
    }

    /// Adds the remaining points, the farthest outside first.
    pub fn run(mut self) -> Polyhedron {
        while let Some(facet) = self.pending.pop() {
            if self.facets[facet as usize].alive {
                self.add_farthest(facet);
            }
        }
        self.into_polyhedron()
    }

    /// Replaces the facets visible from the farthest point outside `facet` by a cone over the horizon.
    fn add_farthest(&mut self, facet: u32) {
        let apex = self.facets[facet as usize].farthest.1;
        if !self.is_visible(facet, apex) {
            // The point is outside only by the rounding of the facet's plane.
            self.facets[facet as usize].outside.clear();
            return;
        }
        let mut horizon = Vec::new();
        let mut orphans = Vec::new();
        self.remove_visible(facet, apex, &mut horizon, &mut orphans);
        let first = self.facets.len() as u32;
        let count = horizon.len() as u32;
        for (i, HorizonEdge { vertices: [a, b], beyond }) in horizon.into_iter().enumerate() {
            let i = i as u32;
            let neighbours = [beyond, first + (i + 1) % count, first + (i + count - 1) % count];
            let added = self.add([a, b, apex], neighbours);
            let other = &mut self.facets[beyond as usize];
            if let Some(edge) = (0..3).find(|&e| other.vertices[e] == b && other.vertices[(e + 1) % 3] == a) {
                other.neighbours[edge] = added;
            }
        }
        self.assign(orphans, first as usize);
    }

    fn is_visible(&self, facet: u32, apex: u32) -> bool {
        side_of_facet(self.points, self.facets[facet as usize].vertices.map(|v| v as usize), apex as usize) > 0.0
    }

    /// Removes the facets visible from `apex`. The order of the walk gives the horizon as one counter-clockwise loop.
    fn remove_visible(&mut self, seed: u32, apex: u32, horizon: &mut Vec<HorizonEdge>, orphans: &mut Vec<u32>) {
        // For each facet on the path: the edge of entry, and the number of finished edges.
        let mut path = vec![(seed, 0, 0)];
        self.remove(seed, orphans);
        while let Some((facet, entry, done)) = path.last_mut() {
            if *done == 3 {
                path.pop();
                continue;
            }
            let edge = (*entry + *done) % 3;
            *done += 1;
            let Facet { vertices, neighbours, .. } = &self.facets[*facet as usize];
            let (from, to, beyond) = (vertices[edge], vertices[(edge + 1) % 3], neighbours[edge]);
            if !self.facets[beyond as usize].alive {
                continue;
            }
            if self.is_visible(beyond, apex) {
                self.remove(beyond, orphans);
                let entered = self.facets[beyond as usize].vertices.iter().position(|&v| v == to).unwrap_or(0);
                path.push((beyond, entered, 0));
            } else {
                horizon.push(HorizonEdge { vertices: [from, to], beyond });
            }
        }
        orphans.retain(|&point| point != apex);
    }

    fn remove(&mut self, facet: u32, orphans: &mut Vec<u32>) {
        let facet = &mut self.facets[facet as usize];
        facet.alive = false;
        orphans.append(&mut facet.outside);
    }

    fn into_polyhedron(self) -> Polyhedron {
        let mut corner = vec![NONE; self.points.len()];
        let mut renumbered = vec![NONE; self.facets.len()];
        let (mut vertices, mut facets) = (Vec::new(), Vec::new());
        for (index, facet) in self.facets.iter().enumerate().filter(|(_, facet)| facet.alive) {
            renumbered[index] = facets.len() as u32;
            facets.push(facet.vertices.map(|v| {
                let slot = &mut corner[v as usize];
                if *slot == NONE {
                    *slot = vertices.len() as u32;
                    vertices.push(self.points[v as usize]);
                }
                *slot
            }));
        }
        let mut edges = Vec::with_capacity(facets.len() * 3 / 2);
        for (index, facet) in self.facets.iter().enumerate().filter(|(_, facet)| facet.alive) {
            for edge in 0..3 {
                let beyond = facet.neighbours[edge] as usize;
                if index < beyond {
                    let ends = [facet.vertices[edge], facet.vertices[(edge + 1) % 3]].map(|v| corner[v as usize]);
                    edges.push(Edge { vertices: ends, facets: [renumbered[index], renumbered[beyond]] });
                }
            }
        }
        Polyhedron { vertices, facets, edges }
    }
}
