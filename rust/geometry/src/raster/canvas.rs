//! Depth and part of every pixel, and triangles that are drawn where they are nearer.

use nalgebra::Vector3;
use wide::{bytemuck, f32x4, i32x4};

/// A point on the image: column, row, one over the depth, which is linear on the image of a plane, and nothing.
///
/// In single precision, as what large meshes take is the time to read and write their corners; four lanes, as it is for bounds
/// of tiny triangles, most of which hold the middle of no pixel, that the rest of the time goes.
pub type Corner = f32x4;

/// Triangles of at most so many columns and rows are tried pixel by pixel, four at once; larger ones row by row.
const NARROW: i32 = 16;
const LANES: usize = 4;

/// A triangle of the image, and which pixels have their middle within its bounds.
#[derive(Clone, Copy, Default)]
pub struct Framed {
    corners: [Corner; 3],
    /// Column and row of the first of the pixels; two lanes of no meaning.
    first: i32x4,
    /// Column and row of the last; one of them comes before the first where there is no pixel.
    last: i32x4,
}

impl Framed {
    /// Whether no pixel has its middle within the bounds.
    pub fn is_empty(&self) -> bool {
        (self.last - self.first).to_bitmask() & 0b11 != 0
    }
}

/// What is seen so far, by pixels, row by row.
pub struct Canvas<'a> {
    width: usize,
    size: f32x4,
    nearness: &'a mut [f32],
    shown: &'a mut [i32],
}

impl<'a> Canvas<'a> {
    /// Pictures of `height` rows of `width` pixels: one over the depths, and the parts.
    pub fn new(width: usize, height: usize, nearness: &'a mut [f32], shown: &'a mut [i32]) -> Self {
        Self { width, size: f32x4::from([width as f32, height as f32, 0.0, 0.0]), nearness, shown }
    }

    /// The pixels that a triangle of the image may cover.
    pub fn frame(&self, corners: [Corner; 3]) -> Framed {
        let [a, b, c] = corners;
        let (first, last) = middles_within(a.fast_min(b).fast_min(c), a.fast_max(b).fast_max(c), self.size);
        Framed { corners, first, last }
    }

    /// Draws a triangle where it is nearer than what is seen: the pixels whose middles all three sides leave on the inside.
    pub fn fill(&mut self, triangle: &Framed, part: i32) {
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

    /// Tries all pixels within the bounds.
    ///
    /// What tells the side of an edge that a pixel is on has its sign turned round, to the last bit, where the edge is gone along
    /// the other way: no pixel falls between two triangles that share it.
    fn fill_narrow(&mut self, triangle: &Framed, part: i32) {
        let ([left, top, ..], [right, bottom, ..]) = (triangle.first.to_array(), triangle.last.to_array());
        let [a, b, c] = triangle.corners.map(|corner| corner.to_array());
        let [a_near, b_near, c_near] = [a, b, c].map(|[_, _, nearness, _]| f32x4::splat(nearness));
        let nearest = a_near.fast_max(b_near).fast_max(c_near);
        let part = i32x4::splat(part);
        for start in (left..=right).step_by(LANES) {
            let column = start.min((self.width - LANES) as i32);
            let x = f32x4::splat(column as f32) + f32x4::from([0.5, 1.5, 2.5, 3.5]);
            let [ax, bx, cx] = [a, b, c].map(|[column, ..]| f32x4::splat(column) - x);
            for row in top..=bottom {
                let pixel = row as usize * self.width + column as usize;
                let (Some(nearness), Some(shown)) =
                    (self.nearness[pixel..].first_chunk_mut(), self.shown[pixel..].first_chunk_mut())
                else {
                    return;
                };
                let before = f32x4::from(*nearness);
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
                    *nearness = is_seen.bitselect(here, before).into();
                    let is_seen: i32x4 = bytemuck::cast(is_seen);
                    *shown = is_seen.bitselect(part, i32x4::from(*shown)).into();
                }
            }
        }
    }

    /// Finds, in every row, the first and the last pixel inside.
    fn fill_rows(&mut self, triangle: &Framed, part: i32) {
        let ([left, top, ..], [right, bottom, ..]) = (triangle.first.to_array(), triangle.last.to_array());
        let [a, b, c] = triangle.corners.map(|corner| {
            let [column, row, nearness, _] = corner.to_array();
            Vector3::new(column, row, nearness).cast::<f64>()
        });
        let area = area(&a, &b, &c);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let (b, c) = if area > 0.0 { (b, c) } else { (c, b) };
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
            let offset = row as usize * self.width;
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
}

/// Twice the area of a triangle of the image; above zero where its corners go round as the axes do.
fn area(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// A side of a triangle of the image: where it goes down the inside is to its left, where it goes up to its right.
///
/// Where it is crossed is told from its upper end, whichever way it is gone along, so that no pixel falls between two triangles
/// that share it.
struct Side {
    upper: Vector3<f64>,
    rise: f64,
    slope: f64,
}

impl Side {
    fn new(from: Vector3<f64>, to: Vector3<f64>) -> Self {
        let rise = to.y - from.y;
        let (upper, lower) = if rise > 0.0 { (from, to) } else { (to, from) };
        Self { upper, rise, slope: (lower.x - upper.x) / (lower.y - upper.y) }
    }

    /// Leaves, of the pixels from `first` to `last` in the row with its middle at `y`, those that may be inside.
    fn narrow(&self, y: f64, first: &mut f64, last: &mut f64) {
        let crossing = self.upper.x + self.slope * (y - self.upper.y) - 0.5;
        if self.rise > 0.0 {
            *last = last.min(crossing);
        } else if self.rise < 0.0 {
            *first = first.max(crossing);
        }
    }
}

/// The first and the last pixel, along every axis, whose middles lie from `low` to `high`, of as many as `size` says; the last
/// comes before the first where there is none.
fn middles_within(low: f32x4, high: f32x4, size: f32x4) -> (i32x4, i32x4) {
    // of what is never negative the whole part is found fast, and it is that of value + 1/2 that counts middles up to a value
    let below = (low + f32x4::HALF).fast_max(f32x4::ZERO).fast_min(size + f32x4::ONE);
    let up_to = (high + f32x4::HALF).fast_max(f32x4::ZERO).fast_min(size);
    let whole = below.fast_trunc_int();
    // all bits set, which is -1
    let is_middle: i32x4 = bytemuck::cast(f32x4::from_i32x4(whole).simd_eq(below));
    ((whole + is_middle).max(i32x4::ZERO), up_to.fast_trunc_int() - i32x4::ONE)
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

    const WIDTH: usize = 20;
    const HEIGHT: usize = 12;

    type Image = (Vec<f32>, Vec<i32>);
    type Draw = fn(&mut Canvas, &Framed, i32);

    const PIXEL_BY_PIXEL: Draw = |canvas, triangle, part| canvas.fill_narrow(triangle, part);
    const ROW_BY_ROW: Draw = |canvas, triangle, part| canvas.fill_rows(triangle, part);

    fn drawn(triangle: [[f32; 3]; 3], draw: Draw) -> Image {
        let (mut nearness, mut shown) = (vec![0.4; WIDTH * HEIGHT], vec![-1; WIDTH * HEIGHT]);
        let mut canvas = Canvas::new(WIDTH, HEIGHT, &mut nearness, &mut shown);
        let framed = canvas.frame(triangle.map(|[column, row, near]| Corner::from([column, row, near, 0.0])));
        if !framed.is_empty() {
            draw(&mut canvas, &framed, 5);
        }
        (nearness, shown)
    }

    proptest! {
        #[test]
        fn triangles_look_alike_pixel_by_pixel_and_row_by_row(
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
        fn no_pixel_falls_between_two_triangles_where_their_side_is_on_its_middle(
            ends in prop::array::uniform2((0..WIDTH as i32, 0..HEIGHT as i32)), tilt in -0.4..0.4f32
        ) {
            // a diagonal from a middle to another goes through middles of other pixels, too
            let [a, b] = ends.map(|(column, row)| [column as f32 + 0.5, row as f32 + 0.5, 0.8]);
            let (along, across) = ([b[0] - a[0], b[1] - a[1]], [a[1] - b[1], b[0] - a[0]]);
            let aside = |side: f32| [
                a[0] + 0.5 * along[0] + side * (across[0] + tilt * along[0]),
                a[1] + 0.5 * along[1] + side * (across[1] + tilt * along[1]),
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
        fn middles_within_two_limits_are_found(low in -4.0..20.0f32, length in 0.0..9.0f32, half in any::<bool>()) {
            let (low, high) = if half { (low.round() + 0.5, low.round() + 0.5 + length) } else { (low, low + length) };
            let inside: Vec<i32> = (0..12).filter(|&i| low <= i as f32 + 0.5 && i as f32 + 0.5 <= high).collect();
            let (first, last) = middles_within(f32x4::splat(low), f32x4::splat(high), f32x4::splat(12.0));
            let (first, last) = (first.to_array()[0], last.to_array()[0]);
            prop_assert_eq!((first..=last).collect::<Vec<_>>(), inside);
        }
    }

    #[test]
    fn triangles_without_area_are_not_seen() {
        let flat = [[2.25, 2.0, 0.8], [4.5, 4.5, 0.8], [6.75, 7.0, 0.8]];
        for draw in [PIXEL_BY_PIXEL, ROW_BY_ROW] {
            assert!(drawn(flat, draw).1.iter().all(|&part| part == -1));
        }
    }
}
