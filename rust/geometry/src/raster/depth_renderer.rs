//! Depth images and part images of moved parts, by a z-buffer.

use nalgebra::{Matrix3x4, Point3, Vector3};

use crate::Mesh;
use crate::raster::z_buffer::{BoundedTriangle, Corner, ZBuffer};

/// A pinhole camera without distortion. It looks along +z, with x to the right and y down.
///
/// The point (x, y, z) projects to column `fx x / z + cx` and row `fy y / z + cy`. The pixel (i, j) has its center at
/// column `i + 1/2` and row `j + 1/2`. Surfaces nearer than `near` or farther than `far` are invisible.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pinhole {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Focal lengths in pixels.
    pub focal: [f64; 2],
    /// Column and row of the optical axis.
    pub center: [f64; 2],
    /// Smallest visible depth, above zero.
    pub near: f64,
    /// Largest visible depth.
    pub far: f64,
}

/// Marker for a vertex in front of the near plane. All other corners have a positive inverse depth.
const NOWHERE: Corner = Corner::ZERO;

/// Faces per batch. Finding the visible faces of a batch before drawing them keeps the branches of both loops
/// predictable.
const BATCH: usize = 128;

/// Renders all parts into `depths` and `part_ids`, one entry per pixel, row by row from the top.
///
/// A transform holds the rows of an affine map into the camera's frame. A depth is a distance along the optical axis,
/// or 0 where there is nothing. A part index is -1 where there is nothing. Both sides of a triangle are visible. Among
/// parts at the same depth the first one wins.
pub fn render(
    parts: &[Mesh],
    transforms: &[Matrix3x4<f64>],
    camera: &Pinhole,
    depths: &mut [f32],
    part_ids: &mut [i32],
) {
    // The initial value is just beyond the largest visible depth.
    depths.fill((1.0 / camera.far as f32).next_down());
    part_ids.fill(-1);
    let mut buffer = ZBuffer::new(camera.width, camera.height, depths, part_ids);
    for (index, (part, transform)) in parts.iter().zip(transforms).enumerate() {
        draw(part, transform, index as i32, camera, &mut buffer);
    }
    for (depth, part) in depths.iter_mut().zip(part_ids) {
        *depth = if *part < 0 { 0.0 } else { 1.0 / *depth };
    }
}

/// Draws a moved part where it is nearer than the image so far.
fn draw(part: &Mesh, transform: &Matrix3x4<f64>, index: i32, camera: &Pinhole, buffer: &mut ZBuffer) {
    let (linear, shift) = (transform.fixed_columns::<3>(0).into_owned(), transform.column(3).into_owned());
    let place = |vertex: &Point3<f64>| linear * vertex.coords + shift;
    let corners: Vec<Corner> = part.vertices().iter().map(|vertex| camera.corner(&place(vertex))).collect();
    let mut batch = [BoundedTriangle::default(); BATCH];
    for faces in part.faces().chunks(BATCH) {
        let mut count = 0;
        for face in faces {
            let triangle = face.map(|i| corners[i as usize]);
            if triangle.iter().all(|corner| corner.to_array()[2] > 0.0) {
                // There is no branch here, because the processor could not predict it.
                batch[count] = buffer.bound(triangle);
                count += usize::from(!batch[count].is_empty());
            } else {
                for triangle in camera.cut(face.map(|i| place(&part.vertices()[i as usize]))) {
                    buffer.fill(&buffer.bound(triangle), index);
                }
            }
        }
        for triangle in &batch[..count] {
            buffer.fill(triangle, index);
        }
    }
}

impl Pinhole {
    /// Projection of a point in the camera's frame.
    fn corner(&self, place: &Vector3<f64>) -> Corner {
        let Self { focal, center, near, .. } = self;
        if place.z < *near {
            return NOWHERE;
        }
        let inverse_depth = 1.0 / place.z;
        let column = focal[0] * place.x * inverse_depth + center[0];
        let row = focal[1] * place.y * inverse_depth + center[1];
        Corner::from([column as f32, row as f32, inverse_depth as f32, 0.0])
    }

    /// The part of a triangle behind the near plane, as triangles in the image.
    fn cut(&self, triangle: [Vector3<f64>; 3]) -> impl Iterator<Item = [Corner; 3]> {
        let mut corners: Vec<Corner> = Vec::with_capacity(4);
        for (i, a) in triangle.iter().enumerate() {
            let b = &triangle[(i + 1) % 3];
            if a.z >= self.near {
                corners.push(self.corner(a));
            }
            if (a.z >= self.near) != (b.z >= self.near) {
                let mut crossing = a + (b - a) * ((self.near - a.z) / (b.z - a.z));
                crossing.z = self.near;
                corners.push(self.corner(&crossing));
            }
        }
        (2..corners.len()).map(move |i| [corners[0], corners[i - 1], corners[i]])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const CAMERA: Pinhole =
        Pinhole { width: 24, height: 16, focal: [20.0, 18.0], center: [12.3, 7.6], near: 0.2, far: 6.0 };
    /// Tolerance for rays near a triangle's edge, which may count as a hit or a miss.
    const EDGE: f64 = 1e-6;

    /// Depth at which the ray through a pixel center meets a triangle (`None`: a miss), or an error where rounding
    /// decides.
    fn hit(triangle: &[Point3<f64>; 3], ray: &Vector3<f64>) -> std::result::Result<Option<f64>, ()> {
        let [a, b, c] = triangle.map(|p| p.coords);
        let normal = (b - a).cross(&(c - a));
        let volumes = [ray.dot(&b.cross(&c)), ray.dot(&c.cross(&a)), ray.dot(&a.cross(&b))];
        if volumes.iter().any(|v| v.abs() < EDGE) || normal.dot(ray).abs() < EDGE {
            return Err(());
        }
        let inside = volumes.iter().all(|v| *v > 0.0) || volumes.iter().all(|v| *v < 0.0);
        let depth = normal.dot(&a) / normal.dot(ray);
        if inside && ((depth - CAMERA.near).abs() < EDGE || (depth - CAMERA.far).abs() < 1e-3) {
            return Err(());
        }
        Ok((inside && (CAMERA.near..=CAMERA.far).contains(&depth)).then_some(depth))
    }

    fn random_triangles() -> impl Strategy<Value = Vec<[Point3<f64>; 3]>> {
        let corner = (-3.0..3.0f64, -3.0..3.0f64, -1.0..7.0f64).prop_map(|(x, y, z)| Point3::new(x, y, z));
        prop::collection::vec(prop::array::uniform3(corner), 1..8)
    }

    fn picture(parts: &[Mesh], transforms: &[Matrix3x4<f64>]) -> (Vec<f32>, Vec<i32>) {
        let pixels = CAMERA.width * CAMERA.height;
        let (mut depths, mut part_ids) = (vec![f32::NAN; pixels], vec![7; pixels]);
        render(parts, transforms, &CAMERA, &mut depths, &mut part_ids);
        (depths, part_ids)
    }

    fn mesh(triangle: &[Point3<f64>; 3]) -> Mesh {
        Mesh::new(triangle.to_vec(), vec![[0, 1, 2]]).expect("a mesh")
    }

    proptest! {
        #[test]
        fn every_pixel_shows_the_nearest_triangle_on_its_ray(triangles in random_triangles()) {
            let parts: Vec<Mesh> = triangles.iter().map(mesh).collect();
            let (depths, part_ids) = picture(&parts, &vec![Matrix3x4::identity(); parts.len()]);
            for (pixel, (&depth, &part)) in depths.iter().zip(&part_ids).enumerate() {
                let column = (pixel % CAMERA.width) as f64 + 0.5;
                let row = (pixel / CAMERA.width) as f64 + 0.5;
                let ray = Vector3::new(
                    (column - CAMERA.center[0]) / CAMERA.focal[0], (row - CAMERA.center[1]) / CAMERA.focal[1], 1.0,
                );
                let Ok(hits) = triangles.iter().map(|t| hit(t, &ray)).collect::<std::result::Result<Vec<_>, ()>>() else {
                    continue;
                };
                let nearest = hits.iter().flatten().copied().fold(f64::INFINITY, f64::min);
                if nearest.is_finite() {
                    prop_assert!((f64::from(depth) - nearest).abs() < 1e-4 * nearest, "{depth} {nearest}");
                    prop_assert!(hits[part as usize].is_some_and(|own| own - nearest < 1e-4 * nearest));
                } else {
                    prop_assert_eq!((depth, part), (0.0, -1));
                }
            }
        }

        #[test]
        fn a_sheet_of_triangles_has_no_holes(
            cells in 1usize..40, bumps in prop::collection::vec(prop::array::uniform3(-0.3..0.3f64), 41 * 41),
        ) {
            // The sheet is wider than the view, and the bumps do not fold it.
            let cell = 6.0 / cells as f64;
            let corners = (0..=cells).flat_map(|i| (0..=cells).map(move |j| (i, j))).zip(&bumps).map(|((i, j), bump)| {
                Point3::new(cell * i as f64 - 3.0, cell * j as f64 - 3.0, 2.0) + cell.min(1.0) * Vector3::from(*bump)
            });
            let below = |k: usize| (k + cells + 1) as u32;
            let faces = (0..cells * (cells + 1)).filter(|k| k % (cells + 1) < cells).flat_map(|k| {
                [[k as u32, below(k), below(k) + 1], [k as u32, below(k) + 1, k as u32 + 1]]
            });
            let sheet = Mesh::new(corners.collect(), faces.collect()).expect("a mesh");
            let (depths, part_ids) = picture(&[sheet], &[Matrix3x4::identity()]);
            prop_assert!(part_ids.iter().all(|&part| part == 0));
            prop_assert!(depths.iter().all(|depth| (1.7..=2.3).contains(depth)));
        }

        #[test]
        fn a_transform_moves_the_vertices(triangles in random_triangles(), by in prop::array::uniform3(-1.0..1.0f64)) {
            let shift = Vector3::from(by);
            let parts: Vec<Mesh> = triangles.iter().map(mesh).collect();
            let moved: Vec<Mesh> = triangles.iter().map(|t| mesh(&t.map(|p| p + shift))).collect();
            let mut transform = Matrix3x4::identity();
            transform.set_column(3, &shift);
            let first = picture(&parts, &vec![transform; parts.len()]);
            prop_assert_eq!(first, picture(&moved, &vec![Matrix3x4::identity(); parts.len()]));
        }
    }

    #[test]
    fn a_plate_across_the_view_fills_the_image_at_its_depth() {
        let corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]| Point3::new(x, y, 2.0));
        let plate = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh");
        let (depths, part_ids) = picture(&[plate], &[Matrix3x4::identity()]);
        assert!(depths.iter().all(|d| (d - 2.0).abs() < 1e-6));
        assert!(part_ids.iter().all(|&part| part == 0));
    }
}
