//! Convex polyhedra clipped by planes.

use nalgebra::{Point3, Vector3};

/// A face: the position of its corners in the list of loops, counter-clockwise seen from outside.
#[derive(Debug, Clone, Copy)]
struct FaceLoop {
    start: u32,
    len: u32,
}

/// A convex polyhedron that is clipped by half-spaces, one plane at a time.
///
/// Every corner is either kept or dropped, and a cut passes through exactly the edges between the two kinds. The
/// surface therefore stays closed under rounding errors. At worst it grows slivers.
#[derive(Debug, Clone, Default)]
pub struct ConvexPolyhedron {
    corners: Vec<Point3<f64>>,
    faces: Vec<FaceLoop>,
    loops: Vec<u32>,
    buffers: ClipBuffers,
}

/// Buffers for a cut. The first three become the new polyhedron.
#[derive(Debug, Clone, Default)]
struct ClipBuffers {
    corners: Vec<Point3<f64>>,
    faces: Vec<FaceLoop>,
    loops: Vec<u32>,
    /// Height of every old corner over the plane.
    heights: Vec<f64>,
    /// New indices of the kept corners.
    numbers: Vec<u32>,
    /// Cut edges: the kept corner, the dropped corner, and the new corner between them.
    cuts: Vec<(u32, u32, u32)>,
    /// Edges of the new face.
    rim: Vec<(u32, u32)>,
}

impl ClipBuffers {
    /// New corner on the edge from a kept corner to a dropped one. The two faces of the edge share it.
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

/// Corners of the faces of a box. Bits 0, 1 and 2 of a corner's index give its side along x, y and z.
const BOX_FACES: [[u32; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

impl ConvexPolyhedron {
    /// Box with the given center and half edges, which form a right-handed triple.
    pub fn new_box(center: &Point3<f64>, half_edges: &[Vector3<f64>; 3]) -> Self {
        let corner = |corner: usize| {
            let side = |axis: usize| if corner >> axis & 1 == 1 { half_edges[axis] } else { -half_edges[axis] };
            center + side(0) + side(1) + side(2)
        };
        Self {
            corners: (0..8).map(corner).collect(),
            faces: (0..6).map(|face| FaceLoop { start: 4 * face, len: 4 }).collect(),
            loops: BOX_FACES.into_iter().flatten().collect(),
            buffers: ClipBuffers::default(),
        }
    }

    /// True if nothing is left.
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

    /// Keeps the half-space `normal . x <= offset`, and returns true if anything was cut off.
    pub fn cut(&mut self, normal: &Vector3<f64>, offset: f64) -> bool {
        self.buffers.heights.clear();
        self.buffers.heights.extend(self.corners.iter().map(|corner| normal.dot(&corner.coords) - offset));
        if self.buffers.heights.iter().all(|&height| height <= 0.0) {
            return false;
        }
        self.keep_corners();
        self.cut_faces();
        self.close();
        true
    }

    /// Collects the kept corners under their new indices.
    fn keep_corners(&mut self) {
        let buffers = &mut self.buffers;
        buffers.corners.clear();
        buffers.numbers.clear();
        for (corner, &height) in buffers.heights.iter().enumerate() {
            buffers.numbers.push(buffers.corners.len() as u32);
            if height <= 0.0 {
                buffers.corners.push(self.corners[corner]);
            }
        }
        buffers.cuts.clear();
    }

    /// Clips every face, and collects the edges of the new face.
    fn cut_faces(&mut self) {
        let buffers = &mut self.buffers;
        buffers.faces.clear();
        buffers.loops.clear();
        buffers.rim.clear();
        for face in &self.faces {
            let corners = &self.loops[face.start as usize..(face.start + face.len) as usize];
            let start = buffers.loops.len();
            let (mut left_at, mut entered_first) = (None, None);
            let mut from = corners[corners.len() - 1];
            for &to in corners {
                let (kept_from, kept_to) = (buffers.heights[from as usize] <= 0.0, buffers.heights[to as usize] <= 0.0);
                if kept_from && !kept_to {
                    let exit = buffers.cut_edge(&self.corners, from, to);
                    buffers.loops.push(exit);
                    left_at = Some(exit);
                } else if kept_to && !kept_from {
                    let entry = buffers.cut_edge(&self.corners, to, from);
                    buffers.loops.push(entry);
                    match left_at.take() {
                        Some(exit) => buffers.rim.push((entry, exit)),
                        None => entered_first = Some(entry),
                    }
                }
                if kept_to {
                    buffers.loops.push(buffers.numbers[to as usize]);
                }
                from = to;
            }
            if let (Some(entry), Some(exit)) = (entered_first, left_at) {
                buffers.rim.push((entry, exit));
            }
            let len = buffers.loops.len() - start;
            if len > 0 {
                buffers.faces.push(FaceLoop { start: start as u32, len: len as u32 });
            }
        }
    }

    /// Closes the surface with the new face, and adopts the result.
    ///
    /// There are several new faces only if rounding had made the old surface slightly concave.
    fn close(&mut self) {
        let buffers = &mut self.buffers;
        while let Some((first, mut next)) = buffers.rim.pop() {
            let start = buffers.loops.len();
            buffers.loops.push(first);
            while next != first {
                buffers.loops.push(next);
                let Some(edge) = buffers.rim.iter().position(|&(from, _)| from == next) else { break };
                next = buffers.rim.swap_remove(edge).1;
            }
            buffers.faces.push(FaceLoop { start: start as u32, len: (buffers.loops.len() - start) as u32 });
        }
        std::mem::swap(&mut self.corners, &mut buffers.corners);
        std::mem::swap(&mut self.faces, &mut buffers.faces);
        std::mem::swap(&mut self.loops, &mut buffers.loops);
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
        fn the_two_sides_of_a_cut_add_up_to_the_whole_volume(planes in prop::collection::vec(prop::array::uniform4(-0.6..0.6f64), 1..12)) {
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
    fn a_clipped_corner_is_a_tetrahedron() {
        let mut solid = unit_box();
        assert!(!solid.cut(&Vector3::new(1.0, 1.0, 1.0), 1.5));
        assert!(solid.cut(&-Vector3::new(1.0, 1.0, 1.0), -0.6));
        assert!((solid.volume() - 0.9f64.powi(3) / 6.0).abs() < 1e-15);
        assert_eq!(solid.faces().map(|corners| corners.len()).collect::<Vec<_>>(), [3; 4]);
        assert!(solid.cut(&Vector3::x(), -1.0) && solid.is_empty());
        assert_eq!(solid.volume(), 0.0);
    }
}
