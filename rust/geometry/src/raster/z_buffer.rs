//! Z-buffer: inverse depth and part of every pixel.

use nalgebra::Vector3;
use wide::{bytemuck, f32x4, i32x4};

/// A corner in the image: column, row, inverse depth and an unused entry. Inverse depth is linear over the image of a
/// plane.
///
/// Single precision halves the time to read and write the corners of large meshes. Four entries make bounds fast: most
/// triangles are tiny and cover no pixel center.
pub type Corner = f32x4;

/// Largest extent in pixels of triangles that are tested pixel by pixel, four at a time. Larger ones are filled row by
/// row.
const NARROW: i32 = 16;
const LANES: usize = 4;

/// A triangle in the image, with the range of pixels whose centers lie within its bounds.
#[derive(Clone, Copy, Default)]
pub struct BoundedTriangle {
    corners: [Corner; 3],
    /// First column and row, and two unused entries.
    first: i32x4,
    /// Last column and row. One of them precedes the first if the range is empty.
    last: i32x4,
}

impl BoundedTriangle {
    /// True if no pixel center lies within the bounds.
    pub fn is_empty(&self) -> bool {
        (self.last - self.first).to_bitmask() & 0b11 != 0
    }
}

/// Inverse depth and part of every pixel, row by row.
pub struct ZBuffer<'a> {
    width: usize,
    size: f32x4,
    inverse_depth: &'a mut [f32],
    part_ids: &'a mut [i32],
}

impl<'a> ZBuffer<'a> {
    /// Z-buffer of `height` rows of `width` pixels, over existing images of inverse depths and parts.
    pub fn new(width: usize, height: usize, inverse_depth: &'a mut [f32], part_ids: &'a mut [i32]) -> Self {
        Self { width, size: f32x4::from([width as f32, height as f32, 0.0, 0.0]), inverse_depth, part_ids }
    }

    /// A triangle with the range of pixels that it may cover.
    pub fn bound(&self, corners: [Corner; 3]) -> BoundedTriangle {
        let [a, b, c] = corners;
        let (first, last) = centers_within(a.fast_min(b).fast_min(c), a.fast_max(b).fast_max(c), self.size);
        BoundedTriangle { corners, first, last }
    }

    /// Draws a triangle where it is nearer than the image so far. It covers pixels whose centers lie inside all three
    /// edges.
    pub fn fill(&mut self, triangle: &BoundedTriangle, part: i32) {
        if triangle.is_empty() {
            return;
        }
        let ([left, top, ..], [right, bottom, ..]) = (triangle.first.to_array(), triangle.last.to_array());
        if (right - left).max(bottom - top) < NARROW && self.width >= LANES {
            self.fill_narrow(triangle, part);
        } else {
            self.fill_rows(triangle, part);
        }
    }

    /// Tests all pixels within the bounds.
    ///
    /// The edge function of a pixel changes only its sign, to the last bit, if the edge is traversed the other way. No
    /// pixel is therefore lost between two triangles that share an edge.
    fn fill_narrow(&mut self, triangle: &BoundedTriangle, part: i32) {
        let ([left, top, ..], [right, bottom, ..]) = (triangle.first.to_array(), triangle.last.to_array());
        let [a, b, c] = triangle.corners.map(|corner| corner.to_array());
        let [a_near, b_near, c_near] = [a, b, c].map(|[_, _, inverse_depth, _]| f32x4::splat(inverse_depth));
        let nearest = a_near.fast_max(b_near).fast_max(c_near);
        let part = i32x4::splat(part);
        for start in (left..=right).step_by(LANES) {
            let column = start.min((self.width - LANES) as i32);
            let x = f32x4::splat(column as f32) + f32x4::from([0.5, 1.5, 2.5, 3.5]);
            let [ax, bx, cx] = [a, b, c].map(|[column, ..]| f32x4::splat(column) - x);
            for row in top..=bottom {
                let pixel = row as usize * self.width + column as usize;
                let (Some(inverse_depth), Some(part_ids)) =
                    (self.inverse_depth[pixel..].first_chunk_mut(), self.part_ids[pixel..].first_chunk_mut())
                else {
                    return;
                };
                let before = f32x4::from(*inverse_depth);
                if !nearest.simd_gt(before).any() {
                    continue;
                }
                let y = row as f32 + 0.5;
                let [ay, by, cy] = [a, b, c].map(|[_, row, ..]| f32x4::splat(row - y));
                let areas = [bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx];
                let per_sum = f32x4::ONE / (areas[0] + areas[1] + areas[2]);
                let [of_a, of_b, of_c] = areas.map(|area| area * per_sum);
                let here = of_a * a_near + of_b * b_near + of_c * c_near;
                let is_inside = of_a.fast_min(of_b).fast_min(of_c).simd_ge(f32x4::ZERO);
                let is_seen = is_inside & here.simd_gt(before);
                if is_seen.any() {
                    *inverse_depth = is_seen.bitselect(here, before).into();
                    let is_seen: i32x4 = bytemuck::cast(is_seen);
                    *part_ids = is_seen.bitselect(part, i32x4::from(*part_ids)).into();
                }
            }
        }
    }

    /// Finds the first and the last pixel inside, row by row.
    fn fill_rows(&mut self, triangle: &BoundedTriangle, part: i32) {
        let ([left, top, ..], [right, bottom, ..]) = (triangle.first.to_array(), triangle.last.to_array());
        let [a, b, c] = triangle.corners.map(|corner| {
            let [column, row, inverse_depth, _] = corner.to_array();
            Vector3::new(column, row, inverse_depth).cast::<f64>()
        });
        let area = area(&a, &b, &c);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let (b, c) = if area > 0.0 { (b, c) } else { (c, b) };
        let per_area = 1.0 / area.abs();
        let slope_x = ((b.z - a.z) * (c.y - a.y) - (c.z - a.z) * (b.y - a.y)) * per_area;
        let slope_y = ((c.z - a.z) * (b.x - a.x) - (b.z - a.z) * (c.x - a.x)) * per_area;
        let edges = [EdgeLine::new(a, b), EdgeLine::new(b, c), EdgeLine::new(c, a)];
        for row in top..=bottom {
            let y = f64::from(row) + 0.5;
            let (mut first, mut last) = (f64::from(left), f64::from(right));
            for edge in &edges {
                edge.narrow(y, &mut first, &mut last);
            }
            let (first, last) = (ceil(first), floor(last));
            if first > last {
                continue;
            }
            let start = a.z + slope_x * (f64::from(first) + 0.5 - a.x) + slope_y * (y - a.y);
            let (start, step) = (start as f32, slope_x as f32);
            let offset = row as usize * self.width;
            let span = offset + first as usize..offset + last as usize + 1;
            for (i, (inverse_depth, part_ids)) in
                self.inverse_depth[span.clone()].iter_mut().zip(&mut self.part_ids[span]).enumerate()
            {
                // The loop has no branches, so the compiler handles several pixels at a time.
                let here = start + step * i as f32;
                let is_nearer = here > *inverse_depth;
                *inverse_depth = if is_nearer { here } else { *inverse_depth };
                *part_ids = if is_nearer { part } else { *part_ids };
            }
        }
    }
}

/// Twice the signed area of a triangle in the image; positive if its corners have the orientation of the axes.
fn area(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// An edge of a triangle in the image. The inside is to its left where the edge goes down, and to its right where it
/// goes up.
///
/// Crossings are computed from the upper end in either direction. No pixel is therefore lost between two triangles that
/// share an edge.
struct EdgeLine {
    upper: Vector3<f64>,
    rise: f64,
    slope: f64,
}

impl EdgeLine {
    fn new(from: Vector3<f64>, to: Vector3<f64>) -> Self {
        let rise = to.y - from.y;
        let (upper, lower) = if rise > 0.0 { (from, to) } else { (to, from) };
        Self { upper, rise, slope: (lower.x - upper.x) / (lower.y - upper.y) }
    }

    /// Narrows the range from `first` to `last` to the pixels that may be inside, in the row with its center at `y`.
    fn narrow(&self, y: f64, first: &mut f64, last: &mut f64) {
        let crossing = self.upper.x + self.slope * (y - self.upper.y) - 0.5;
        if self.rise > 0.0 {
            *last = last.min(crossing);
        } else if self.rise < 0.0 {
            *first = first.max(crossing);
        }
    }
}

/// First and last pixel along every axis whose centers lie from `low` to `high`, out of `size` pixels.
///
/// The last precedes the first if there is none.
fn centers_within(low: f32x4, high: f32x4, size: f32x4) -> (i32x4, i32x4) {
    // Truncation is fast for values that are not negative. The integer part of value + 1/2 counts the centers up to a
    // value.
    let below = (low + f32x4::HALF).fast_max(f32x4::ZERO).fast_min(size + f32x4::ONE);
    let up_to = (high + f32x4::HALF).fast_max(f32x4::ZERO).fast_min(size);
    let whole = below.fast_trunc_int();
    // A mask with all bits set is -1 as an integer.
    let is_center: i32x4 = bytemuck::cast(f32x4::from_i32x4(whole).simd_eq(below));
    ((whole + is_center).max(i32x4::ZERO), up_to.fast_trunc_int() - i32x4::ONE)
}

/// Largest integer up to `value`.
fn floor(value: f64) -> i32 {
    let whole = value as i32;
    whole.saturating_sub(i32::from(f64::from(whole) > value))
}

/// Smallest integer from `value` on.
fn ceil(value: f64) -> i32 {
    let whole = value as i32;
    whole.saturating_add(i32::from(f64::from(whole) < value))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const WIDTH: usize = 20;
    const HEIGHT: usize = 12;

    type Image = (Vec<f32>, Vec<i32>);
    type Draw = fn(&mut ZBuffer, &BoundedTriangle, i32);

    const PIXEL_BY_PIXEL: Draw = |buffer, triangle, part| buffer.fill_narrow(triangle, part);
    const ROW_BY_ROW: Draw = |buffer, triangle, part| buffer.fill_rows(triangle, part);

    fn drawn(triangle: [[f32; 3]; 3], draw: Draw) -> Image {
        let (mut inverse_depth, mut part_ids) = (vec![0.4; WIDTH * HEIGHT], vec![-1; WIDTH * HEIGHT]);
        let mut buffer = ZBuffer::new(WIDTH, HEIGHT, &mut inverse_depth, &mut part_ids);
        let bounded = buffer.bound(triangle.map(|[column, row, near]| Corner::from([column, row, near, 0.0])));
        if !bounded.is_empty() {
            draw(&mut buffer, &bounded, 5);
        }
        (inverse_depth, part_ids)
    }

    proptest! {
        #[test]
        fn both_fill_methods_draw_the_same_triangles(
            triangle in prop::array::uniform3((-4.0..24.0f32, -4.0..16.0f32, 0.2..1.0f32).prop_map(|(x, y, z)| [x, y, z]))
        ) {
            let (narrow, rows) = (drawn(triangle, PIXEL_BY_PIXEL), drawn(triangle, ROW_BY_ROW));
            let [a, b, c] = triangle.map(|corner| Vector3::from(corner).cast::<f64>());
            for pixel in 0..WIDTH * HEIGHT {
                let middle = Vector3::new((pixel % WIDTH) as f64 + 0.5, (pixel / WIDTH) as f64 + 0.5, 0.0);
                let shares = [area(&middle, &b, &c), area(&a, &middle, &c), area(&a, &b, &middle)];
                let is_matter_of_rounding = shares.iter().any(|share| share.abs() < 1e-4) || area(&a, &b, &c).abs() < 0.1;
                if !is_matter_of_rounding && (rows.0[pixel] - 0.4).abs() > 1e-4 {
                    prop_assert_eq!(narrow.1[pixel], rows.1[pixel]);
                    prop_assert!((narrow.0[pixel] - rows.0[pixel]).abs() < 1e-4, "{} {}", narrow.0[pixel], rows.0[pixel]);
                }
            }
        }

        #[test]
        fn pixel_centers_on_a_shared_edge_are_covered(
            ends in prop::array::uniform2((0..WIDTH as i32, 0..HEIGHT as i32)), tilt in -0.4..0.4f32
        ) {
            // A diagonal between two pixel centers passes through other centers too.
            let [a, b] = ends.map(|(column, row)| [column as f32 + 0.5, row as f32 + 0.5, 0.8]);
            let (along, across) = ([b[0] - a[0], b[1] - a[1]], [a[1] - b[1], b[0] - a[0]]);
            let aside = |edge: f32| [
                a[0] + 0.5 * along[0] + edge * (across[0] + tilt * along[0]),
                a[1] + 0.5 * along[1] + edge * (across[1] + tilt * along[1]),
                0.8,
            ];
            for draw in [PIXEL_BY_PIXEL, ROW_BY_ROW] {
                let (one, other) = (drawn([a, b, aside(1.0)], draw), drawn([b, a, aside(-1.0)], draw));
                for row in ends[0].1.min(ends[1].1) + 1..ends[0].1.max(ends[1].1) {
                    let (rows, columns) = (ends[1].1 - ends[0].1, ends[1].0 - ends[0].0);
                    let column = ends[0].0 + (row - ends[0].1) * columns / rows;
                    let pixel = row as usize * WIDTH + column as usize;
                    if (row - ends[0].1) * columns % rows == 0 {
                        prop_assert!(one.1[pixel] == 5 || other.1[pixel] == 5, "{column} {row}");
                    }
                }
            }
        }

        #[test]
        fn pixel_centers_within_two_limits_are_found(low in -4.0..20.0f32, length in 0.0..9.0f32, half in any::<bool>()) {
            let (low, high) = if half { (low.round() + 0.5, low.round() + 0.5 + length) } else { (low, low + length) };
            let inside: Vec<i32> = (0..12).filter(|&i| low <= i as f32 + 0.5 && i as f32 + 0.5 <= high).collect();
            let (first, last) = centers_within(f32x4::splat(low), f32x4::splat(high), f32x4::splat(12.0));
            let (first, last) = (first.to_array()[0], last.to_array()[0]);
            prop_assert_eq!((first..=last).collect::<Vec<_>>(), inside);
        }
    }

    #[test]
    fn triangles_without_area_are_invisible() {
        let flat = [[2.25, 2.0, 0.8], [4.5, 4.5, 0.8], [6.75, 7.0, 0.8]];
        for draw in [PIXEL_BY_PIXEL, ROW_BY_ROW] {
            assert!(drawn(flat, draw).1.iter().all(|&part| part == -1));
        }
    }
}
