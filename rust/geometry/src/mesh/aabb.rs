//! Axis-aligned bounding boxes.

use nalgebra::{Point3, Vector3};

/// The smaller of two numbers that are not NaN. It compiles to one instruction, where `f64::min` takes four.
#[inline]
pub(crate) fn lesser<T: PartialOrd>(a: T, b: T) -> T {
    if b < a { b } else { a }
}

/// The larger of two numbers that are not NaN.
#[inline]
pub(crate) fn greater<T: PartialOrd>(a: T, b: T) -> T {
    if b > a { b } else { a }
}

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Corner with the smallest coordinates.
    pub low: Point3<f64>,
    /// Corner with the largest coordinates.
    pub high: Point3<f64>,
}

impl Aabb {
    /// The empty box, from plus to minus infinity.
    pub fn empty() -> Self {
        let far = Vector3::repeat(f64::INFINITY);
        Self { low: Point3::from(far), high: Point3::from(-far) }
    }

    /// Smallest box around `points`.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Point3<f64>>) -> Self {
        points.into_iter().fold(Self::empty(), |bounds, p| bounds.merged(&Self { low: *p, high: *p }))
    }

    /// Smallest box around two boxes.
    pub fn merged(&self, other: &Self) -> Self {
        Self {
            low: self.low.coords.zip_map(&other.low.coords, lesser).into(),
            high: self.high.coords.zip_map(&other.high.coords, greater).into(),
        }
    }

    /// Intersection of two boxes; `None` if they are disjoint.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let shared = Self { low: self.low.sup(&other.low), high: self.high.inf(&other.high) };
        (0..3).all(|axis| shared.low[axis] <= shared.high[axis]).then_some(shared)
    }

    /// The eight corners.
    pub fn corners(&self) -> [Point3<f64>; 8] {
        std::array::from_fn(|corner| {
            let side = |axis: usize| if corner >> axis & 1 == 1 { self.high[axis] } else { self.low[axis] };
            Point3::new(side(0), side(1), side(2))
        })
    }

    /// The box grown by `margin` on every side.
    pub fn grown(&self, margin: f64) -> Self {
        let margin = Vector3::repeat(margin);
        Self { low: self.low - margin, high: self.high + margin }
    }

    /// Squared distance between two boxes; 0 where they overlap.
    pub fn squared_distance(&self, other: &Self) -> f64 {
        let mut sum = 0.0;
        for axis in 0..3 {
            let gap = greater(other.low[axis] - self.high[axis], self.low[axis] - other.high[axis]);
            let gap = greater(gap, 0.0);
            sum += gap * gap;
        }
        sum
    }

    /// Squared distance from a point to the box; 0 inside.
    pub fn squared_distance_to_point(&self, point: &Point3<f64>) -> f64 {
        let outside = |axis: usize| greater(greater(self.low[axis] - point[axis], point[axis] - self.high[axis]), 0.0);
        let [x, y, z] = [outside(0), outside(1), outside(2)];
        x * x + y * y + z * z
    }

    /// True if the ray from `origin` meets the box before the parameter `limit`.
    ///
    /// `inverse` is the inverse of the ray's direction, with plus infinity (never minus infinity) for a component of 0.
    pub fn meets_ray(&self, origin: &Point3<f64>, inverse: &Vector3<f64>, limit: f64) -> bool {
        let (mut enter, mut leave) = (0.0f64, limit);
        for axis in 0..3 {
            let (a, b) =
                ((self.low[axis] - origin[axis]) * inverse[axis], (self.high[axis] - origin[axis]) * inverse[axis]);
            // The order of arguments drops the NaN of a ray inside the plane of a face.
            enter = greater(enter, lesser(a, b));
            leave = lesser(leave, greater(b, a));
        }
        enter <= leave
    }

    /// Smallest shift along `direction` that moves the box entirely behind `other`.
    pub fn gap_along(&self, other: &Self, direction: &Vector3<f64>) -> f64 {
        let mut sum = 0.0;
        for axis in 0..3 {
            let (ahead, back) = (other.low[axis] - self.high[axis], other.high[axis] - self.low[axis]);
            sum += direction[axis] * if direction[axis] > 0.0 { ahead } else { back };
        }
        sum
    }

    /// Squared length of the diagonal.
    pub fn squared_diagonal(&self) -> f64 {
        (self.high - self.low).norm_squared()
    }
}
