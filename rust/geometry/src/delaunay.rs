//! Delaunay tetrahedra of points in space, by incremental insertion (Bowyer and Watson).

use nalgebra::{Point3, Vector3};

use crate::edge_table::EdgeTable;

/// Stands for no tetrahedron.
const NONE: u32 = u32::MAX;
/// Corners of the face opposite to each corner, counter-clockwise seen from outside.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
/// How many there usually are: room for so many is made beforehand.
const TETRAHEDRA_PER_POINT: usize = 8;
/// Largest shift of a coordinate that parts points which lie on a common plane or sphere.
const JITTER: f64 = 1e-8;
/// How many points the hull has: the numbers of the others start here.
pub const HULL_POINTS: u32 = 4;
/// Corners of a tetrahedron that holds the box [-1, 1]^3 with room to spare.
const HULL: [[f64; 3]; 4] = [[40.0, 40.0, 40.0], [40.0, -40.0, -40.0], [-40.0, 40.0, -40.0], [-40.0, -40.0, 40.0]];

/// A tetrahedron, positively oriented.
#[derive(Debug, Clone, Copy)]
pub struct Tetrahedron {
    /// Numbers of the corners.
    pub corners: [u32; 4],
    /// The tetrahedron beyond the face opposite to each corner.
    neighbours: [u32; 4],
    /// `y` from the first corner lies inside the circumsphere if `linear . y + quadratic * |y|^2 < 0`.
    linear: Vector3<f64>,
    quadratic: f64,
}

/// The Delaunay tetrahedra of some points inside [-1, 1]^3, and of four points far around them.
#[derive(Clone)]
pub struct Delaunay {
    points: Vec<Point3<f64>>,
    tetrahedra: Vec<Tetrahedron>,
    /// Tetrahedra that are no longer there.
    free: Vec<u32>,
    alive: Vec<bool>,
    /// The tetrahedron beside the last point.
    last: u32,
    scratch: Scratch,
}

#[derive(Clone, Default)]
struct Scratch {
    /// By tetrahedron: the insertion that last looked at it, and whether that put it into the cavity.
    seen: Vec<(u32, bool)>,
    cavity: Vec<u32>,
    /// Faces of the cavity: corners, the tetrahedron beyond, and which of its faces it is.
    faces: Vec<([u32; 3], u32)>,
    created: Vec<Tetrahedron>,
    edges: EdgeTable,
}

impl Delaunay {
    /// The tetrahedra of no points: the hull alone.
    pub fn new() -> Self {
        let points: Vec<Point3<f64>> = HULL.map(|corner| Point3::from(Vector3::from(corner))).to_vec();
        let tetrahedra: Vec<Tetrahedron> = Tetrahedron::new(&points, [0, 1, 3, 2]).into_iter().collect();
        Self {
            points,
            tetrahedra,
            alive: vec![true],
            free: Vec::new(),
            last: 0,
            scratch: Scratch { seen: vec![(0, false)], ..Scratch::default() },
        }
    }

    /// Adds points, numbered onwards. Those that come next to each other should lie near each other: that is what makes it
    /// fast. A point that coincides with another may be left out.
    pub fn extend(&mut self, points: impl IntoIterator<Item = Point3<f64>>) {
        let points = points.into_iter();
        let expected = points.size_hint().0;
        self.points.reserve(expected);
        self.tetrahedra.reserve(TETRAHEDRA_PER_POINT * expected);
        self.alive.reserve(TETRAHEDRA_PER_POINT * expected);
        self.scratch.seen.reserve(TETRAHEDRA_PER_POINT * expected);
        for point in points {
            let number = self.points.len() as u32;
            self.points.push(point + jitter(number));
            self.last = self.insert(number, self.last);
        }
    }

    /// The number that the next point gets.
    pub fn next_number(&self) -> u32 {
        self.points.len() as u32
    }

    /// The points, as far as they were moved to be in general position.
    pub fn point(&self, corner: u32) -> &Point3<f64> {
        &self.points[corner as usize]
    }

    /// Numbers of the tetrahedra.
    pub fn tetrahedra(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.tetrahedra.len() as u32).filter(|&t| self.alive[t as usize])
    }

    /// Corners of a tetrahedron.
    pub fn corners(&self, tetrahedron: u32) -> &[u32; 4] {
        &self.tetrahedra[tetrahedron as usize].corners
    }

    /// The centre of the circumsphere of a tetrahedron: a vertex of the Voronoi diagram.
    pub fn circumcenter(&self, tetrahedron: u32) -> Point3<f64> {
        let t = &self.tetrahedra[tetrahedron as usize];
        self.point(t.corners[0]) - t.linear / (2.0 * t.quadratic)
    }

    /// The tetrahedra around the edge of two corners of `start`, in order, into `ring`; false if they do not close or
    /// one of them has a smaller number than `start`, so that only one start a ring succeeds.
    pub fn ring(&self, start: u32, edge: [u32; 2], ring: &mut Vec<u32>) -> bool {
        ring.clear();
        let first = &self.tetrahedra[start as usize].corners;
        let Some(mut pivot) = first.iter().copied().find(|corner| !edge.contains(corner)) else { return false };
        let mut at = start;
        loop {
            ring.push(at);
            let t = &self.tetrahedra[at as usize];
            // Leave through the face that has the edge and the pivot; its other corner is the one that is left behind.
            let Some(behind) = (0..4).find(|&i| t.corners[i] != pivot && !edge.contains(&t.corners[i])) else {
                return false;
            };
            let next = t.neighbours[behind];
            if next == start {
                return true;
            }
            if next == NONE || next < start {
                return false;
            }
            let corners = &self.tetrahedra[next as usize].corners;
            let Some(&ahead) = corners.iter().find(|&&c| c != pivot && !edge.contains(&c)) else { return false };
            (at, pivot) = (next, ahead);
        }
    }

    /// Inserts a point, looking for it from `near` on; returns a tetrahedron beside it.
    fn insert(&mut self, point: u32, near: u32) -> u32 {
        let Some(holder) = self.locate(point, near) else { return near };
        self.carve(point, holder);
        let mut scratch = std::mem::take(&mut self.scratch);
        let done = self.fill(point, &mut scratch);
        self.scratch = scratch;
        done.unwrap_or(holder)
    }

    /// Walks from tetrahedron to tetrahedron towards the point.
    fn locate(&self, point: u32, start: u32) -> Option<u32> {
        let target = self.point(point);
        let (mut at, mut from) = (start, NONE);
        // A walk among Delaunay tetrahedra ends; the bound only guards against rounding.
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

    /// Collects the tetrahedra whose circumspheres hold the point, and the faces around them.
    fn carve(&mut self, point: u32, holder: u32) {
        let target = self.points[point as usize];
        let scratch = &mut self.scratch;
        let stamp = point + 1;
        scratch.cavity.clear();
        scratch.faces.clear();
        scratch.cavity.push(holder);
        scratch.seen[holder as usize] = (stamp, true);
        let mut index = 0;
        while index < scratch.cavity.len() {
            let t = &self.tetrahedra[scratch.cavity[index] as usize];
            index += 1;
            for (face, &beyond) in t.neighbours.iter().enumerate() {
                let inside = beyond != NONE && {
                    let seen = &mut scratch.seen[beyond as usize];
                    if seen.0 != stamp {
                        let other = &self.tetrahedra[beyond as usize];
                        *seen = (stamp, other.sphere_holds(&(target - self.points[other.corners[0] as usize])));
                        if seen.1 {
                            scratch.cavity.push(beyond);
                        }
                    }
                    seen.1
                };
                if !inside {
                    scratch.faces.push((FACES[face].map(|i| t.corners[i]), beyond));
                }
            }
        }
    }

    /// Puts tetrahedra from the point to the cavity's faces in place of the cavity; `None` (and nothing done) if rounding
    /// or a coinciding point would turn one of them inside out.
    fn fill(&mut self, point: u32, scratch: &mut Scratch) -> Option<u32> {
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
                    scratch.seen.push((0, false));
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

impl Tetrahedron {
    /// `None` unless positively oriented.
    #[inline]
    fn new(points: &[Point3<f64>], corners: [u32; 4]) -> Option<Self> {
        let [o, a, b, c] = corners.map(|corner| points[corner as usize]);
        let (a, b, c) = (a - o, b - o, c - o);
        let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
        let volume = a.dot(&bc);
        // Cramer's rule for the sphere through the four corners, multiplied by the volume.
        let linear = bc * a.norm_squared() + ca * b.norm_squared() + ab * c.norm_squared();
        (volume > 0.0).then_some(Self { corners, neighbours: [NONE; 4], linear: -linear, quadratic: volume })
    }

    #[inline]
    fn sphere_holds(&self, offset: &Vector3<f64>) -> bool {
        self.linear.dot(offset) + self.quadratic * offset.norm_squared() < 0.0
    }
}

/// A small shift, different for every point.
fn jitter(index: u32) -> Vector3<f64> {
    const RATIO: f64 = 1.220_744_084_605_759_5;
    let shift = |power: i32| (f64::from(index + 1) / RATIO.powi(power)).fract() - 0.5;
    Vector3::new(shift(1), shift(2), shift(3)) * (2.0 * JITTER)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn no_point_lies_inside_a_circumsphere(points in prop::collection::vec(prop::array::uniform3(-0.5..0.5f64), 1..60)) {
            let mut diagram = Delaunay::new();
            diagram.extend(points.iter().map(|&point| Point3::from(point)));
            let mut corners = vec![false; points.len() + HULL_POINTS as usize];
            for t in diagram.tetrahedra() {
                let center = diagram.circumcenter(t);
                let radius = (diagram.point(diagram.corners(t)[0]) - center).norm();
                for point in HULL_POINTS..diagram.next_number() {
                    prop_assert!((diagram.point(point) - center).norm() > radius * (1.0 - 1e-6));
                }
                diagram.corners(t).iter().for_each(|&corner| corners[corner as usize] = true);
            }
            prop_assert!(corners.into_iter().all(|used| used));
        }
    }

    #[test]
    fn points_on_a_common_plane_and_sphere_are_all_kept() {
        let grid = (0..6).flat_map(|x| (0..6).map(move |y| Point3::new(0.1 * f64::from(x), 0.1 * f64::from(y), 0.25)));
        let mut diagram = Delaunay::new();
        diagram.extend(grid);
        let corners: std::collections::BTreeSet<u32> = diagram.tetrahedra().flat_map(|t| *diagram.corners(t)).collect();
        assert_eq!(corners.len(), 36 + HULL_POINTS as usize);
    }
}
