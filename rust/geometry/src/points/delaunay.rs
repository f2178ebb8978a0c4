//! Delaunay tetrahedralisation of points, by incremental insertion (Bowyer and Watson).

mod edge_table;
mod insertion;
mod tetrahedron;

use nalgebra::{Point3, Vector3};

use insertion::Scratch;
use tetrahedron::{NONE, Tetrahedron};

use crate::points::quasi_random::quasi_random;

/// Typical number of tetrahedra per point, for which memory is reserved.
const TETRAHEDRA_PER_POINT: usize = 8;
/// Largest random shift of a coordinate. It separates points on a common plane or sphere.
const JITTER: f64 = 1e-8;
/// Number of corners of the hull. The indices of inserted points start here.
pub const HULL_POINTS: u32 = 4;
/// Corners of a tetrahedron that contains the box [-1, 1]^3 with a wide margin.
const HULL: [[f64; 3]; 4] = [[40.0, 40.0, 40.0], [40.0, -40.0, -40.0], [-40.0, 40.0, -40.0], [-40.0, -40.0, 40.0]];

/// Delaunay tetrahedra of points inside [-1, 1]^3 and of four points far around them.
#[derive(Clone)]
pub struct Delaunay {
    points: Vec<Point3<f64>>,
    tetrahedra: Vec<Tetrahedron>,
    /// Indices of deleted tetrahedra, for reuse.
    free: Vec<u32>,
    alive: Vec<bool>,
    /// A tetrahedron at the last inserted point.
    last: u32,
    scratch: Scratch,
}

impl Delaunay {
    /// Diagram without points: the hull alone.
    pub fn new() -> Self {
        let points: Vec<Point3<f64>> = HULL.map(|corner| Point3::from(Vector3::from(corner))).to_vec();
        let tetrahedra: Vec<Tetrahedron> = Tetrahedron::new(&points, [0, 1, 3, 2]).into_iter().collect();
        Self {
            points,
            tetrahedra,
            alive: vec![true],
            free: Vec::new(),
            last: 0,
            scratch: Scratch::for_one_tetrahedron(),
        }
    }

    /// Adds points under consecutive indices.
    ///
    /// Insertion is fast if consecutive points lie near each other. A point that coincides with another may be omitted.
    pub fn extend(&mut self, points: impl IntoIterator<Item = Point3<f64>>) {
        let points = points.into_iter();
        let expected = points.size_hint().0;
        self.points.reserve(expected);
        self.tetrahedra.reserve(TETRAHEDRA_PER_POINT * expected);
        self.alive.reserve(TETRAHEDRA_PER_POINT * expected);
        self.scratch.visited.reserve(TETRAHEDRA_PER_POINT * expected);
        for point in points {
            let number = self.points.len() as u32;
            self.points.push(point + jitter(number));
            self.last = self.insert(number, self.last);
        }
    }

    /// Index of the next point.
    pub fn next_number(&self) -> u32 {
        self.points.len() as u32
    }

    /// A point, with the small shift that puts the points in general position.
    pub fn point(&self, corner: u32) -> &Point3<f64> {
        &self.points[corner as usize]
    }

    /// Indices of the tetrahedra.
    pub fn tetrahedra(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.tetrahedra.len() as u32).filter(|&t| self.alive[t as usize])
    }

    /// Corners of a tetrahedron.
    pub fn corners(&self, tetrahedron: u32) -> &[u32; 4] {
        &self.tetrahedra[tetrahedron as usize].corners
    }

    /// Center of the circumsphere of a tetrahedron: a vertex of the Voronoi diagram.
    pub fn circumcenter(&self, tetrahedron: u32) -> Point3<f64> {
        let t = &self.tetrahedra[tetrahedron as usize];
        self.point(t.corners[0]) + t.circumcenter()
    }

    /// Writes the ring of tetrahedra around an edge of `start` to `ring`, in order, and returns true if it closes.
    ///
    /// Returns false if a tetrahedron of the ring has a smaller index than `start`. Each ring is thus found from one
    /// start only.
    pub fn ring(&self, start: u32, edge: [u32; 2], ring: &mut Vec<u32>) -> bool {
        ring.clear();
        let first = &self.tetrahedra[start as usize].corners;
        let Some(mut pivot) = first.iter().copied().find(|corner| !edge.contains(corner)) else { return false };
        let mut at = start;
        loop {
            ring.push(at);
            let t = &self.tetrahedra[at as usize];
            // The path leaves through the face with the edge and the pivot. The fourth corner is left behind.
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
}

/// A small shift, different for every point.
fn jitter(index: u32) -> Vector3<f64> {
    Vector3::from(quasi_random(index as usize, 0.0).map(|x| x - 0.5)) * (2.0 * JITTER)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn circumspheres_contain_no_other_point(points in prop::collection::vec(prop::array::uniform3(-0.5..0.5f64), 1..60)) {
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

    proptest! {
        #[test]
        fn tetrahedra_fill_the_hull_and_form_a_ring_around_every_inner_edge(
            points in prop::collection::vec(prop::array::uniform3(-0.5..0.5f64), 1..40),
        ) {
            let mut diagram = Delaunay::new();
            let volume = |diagram: &Delaunay, t: u32| {
                let [a, b, c, d] = diagram.corners(t).map(|corner| diagram.point(corner));
                (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
            };
            let hull = volume(&diagram, 0);
            diagram.extend(points.iter().map(|&point| Point3::from(point)));
            let filled: f64 = diagram.tetrahedra().map(|t| volume(&diagram, t)).sum();
            prop_assert!((filled / hull - 1.0).abs() < 1e-9);
            let mut rings = std::collections::BTreeMap::new();
            let mut ring = Vec::new();
            for t in diagram.tetrahedra() {
                let corners = *diagram.corners(t);
                for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
                    let edge = [corners[i].min(corners[j]), corners[i].max(corners[j])];
                    let around = rings.entry(edge).or_insert((0, 0));
                    around.0 += 1;
                    if diagram.ring(t, edge, &mut ring) {
                        around.1 += ring.len();
                        let has_edge = |&t: &u32| edge.iter().all(|corner| diagram.corners(t).contains(corner));
                        prop_assert!(ring.iter().all(has_edge));
                    }
                }
            }
            for (edge, (tetrahedra, ringed)) in rings {
                let of_hull = edge[1] < HULL_POINTS;
                prop_assert_eq!(ringed, if of_hull { 0 } else { tetrahedra });
            }
        }
    }

    #[test]
    fn coplanar_and_cospherical_points_are_kept() {
        let grid = (0..6).flat_map(|x| (0..6).map(move |y| Point3::new(0.1 * f64::from(x), 0.1 * f64::from(y), 0.25)));
        let mut diagram = Delaunay::new();
        diagram.extend(grid);
        let corners: std::collections::BTreeSet<u32> = diagram.tetrahedra().flat_map(|t| *diagram.corners(t)).collect();
        assert_eq!(corners.len(), 36 + HULL_POINTS as usize);
    }
}
