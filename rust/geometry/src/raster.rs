//! Depth and part images of moved parts, by a z-buffer.

use nalgebra::{Matrix3x4, Point3, Vector3};

use crate::Mesh;

/// A camera without distortion that looks along +z, with x to the right and y down.
///
/// The point (x, y, z) is seen at column `fx x / z + cx` and row `fy y / z + cy`; the pixel (i, j) is the one whose middle is
/// at column `i + 1/2` and row `j + 1/2`. What is nearer than `near` or farther than `far` is not seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pinhole {
    /// Columns of an image.
    pub width: usize,
    /// Rows of an image.
    pub height: usize,
    /// Focal lengths in pixels.
    pub focal: [f64; 2],
    /// Column and row of the optical axis.
    pub center: [f64; 2],
    /// Smallest depth that is seen; above zero.
    pub near: f64,
    /// Largest depth that is seen.
    pub far: f64,
}

/// What a camera sees, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Distance along the optical axis; 0 where nothing is.
    pub depths: Vec<f32>,
    /// The part that is seen; -1 where nothing is.
    pub parts: Vec<i32>,
}

/// A corner on the image: column, row, and one over the depth, which is linear on the image of a plane.
type Corner = Vector3<f64>;

/// Renders every part, moved by its transform (rows of an affine map into the camera's frame). Both sides of a triangle are
/// seen. Of parts at the very same depth the first one is.
pub fn render(parts: &[Mesh], transforms: &[Matrix3x4<f64>], camera: &Pinhole) -> Image {
    let pixels = camera.width * camera.height;
    let mut canvas = Canvas { camera: *camera, nearness: vec![0.0; pixels], parts: vec![-1; pixels] };
    let mut moved: Vec<Point3<f64>> = Vec::new();
    for (index, (part, transform)) in parts.iter().zip(transforms).enumerate() {
        moved.clear();
        moved.extend(part.vertices().iter().map(|vertex| Point3::from(transform * vertex.to_homogeneous())));
        for face in part.faces() {
            canvas.draw(face.map(|i| moved[i as usize]), index as i32);
        }
    }
    let depths = canvas.nearness.iter().map(|&n| if n > 0.0 { 1.0 / n } else { 0.0 }).collect();
    Image { depths, parts: canvas.parts }
}

struct Canvas {
    camera: Pinhole,
    /// One over the depth of what is seen so far; 0 where nothing is.
    nearness: Vec<f32>,
    parts: Vec<i32>,
}

impl Canvas {
    /// Draws a triangle of the camera's frame, cut off where it comes nearer than the camera sees.
    fn draw(&mut self, triangle: [Point3<f64>; 3], part: i32) {
        let near = self.camera.near;
        let behind = triangle.iter().filter(|corner| corner.z < near).count();
        match behind {
            0 => self.fill(triangle.map(|corner| self.project(&corner)), part),
            3 => {}
            _ => {
                let mut cut: Vec<Corner> = Vec::with_capacity(4);
                for (i, a) in triangle.iter().enumerate() {
                    let b = &triangle[(i + 1) % 3];
                    if a.z >= near {
                        cut.push(self.project(a));
                    }
                    if (a.z >= near) != (b.z >= near) {
                        let mut crossing = a + (b - a) * ((near - a.z) / (b.z - a.z));
                        crossing.z = near;
                        cut.push(self.project(&crossing));
                    }
                }
                for i in 2..cut.len() {
                    self.fill([cut[0], cut[i - 1], cut[i]], part);
                }
            }
        }
    }

    fn project(&self, point: &Point3<f64>) -> Corner {
        let Pinhole { focal, center, .. } = self.camera;
        let nearness = 1.0 / point.z;
        Corner::new(focal[0] * point.x * nearness + center[0], focal[1] * point.y * nearness + center[1], nearness)
    }

    /// Draws a triangle of the image: in every row, the pixels whose middles all three sides leave on the inside.
    fn fill(&mut self, [a, b, c]: [Corner; 3], part: i32) {
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let (b, c) = if area > 0.0 { (b, c) } else { (c, b) };
        let area = area.abs();
        let (width, height) = (self.camera.width as f64, self.camera.height as f64);
        // the first and last middles within, as pixels
        let pixel = |value: f64, limit: f64| (value - 0.5).clamp(-1.0, limit);
        let left = pixel(a.x.min(b.x).min(c.x), width).ceil();
        let right = pixel(a.x.max(b.x).max(c.x), width - 1.0).floor();
        let top = pixel(a.y.min(b.y).min(c.y), height).ceil().max(0.0);
        let bottom = pixel(a.y.max(b.y).max(c.y), height - 1.0).floor();
        let left = left.max(0.0);
        if left > right || top > bottom {
            return;
        }
        let slope_x = ((b.z - a.z) * (c.y - a.y) - (c.z - a.z) * (b.y - a.y)) / area;
        let slope_y = ((c.z - a.z) * (b.x - a.x) - (b.z - a.z) * (c.x - a.x)) / area;
        let least = (1.0 / self.camera.far) as f32;
        let sides = [(a, b), (b, c), (c, a)];
        for row in top as usize..=bottom as usize {
            let y = row as f64 + 0.5;
            let (mut first, mut last) = (left, right);
            for (from, to) in sides {
                // inside: (to - from) x (p - from) >= 0
                let (dx, dy) = (to.x - from.x, to.y - from.y);
                let at = dx * (y - from.y);
                if dy > 0.0 {
                    last = last.min((at / dy + from.x - 0.5).floor());
                } else if dy < 0.0 {
                    first = first.max((at / dy + from.x - 0.5).ceil());
                } else if at < 0.0 {
                    last = -1.0;
                }
            }
            if first > last {
                continue;
            }
            let (first, last) = (first as usize, last as usize);
            let start = a.z + slope_x * (first as f64 + 0.5 - a.x) + slope_y * (y - a.y);
            let (start, step) = (start as f32, slope_x as f32);
            let span = row * self.camera.width + first..row * self.camera.width + last + 1;
            let seen = self.nearness[span.clone()].iter_mut().zip(&mut self.parts[span]);
            for (i, (nearness, shown)) in seen.enumerate() {
                let here = start + step * i as f32;
                if here > *nearness && here >= least {
                    *nearness = here;
                    *shown = part;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const CAMERA: Pinhole =
        Pinhole { width: 24, height: 16, focal: [20.0, 18.0], center: [12.3, 7.6], near: 0.2, far: 6.0 };
    /// Rays that pass so near to a triangle's edge may go either way.
    const EDGE: f64 = 1e-6;

    /// Depth at which a ray through the middle of a pixel meets a triangle (None: not), unless that is a matter of rounding.
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
        Ok((inside && depth >= CAMERA.near && depth <= CAMERA.far).then_some(depth))
    }

    fn soup() -> impl Strategy<Value = Vec<[Point3<f64>; 3]>> {
        let corner = (-3.0..3.0f64, -3.0..3.0f64, -1.0..7.0f64).prop_map(|(x, y, z)| Point3::new(x, y, z));
        prop::collection::vec(prop::array::uniform3(corner), 1..8)
    }

    fn mesh(triangle: &[Point3<f64>; 3]) -> Mesh {
        Mesh::new(triangle.to_vec(), vec![[0, 1, 2]]).unwrap()
    }

    proptest! {
        #[test]
        fn every_pixel_shows_the_nearest_triangle_on_the_ray_through_its_middle(triangles in soup()) {
            let parts: Vec<Mesh> = triangles.iter().map(mesh).collect();
            let image = render(&parts, &vec![Matrix3x4::identity(); parts.len()], &CAMERA);
            for (pixel, (&depth, &part)) in image.depths.iter().zip(&image.parts).enumerate() {
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
        fn moving_parts_is_moving_their_vertices(triangles in soup(), by in prop::array::uniform3(-1.0..1.0f64)) {
            let shift = Vector3::from(by);
            let parts: Vec<Mesh> = triangles.iter().map(mesh).collect();
            let moved: Vec<Mesh> = triangles.iter().map(|t| mesh(&t.map(|p| p + shift))).collect();
            let mut transform = Matrix3x4::identity();
            transform.set_column(3, &shift);
            let first = render(&parts, &vec![transform; parts.len()], &CAMERA);
            prop_assert_eq!(first, render(&moved, &vec![Matrix3x4::identity(); parts.len()], &CAMERA));
        }
    }

    #[test]
    fn a_plate_across_the_view_is_seen_everywhere_at_its_depth() {
        let corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]| Point3::new(x, y, 2.0));
        let plate = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let image = render(&[plate], &[Matrix3x4::identity()], &CAMERA);
        assert!(image.depths.iter().all(|d| (d - 2.0).abs() < 1e-6));
        assert!(image.parts.iter().all(|&part| part == 0));
    }
}
