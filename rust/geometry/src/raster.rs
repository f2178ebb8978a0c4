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

/// A point on the image: column, row, and one over the depth, which is linear on the image of a plane.
///
/// In single precision, as what large meshes take is the time to read and write their corners.
type Corner = Vector3<f32>;

/// Up to so many pixels are tried one by one; the triangles of large meshes have no more.
const FEW_PIXELS: i32 = 6;

/// The corner of a vertex that is too near to be on the image.
const NOWHERE: Corner = Corner::new(f32::NAN, f32::NAN, f32::NAN);

/// Renders every part, moved by its transform (rows of an affine map into the camera's frame), row by row from the top: the
/// distance along the optical axis (0 where nothing is), and the part that is seen (-1 there). Both sides of a triangle are
/// seen. Of parts at the very same depth the first one is. `depths` and `shown` have one entry a pixel.
pub fn render(parts: &[Mesh], transforms: &[Matrix3x4<f64>], camera: &Pinhole, depths: &mut [f32], shown: &mut [i32]) {
    // nothing beyond the farthest depth is nearer than what a pixel starts with
    depths.fill((1.0 / camera.far as f32).next_down());
    shown.fill(-1);
    let mut canvas = Canvas { camera, nearness: depths, shown };
    let mut corners: Vec<Corner> = Vec::new();
    for (index, (part, transform)) in parts.iter().zip(transforms).enumerate() {
        let (linear, shift) = (transform.fixed_columns::<3>(0).into_owned(), transform.column(3).into_owned());
        let place = |vertex: &Point3<f64>| linear * vertex.coords + shift;
        corners.clear();
        corners.extend(part.vertices().iter().map(|vertex| canvas.corner(&place(vertex))));
        for face in part.faces() {
            let [a, b, c] = face.map(|i| corners[i as usize]);
            if a.z > 0.0 && b.z > 0.0 && c.z > 0.0 {
                canvas.fill([a, b, c], index as i32);
            } else {
                canvas.cut(face.map(|i| place(&part.vertices()[i as usize])), index as i32);
            }
        }
    }
    for (depth, part) in canvas.nearness.iter_mut().zip(canvas.shown) {
        *depth = if *part < 0 { 0.0 } else { 1.0 / *depth };
    }
}

struct Canvas<'a> {
    camera: &'a Pinhole,
    /// One over the depth of what is seen so far.
    nearness: &'a mut [f32],
    shown: &'a mut [i32],
}

impl Canvas<'_> {
    fn corner(&self, place: &Vector3<f64>) -> Corner {
        let Pinhole { focal, center, near, .. } = self.camera;
        if place.z < *near {
            return NOWHERE;
        }
        let nearness = 1.0 / place.z;
        let column = focal[0] * place.x * nearness + center[0];
        let row = focal[1] * place.y * nearness + center[1];
        Corner::new(column as f32, row as f32, nearness as f32)
    }

    /// Draws what of a triangle is not too near.
    fn cut(&mut self, triangle: [Vector3<f64>; 3], part: i32) {
        let near = self.camera.near;
        let mut corners: Vec<Corner> = Vec::with_capacity(4);
        for (i, a) in triangle.iter().enumerate() {
            let b = &triangle[(i + 1) % 3];
            if a.z >= near {
                corners.push(self.corner(a));
            }
            if (a.z >= near) != (b.z >= near) {
                let mut crossing = a + (b - a) * ((near - a.z) / (b.z - a.z));
                crossing.z = near;
                corners.push(self.corner(&crossing));
            }
        }
        for i in 2..corners.len() {
            self.fill([corners[0], corners[i - 1], corners[i]], part);
        }
    }

    /// Draws a triangle of the image: in every row, the pixels whose middles all three sides leave on the inside.
    fn fill(&mut self, [a, b, c]: [Corner; 3], part: i32) {
        let (top, bottom) = middles_within(a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y), self.camera.height);
        if top > bottom {
            return;
        }
        let (left, right) = middles_within(a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x), self.camera.width);
        if left > right {
            return;
        }
        let [a, b, c] = [a, b, c].map(|corner| corner.cast::<f64>());
        let area = area(&a, &b, &c);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let (b, c) = if area > 0.0 { (b, c) } else { (c, b) };
        if (right - left + 1) * (bottom - top + 1) <= FEW_PIXELS {
            for row in top..=bottom {
                for column in left..=right {
                    self.fill_pixel([a, b, c], column, row, part);
                }
            }
            return;
        }
        let per_area = 1.0 / area.abs();
        let slope_x = ((b.z - a.z) * (c.y - a.y) - (c.z - a.z) * (b.y - a.y)) * per_area;
        let slope_y = ((c.z - a.z) * (b.x - a.x) - (b.z - a.z) * (c.x - a.x)) * per_area;
        let sides = [Side::new(a, b), Side::new(b, c), Side::new(c, a)];
        for row in top..=bottom {
            let y = f64::from(row) + 0.5;
            let (mut first, mut last) = (f64::from(left), f64::from(right));
            for side in &sides {
                side.narrow(y, &mut first, &mut last);
            }
            let (first, last) = (ceil(first), floor(last));
            if first > last {
                continue;
            }
            let start = a.z + slope_x * (f64::from(first) + 0.5 - a.x) + slope_y * (y - a.y);
            let (start, step) = (start as f32, slope_x as f32);
            let offset = row as usize * self.camera.width;
            let span = offset + first as usize..offset + last as usize + 1;
            for (i, (nearness, shown)) in self.nearness[span.clone()].iter_mut().zip(&mut self.shown[span]).enumerate()
            {
                // without a branch, so that several pixels go at once
                let here = start + step * i as f32;
                let is_nearer = here > *nearness;
                *nearness = if is_nearer { here } else { *nearness };
                *shown = if is_nearer { part } else { *shown };
            }
        }
    }

    /// Draws one pixel of a triangle if its middle is inside, without what is worth its time for many pixels alone.
    fn fill_pixel(&mut self, [a, b, c]: [Vector3<f64>; 3], column: i32, row: i32, part: i32) {
        let middle = Vector3::new(f64::from(column) + 0.5, f64::from(row) + 0.5, 0.0);
        let shares = [area(&middle, &b, &c), area(&a, &middle, &c), area(&a, &b, &middle)];
        if shares.iter().any(|&share| share < 0.0) {
            return;
        }
        let sum: f64 = shares.iter().sum();
        let here = ((shares[0] * a.z + shares[1] * b.z + shares[2] * c.z) / sum) as f32;
        let pixel = row as usize * self.camera.width + column as usize;
        if here > self.nearness[pixel] {
            self.nearness[pixel] = here;
            self.shown[pixel] = part;
        }
    }
}

/// Twice the area of a triangle of the image; above zero where its corners go round as the axes do.
fn area(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// A side of a triangle of the image: where it goes down the inside is to its left, where it goes up to its right.
struct Side {
    from: Vector3<f64>,
    rise: f64,
    slope: f64,
}

impl Side {
    fn new(from: Vector3<f64>, to: Vector3<f64>) -> Self {
        let rise = to.y - from.y;
        Self { from, rise, slope: (to.x - from.x) / rise }
    }

    /// Leaves, of the pixels from `first` to `last` in the row with its middle at `y`, those that may be inside.
    fn narrow(&self, y: f64, first: &mut f64, last: &mut f64) {
        let crossing = self.from.x + self.slope * (y - self.from.y) - 0.5;
        if self.rise > 0.0 {
            *last = last.min(crossing);
        } else if self.rise < 0.0 {
            *first = first.max(crossing);
        }
    }
}

/// The first and the last of `count` pixels in a row whose middles lie from `low` to `high`; the last comes before the first
/// where there is none.
fn middles_within(low: f32, high: f32, count: usize) -> (i32, i32) {
    // of what is never negative the whole part is found fast, and it is that of value + 1/2 that counts middles up to a value
    let end = count as f32;
    let below = (low + 0.5).clamp(0.0, end + 1.0);
    let up_to = (high + 0.5).clamp(0.0, end);
    let whole = below as i32;
    let is_middle = whole as f32 == below;
    ((whole - i32::from(is_middle)).max(0), up_to as i32 - 1)
}

/// The largest integer up to `value`.
fn floor(value: f64) -> i32 {
    let whole = value as i32;
    whole.saturating_sub(i32::from(f64::from(whole) > value))
}

/// The smallest integer from `value` on.
fn ceil(value: f64) -> i32 {
    let whole = value as i32;
    whole.saturating_add(i32::from(f64::from(whole) < value))
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
        Ok((inside && (CAMERA.near..=CAMERA.far).contains(&depth)).then_some(depth))
    }

    fn soup() -> impl Strategy<Value = Vec<[Point3<f64>; 3]>> {
        let corner = (-3.0..3.0f64, -3.0..3.0f64, -1.0..7.0f64).prop_map(|(x, y, z)| Point3::new(x, y, z));
        prop::collection::vec(prop::array::uniform3(corner), 1..8)
    }

    fn picture(parts: &[Mesh], transforms: &[Matrix3x4<f64>]) -> (Vec<f32>, Vec<i32>) {
        let pixels = CAMERA.width * CAMERA.height;
        let (mut depths, mut shown) = (vec![f32::NAN; pixels], vec![7; pixels]);
        render(parts, transforms, &CAMERA, &mut depths, &mut shown);
        (depths, shown)
    }

    fn mesh(triangle: &[Point3<f64>; 3]) -> Mesh {
        Mesh::new(triangle.to_vec(), vec![[0, 1, 2]]).expect("a mesh")
    }

    proptest! {
        #[test]
        fn every_pixel_shows_the_nearest_triangle_on_the_ray_through_its_middle(triangles in soup()) {
            let parts: Vec<Mesh> = triangles.iter().map(mesh).collect();
            let (depths, shown) = picture(&parts, &vec![Matrix3x4::identity(); parts.len()]);
            for (pixel, (&depth, &part)) in depths.iter().zip(&shown).enumerate() {
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
        fn middles_within_two_limits_are_found(low in -4.0..20.0f32, length in 0.0..9.0f32, half in any::<bool>()) {
            let (low, high) = if half { (low.round() + 0.5, low.round() + 0.5 + length) } else { (low, low + length) };
            let inside: Vec<i32> = (0..12).filter(|&i| low <= i as f32 + 0.5 && i as f32 + 0.5 <= high).collect();
            let (first, last) = middles_within(low, high, 12);
            prop_assert_eq!((first..=last).collect::<Vec<_>>(), inside);
        }

        #[test]
        fn moving_parts_is_moving_their_vertices(triangles in soup(), by in prop::array::uniform3(-1.0..1.0f64)) {
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
    fn a_plate_across_the_view_is_seen_everywhere_at_its_depth() {
        let corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]| Point3::new(x, y, 2.0));
        let plate = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh");
        let (depths, shown) = picture(&[plate], &[Matrix3x4::identity()]);
        assert!(depths.iter().all(|d| (d - 2.0).abs() < 1e-6));
        assert!(shown.iter().all(|&part| part == 0));
    }
}
