//! Convex polyhedra cut by planes.

use nalgebra::{Point3, Vector3};

/// A face: where in the list of loops its corners stand, counter-clockwise seen from outside.
#[derive(Debug, Clone, Copy)]
struct Face {
    start: u32,
    len: u32,
}

/// A convex polyhedron that half-spaces are cut from, one plane at a time.
///
/// A corner is either kept or not, and a cut goes through exactly the edges between the two, so the surface stays closed
/// whatever rounding does; at worst it grows slivers.
#[derive(Debug, Clone, Default)]
pub struct ConvexPolyhedron {
    corners: Vec<Point3<f64>>,
    faces: Vec<Face>,
    loops: Vec<u32>,
    spare: Spare,
}

/// Buffers that a cut works in; the first three become the polyhedron.
#[derive(Debug, Clone, Default)]
struct Spare {
    corners: Vec<Point3<f64>>,
    faces: Vec<Face>,
    loops: Vec<u32>,
    /// Height of every old corner over the plane.
    heights: Vec<f64>,
    /// New numbers of the old corners that are kept.
    numbers: Vec<u32>,
    /// Cut edges: the kept corner, the dropped one, and the new corner between them.
    cuts: Vec<(u32, u32, u32)>,
    /// Edges of the new face.
    rim: Vec<(u32, u32)>,
}

impl Spare {
    /// The new corner on the edge from a kept corner to a dropped one; the edge's two faces share it.
    fn cut_edge(&mut self, old: &[Point3<f64>], kept: u32, dropped: u32) -> u32 {
        if let Some(cut) = self.cuts.iter().find(|cut| cut.0 == kept && cut.1 == dropped) {
            return cut.2;
        }
        let (below, above) = (self.heights[kept as usize], self.heights[dropped as usize]);
        let (from, to) = (old[kept as usize], old[dropped as usize]);
        let corner = self.corners.len() as u32;
        self.corners.push(from + (to - from) * (below / (below - above)));
        self.cuts.push((kept, dropped, corner));
        corner
    }
}

/// Corners of the faces of a box; bit 0, 1, 2 of a corner's number is its side along x, y, z.
const BOX_FACES: [[u32; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

impl ConvexPolyhedron {
    /// The box with the given centre and half edges, a right-handed triple.
    pub fn new_box(center: &Point3<f64>, half_edges: &[Vector3<f64>; 3]) -> Self {
        let corner = |corner: usize| {
            let side = |axis: usize| if corner >> axis & 1 == 1 { half_edges[axis] } else { -half_edges[axis] };
            center + side(0) + side(1) + side(2)
        };
        Self {
            corners: (0..8).map(corner).collect(),
            faces: (0..6).map(|face| Face { start: 4 * face, len: 4 }).collect(),
            loops: BOX_FACES.into_iter().flatten().collect(),
            spare: Spare::default(),
        }
    }

    /// Whether nothing is left.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Corners of the faces, counter-clockwise seen from outside.
    fn faces(&self) -> impl Iterator<Item = impl ExactSizeIterator<Item = Point3<f64>>> {
        self.faces.iter().map(|face| {
            let corners = &self.loops[face.start as usize..(face.start + face.len) as usize];
            corners.iter().map(|&corner| self.corners[corner as usize])
        })
    }

    /// Keeps what lies in `normal . x <= offset`; says whether anything was cut off.
    pub fn cut(&mut self, normal: &Vector3<f64>, offset: f64) -> bool {
        self.spare.heights.clear();
        self.spare.heights.extend(self.corners.iter().map(|corner| normal.dot(&corner.coords) - offset));
        if self.spare.heights.iter().all(|&height| height <= 0.0) {
            return false;
        }
        self.keep_corners();
        self.cut_faces();
        self.close();
        true
    }

    /// Collects the kept corners under their new numbers.
    fn keep_corners(&mut self) {
        let spare = &mut self.spare;
        spare.corners.clear();
        spare.numbers.clear();
        for (corner, &height) in spare.heights.iter().enumerate() {
            spare.numbers.push(spare.corners.len() as u32);
            if height <= 0.0 {
                spare.corners.push(self.corners[corner]);
            }
        }
        spare.cuts.clear();
    }

    /// Cuts every face, and notes the edges that the new face has to have.
    fn cut_faces(&mut self) {
        let spare = &mut self.spare;
        spare.faces.clear();
        spare.loops.clear();
        spare.rim.clear();
        for face in &self.faces {
            let corners = &self.loops[face.start as usize..(face.start + face.len) as usize];
            let start = spare.loops.len();
            let (mut left_at, mut entered_first) = (None, None);
            let mut from = corners[corners.len() - 1];
            for &to in corners {
                let (kept_from, kept_to) = (spare.heights[from as usize] <= 0.0, spare.heights[to as usize] <= 0.0);
                if kept_from && !kept_to {
                    let exit = spare.cut_edge(&self.corners, from, to);
                    spare.loops.push(exit);
                    left_at = Some(exit);
                } else if kept_to && !kept_from {
                    let entry = spare.cut_edge(&self.corners, to, from);
                    spare.loops.push(entry);
                    match left_at.take() {
                        Some(exit) => spare.rim.push((entry, exit)),
                        None => entered_first = Some(entry),
                    }
                }
                if kept_to {
                    spare.loops.push(spare.numbers[to as usize]);
                }
                from = to;
            }
            if let (Some(entry), Some(exit)) = (entered_first, left_at) {
                spare.rim.push((entry, exit));
            }
            let len = spare.loops.len() - start;
            if len > 0 {
                spare.faces.push(Face { start: start as u32, len: len as u32 });
            }
        }
    }

    /// Adds the new face (more than one only if rounding made the old surface dented) and takes the result over.
    fn close(&mut self) {
        let spare = &mut self.spare;
        while let Some((first, mut next)) = spare.rim.pop() {
            let start = spare.loops.len();
            spare.loops.push(first);
            while next != first {
                spare.loops.push(next);
                let Some(edge) = spare.rim.iter().position(|&(from, _)| from == next) else { break };
                next = spare.rim.swap_remove(edge).1;
            }
            spare.faces.push(Face { start: start as u32, len: (spare.loops.len() - start) as u32 });
        }
        std::mem::swap(&mut self.corners, &mut spare.corners);
        std::mem::swap(&mut self.faces, &mut spare.faces);
        std::mem::swap(&mut self.loops, &mut spare.loops);
    }

    /// Volume, by the divergence theorem around the first corner.
    pub fn volume(&self) -> f64 {
        let Some(apex) = self.corners.first() else { return 0.0 };
        let mut sum = 0.0;
        for corners in self.faces() {
            let mut corners = corners.map(|corner| corner - apex);
            let (Some(first), Some(mut last)) = (corners.next(), corners.next()) else { continue };
            for corner in corners {
                sum += first.dot(&last.cross(&corner));
                last = corner;
            }
        }
        (sum / 6.0).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn unit_box() -> ConvexPolyhedron {
        ConvexPolyhedron::new_box(&Point3::origin(), &[Vector3::x() * 0.5, Vector3::y() * 0.5, Vector3::z() * 0.5])
    }

    proptest! {
        #[test]
        fn the_two_sides_of_a_cut_have_the_volume_of_the_whole(planes in prop::collection::vec(prop::array::uniform4(-0.6..0.6f64), 1..12)) {
            let mut solid = unit_box();
            for [x, y, z, offset] in planes {
                let normal = Vector3::new(x, y, z);
                let (mut rest, whole) = (solid.clone(), solid.volume());
                solid.cut(&normal, offset);
                rest.cut(&-normal, -offset);
                prop_assert!((solid.volume() + rest.volume() - whole).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_corner_cut_off_is_a_tetrahedron_and_its_cut_a_triangle() {
        let mut solid = unit_box();
        assert!(!solid.cut(&Vector3::new(1.0, 1.0, 1.0), 1.5));
        assert!(solid.cut(&-Vector3::new(1.0, 1.0, 1.0), -0.6));
        assert!((solid.volume() - 0.9f64.powi(3) / 6.0).abs() < 1e-15);
        assert_eq!(solid.faces().map(|corners| corners.len()).collect::<Vec<_>>(), [3; 4]);
        assert!(solid.cut(&Vector3::x(), -1.0) && solid.is_empty());
        assert_eq!(solid.volume(), 0.0);
    }
}
