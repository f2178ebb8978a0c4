//! Insertion of a point into a Delaunay diagram.
//!
//! The tetrahedra whose circumspheres contain the point are replaced by new ones around it.

use super::Delaunay;
use super::edge_table::EdgeTable;
use super::tetrahedron::{FACES, NONE, Tetrahedron};

/// Buffers of an insertion, reused by the next one.
#[derive(Clone, Default)]
pub struct Scratch {
    /// Last insertion that visited each tetrahedron, and true if that tetrahedron was in its cavity.
    pub visited: Vec<(u32, bool)>,
    cavity: Vec<u32>,
    /// Faces of the cavity: corners, and the tetrahedron beyond.
    faces: Vec<([u32; 3], u32)>,
    created: Vec<Tetrahedron>,
    edges: EdgeTable,
}

impl Scratch {
    /// Buffers for a diagram of one tetrahedron.
    pub fn for_one_tetrahedron() -> Self {
        Self { visited: vec![(0, false)], ..Self::default() }
    }
}

impl Delaunay {
    /// Inserts a point and returns a tetrahedron at it. The search for the point starts at the tetrahedron `near`.
    pub fn insert(&mut self, point: u32, near: u32) -> u32 {
        let Some(holder) = self.locate(point, near) else { return near };
        self.collect_cavity(point, holder);
        let mut scratch = std::mem::take(&mut self.scratch);
        let done = self.fill_cavity(point, &mut scratch);
        self.scratch = scratch;
        done.unwrap_or(holder)
    }

    /// Walks from tetrahedron to tetrahedron towards the point.
    fn locate(&self, point: u32, start: u32) -> Option<u32> {
        let target = self.point(point);
        let (mut at, mut from) = (start, NONE);
        // A walk among Delaunay tetrahedra terminates. The bound guards against rounding errors.
        for _ in 0..self.tetrahedra.len() + 16 {
            let t = &self.tetrahedra[at as usize];
            let next = (0..4).find(|&face| {
                let beyond = t.neighbours[face];
                beyond != NONE && beyond != from && {
                    let [a, b, c] = FACES[face].map(|i| self.point(t.corners[i]));
                    (b - a).cross(&(c - a)).dot(&(target - a)) > 0.0
                }
            });
            match next {
                Some(face) => (from, at) = (at, t.neighbours[face]),
                None => return Some(at),
            }
        }
        None
    }

    /// Collects the tetrahedra whose circumspheres contain the point, and the faces around them.
    fn collect_cavity(&mut self, point: u32, holder: u32) {
        let target = self.points[point as usize];
        let scratch = &mut self.scratch;
        let stamp = point + 1;
        scratch.cavity.clear();
        scratch.faces.clear();
        scratch.cavity.push(holder);
        scratch.visited[holder as usize] = (stamp, true);
        let mut index = 0;
        while index < scratch.cavity.len() {
            let t = &self.tetrahedra[scratch.cavity[index] as usize];
            index += 1;
            for (face, &beyond) in t.neighbours.iter().enumerate() {
                let inside = beyond != NONE && {
                    let visited = &mut scratch.visited[beyond as usize];
                    if visited.0 != stamp {
                        let other = &self.tetrahedra[beyond as usize];
                        *visited = (stamp, other.sphere_holds(&(target - self.points[other.corners[0] as usize])));
                        if visited.1 {
                            scratch.cavity.push(beyond);
                        }
                    }
                    visited.1
                };
                if !inside {
                    scratch.faces.push((FACES[face].map(|i| t.corners[i]), beyond));
                }
            }
        }
    }

    /// Replaces the cavity by tetrahedra from the point to the cavity's faces.
    ///
    /// Returns `None` and changes nothing if rounding or a duplicate point would invert one of them.
    fn fill_cavity(&mut self, point: u32, scratch: &mut Scratch) -> Option<u32> {
        scratch.created.clear();
        for &([a, b, c], _) in &scratch.faces {
            scratch.created.push(Tetrahedron::new(&self.points, [point, a, b, c])?);
        }
        for &gone in &scratch.cavity {
            self.alive[gone as usize] = false;
        }
        self.free.extend(&scratch.cavity);
        scratch.edges.clear(scratch.faces.len());
        let mut last = NONE;
        for (created, &(face, beyond)) in scratch.created.iter().zip(&scratch.faces) {
            let slot = match self.free.pop() {
                Some(slot) => {
                    self.tetrahedra[slot as usize] = *created;
                    slot
                }
                None => {
                    self.tetrahedra.push(*created);
                    self.alive.push(true);
                    scratch.visited.push((0, false));
                    self.tetrahedra.len() as u32 - 1
                }
            };
            self.alive[slot as usize] = true;
            self.tetrahedra[slot as usize].neighbours[0] = beyond;
            if beyond != NONE {
                let other = &mut self.tetrahedra[beyond as usize];
                if let Some(side) = (0..4).find(|&i| !face.contains(&other.corners[i])) {
                    other.neighbours[side] = slot;
                }
            }
            let [_, a, b, c] = created.corners;
            for (side, u, v) in [(1, b, c), (2, c, a), (3, a, b)] {
                if let Some(face) = scratch.edges.pair(u, v, 4 * slot + side) {
                    self.tetrahedra[slot as usize].neighbours[side as usize] = face / 4;
                    self.tetrahedra[face as usize / 4].neighbours[face as usize % 4] = slot;
                }
            }
            last = slot;
        }
        Some(last)
    }
}
