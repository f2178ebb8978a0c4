//! Coarse distance grid around a surface.

use std::ops::Range;

use nalgebra::{Point3, Vector3};

use crate::mesh::aabb::Aabb;
use crate::mesh::bvh::Bvh;

/// Number of cells along the longest side.
const RESOLUTION: f64 = 64.0;
/// Step count of cells far from any surface, and the largest count that is stored.
const FAR: u8 = 255;

/// Lower bounds of the distance to the triangles of some trees, on a grid around `bounds`.
pub struct ClearanceGrid {
    bounds: Aabb,
    low: Point3<f64>,
    cell: f64,
    cells_per_length: f64,
    size: [usize; 3],
    /// Number of cells to the nearest cell with surface, in the maximum norm.
    steps: Vec<u8>,
}

impl ClearanceGrid {
    /// Grid over the surfaces inside `bounds`, which must not be empty. Surfaces outside are ignored.
    pub fn new(trees: &[&Bvh], bounds: &Aabb) -> Self {
        let extent = bounds.high - bounds.low;
        let cell = (extent.max() / RESOLUTION).max(f64::MIN_POSITIVE);
        // One layer of border cells on every side; see `spread_forward`.
        let size = [0, 1, 2].map(|axis| (extent[axis] / cell) as usize + 3);
        let mut grid = Self {
            bounds: *bounds,
            low: bounds.low - Vector3::repeat(cell),
            cell,
            cells_per_length: cell.recip(),
            size,
            steps: vec![FAR; size[0] * size[1] * size[2]],
        };
        for tree in trees {
            tree.visit_triangles(bounds, |triangle| grid.mark(&Aabb::of(triangle), triangle));
        }
        grid.spread();
        grid
    }

    /// Lower bound of the distance from `point` to the surface inside the bounds.
    pub fn clearance(&self, point: &Point3<f64>) -> f64 {
        let cell = (point - self.low) * self.cells_per_length;
        let inside = (0..3).all(|axis| cell[axis] >= 1.0 && cell[axis] < (self.size[axis] - 1) as f64);
        if !inside {
            return self.bounds.squared_distance(&Aabb { low: *point, high: *point }).sqrt();
        }
        let steps = self.steps[self.index([cell.x as usize, cell.y as usize, cell.z as usize])];
        (f64::from(steps) - 1.0).max(0.0) * self.cell
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }

    fn mark(&mut self, bounds: &Aabb, triangle: &[Point3<f64>; 3]) {
        let place =
            |value: f64, axis: usize| ((value - self.low[axis]) / self.cell).clamp(1.0, (self.size[axis] - 2) as f64);
        let first = [0, 1, 2].map(|axis| place(bounds.low[axis], axis) as usize);
        let last = [0, 1, 2].map(|axis| place(bounds.high[axis], axis) as usize);
        let normal = (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0]));
        let reach = 0.5 * self.cell * normal.abs().sum() * (1.0 + 1e-9);
        let sign = 1f64.copysign(normal.x);
        let (low, cell) = (self.low, self.cell);
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                // Height over the triangle's plane along a row. It never decreases, because rounding preserves the
                // order of sums.
                let height = |x: usize| {
                    let corner = Vector3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5);
                    (low + corner * cell - triangle[0]).dot(&normal) * sign
                };
                let (start, rise) = (height(first[0]), cell * normal.x.abs());
                let crossing = |height: f64| ((height - start) / rise).clamp(0.0, (last[0] - first[0]) as f64) as usize;
                let within = first[0]..last[0] + 1;
                let from = first_where(&within, first[0] + crossing(-reach), |x| height(x) >= -reach);
                let to = first_where(&within, first[0] + crossing(reach), |x| height(x) > reach);
                let row = self.index([0, y, z]);
                self.steps[row + from..row + to].fill(0);
            }
        }
    }

    /// Spreads distances in the maximum norm: a cell is at most one step farther than any of its 26 neighbours.
    ///
    /// A forward pass reads the 13 neighbours that precede a cell. The same pass over the reversed grid reads the other
    /// 13.
    fn spread(&mut self) {
        for _ in 0..2 {
            self.spread_forward();
            self.steps.reverse();
        }
    }

    fn spread_forward(&mut self) {
        let [nx, ny, nz] = self.size;
        // The border cells spare the inner cells a test for missing neighbours.
        for z in 1..nz - 1 {
            for y in 1..ny - 1 {
                let start = self.index([0, y, z]);
                let (before, row) = self.steps.split_at_mut(start);
                let row = &mut row[..nx];
                for (dz, dy) in [(1, 1), (1, 0), (1, -1), (0, 1)] {
                    let start = start as isize - (dz * ny as isize + dy) * nx as isize;
                    let other = &before[start as usize..start as usize + nx];
                    for (value, three) in row[1..].iter_mut().zip(other.windows(3)) {
                        *value = (*value).min(three[0].min(three[1]).min(three[2]).saturating_add(1));
                    }
                }
                for x in 1..nx {
                    row[x] = row[x].min(row[x - 1].saturating_add(1));
                }
            }
        }
    }
}

/// First number of a range for which `holds` is true; the end of the range if there is none.
///
/// `holds` must be monotonic. The search starts at `guess`.
fn first_where(numbers: &Range<usize>, guess: usize, holds: impl Fn(usize) -> bool) -> usize {
    let mut first = guess;
    while first > numbers.start && holds(first - 1) {
        first -= 1;
    }
    while first < numbers.end && !holds(first) {
        first += 1;
    }
    first
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_shapes::{block, triangle_soup};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn no_surface_inside_the_bounds_is_nearer_than_the_clearance(
            mesh in triangle_soup(20),
            size in prop::array::uniform3(0.0..1.0f64),
            points in prop::collection::vec(prop::array::uniform3(-2.0..2.0f64), 60),
        ) {
            let tree = Bvh::new(&mesh);
            let bounds = Aabb { low: Point3::from(size.map(|x| -x)), high: Point3::from(size) };
            let grid = ClearanceGrid::new(&[&tree], &bounds);
            for point in points.into_iter().map(Point3::from) {
                // A segment shorter than the clearance meets no surface inside the bounds.
                let clearance = grid.clearance(&point);
                for direction in [Vector3::x(), -Vector3::y(), Vector3::new(0.6, 0.0, -0.8), Vector3::new(-0.48, 0.8, 0.36)] {
                    let end = point + direction * clearance * (1.0 - 1e-9);
                    if let Some(share) = tree.first_crossing(&point, &end) {
                        let met = point + (end - point) * share;
                        prop_assert!(bounds.grown(-1e-9).squared_distance_to_point(&met) > 0.0);
                    }
                }
            }
        }
    }

    /// Marks cell by cell, without row arithmetic.
    fn mark_one_by_one(grid: &mut ClearanceGrid, triangle: &[Point3<f64>; 3]) {
        let bounds = Aabb::of(triangle);
        let place =
            |value: f64, axis: usize| ((value - grid.low[axis]) / grid.cell).clamp(1.0, (grid.size[axis] - 2) as f64);
        let first = [0, 1, 2].map(|axis| place(bounds.low[axis], axis) as usize);
        let last = [0, 1, 2].map(|axis| place(bounds.high[axis], axis) as usize);
        let normal = (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0]));
        let reach = 0.5 * grid.cell * normal.abs().sum() * (1.0 + 1e-9);
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let corner = Vector3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5);
                    if (grid.low + corner * grid.cell - triangle[0]).dot(&normal).abs() <= reach {
                        let index = grid.index([x, y, z]);
                        grid.steps[index] = 0;
                    }
                }
            }
        }
    }

    /// Triangles that include special cases: axis-aligned planes, planes through cell centers and corners, and no area.
    fn corners() -> impl Strategy<Value = [Point3<f64>; 3]> {
        let round = (-8..=8i8).prop_map(|eighths| f64::from(eighths) / 8.0);
        let coordinate = prop_oneof![round, -1.0..1.0f64, Just(0.0), Just(1.0 / 64.0)];
        let corner = prop::array::uniform3(coordinate).prop_map(Point3::from);
        (prop::array::uniform3(corner), prop_oneof![Just(1.0), Just(1e-9), Just(1e-60)])
            .prop_map(|(corners, size)| corners.map(|corner: Point3<f64>| corner * size + Vector3::repeat(1e-3)))
    }

    proptest! {
        #[test]
        fn marking_rows_agrees_with_marking_cells(triangle in corners(), size in prop::array::uniform3(0.0..1.0f64)) {
            let bounds = Aabb { low: Point3::from(size.map(|x| -x)), high: Point3::from(size) };
            let mut grid = ClearanceGrid::new(&[], &bounds);
            grid.steps.fill(FAR);
            let mut expected = ClearanceGrid { steps: grid.steps.clone(), ..grid };
            grid.mark(&Aabb::of(&triangle), &triangle);
            mark_one_by_one(&mut expected, &triangle);
            prop_assert_eq!(grid.steps, expected.steps);
        }
    }

    #[test]
    fn the_clearance_in_a_hollow_block_nearly_reaches_its_walls() {
        let tree = Bvh::new(&block([-1.0; 3], [1.0; 3]));
        let clearance = ClearanceGrid::new(&[&tree], tree.bounds()).clearance(&Point3::origin());
        assert!(clearance > 0.9 && clearance <= 1.0, "{clearance}");
    }
}
