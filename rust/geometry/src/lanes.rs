//! Vectors stored coordinate by coordinate, so that dot products with all of them run in SIMD lanes.

use nalgebra::Vector3;

const LANES: usize = 4;

type Lane = [f64; LANES];

/// Many vectors. What is left of the last lane is filled up with a vector that is given.
pub struct VectorLanes {
    chunks: Vec<[Lane; 3]>,
}

impl VectorLanes {
    /// Arranges `vectors`; lanes left over hold `filler`.
    pub fn new(vectors: &[Vector3<f64>], filler: Vector3<f64>) -> Self {
        let chunk_of = |chunk: &[Vector3<f64>]| {
            [0, 1, 2].map(|axis| std::array::from_fn(|lane| chunk.get(lane).unwrap_or(&filler)[axis]))
        };
        Self { chunks: vectors.chunks(LANES).map(chunk_of).collect() }
    }

    /// Dot products with `direction`, a few at a time.
    fn dots(&self, direction: &Vector3<f64>) -> impl Iterator<Item = Lane> {
        let [dx, dy, dz] = direction.data.0[0];
        self.chunks.iter().map(move |[x, y, z]| std::array::from_fn(|i| x[i] * dx + y[i] * dy + z[i] * dz))
    }

    /// Sum of the absolute dot products with `direction`.
    pub fn sum_of_absolute_dots(&self, direction: &Vector3<f64>) -> f64 {
        let add = |sum: Lane, dots: Lane| -> Lane { std::array::from_fn(|i| sum[i] + dots[i].abs()) };
        self.dots(direction).fold([0.0; LANES], add).iter().sum()
    }

    /// Difference between the greatest and the least dot product with `direction`.
    pub fn spread_along(&self, direction: &Vector3<f64>) -> f64 {
        let start = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
        let widen = |(low, high): (Lane, Lane), dots: Lane| -> (Lane, Lane) {
            let low = std::array::from_fn(|i| if dots[i] < low[i] { dots[i] } else { low[i] });
            let high = std::array::from_fn(|i| if dots[i] > high[i] { dots[i] } else { high[i] });
            (low, high)
        };
        let (low, high) = self.dots(direction).fold(start, widen);
        high.into_iter().fold(f64::MIN, f64::max) - low.into_iter().fold(f64::MAX, f64::min)
    }

    /// For every vector whether its dot product with `direction` is positive; with entries for the fillers.
    pub fn mark_facing(&self, direction: &Vector3<f64>, facing: &mut Vec<bool>) {
        facing.clear();
        facing.extend(self.dots(direction).flat_map(|dots| dots.map(|dot| dot > 0.0)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn lanes_give_what_single_dot_products_give(
            vectors in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 1..20),
            direction in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let vectors: Vec<Vector3<f64>> = vectors.into_iter().map(Vector3::from).collect();
            let direction = Vector3::from(direction);
            let dots: Vec<f64> = vectors.iter().map(|vector| vector.dot(&direction)).collect();
            let lanes = VectorLanes::new(&vectors, Vector3::zeros());
            let sum: f64 = dots.iter().map(|dot| dot.abs()).sum();
            prop_assert!((lanes.sum_of_absolute_dots(&direction) - sum).abs() < 1e-12);
            let spread = dots.iter().fold(f64::MIN, |a, &b| a.max(b)) - dots.iter().fold(f64::MAX, |a, &b| a.min(b));
            let lanes_with_own_filler = VectorLanes::new(&vectors, vectors[0]);
            prop_assert!((lanes_with_own_filler.spread_along(&direction) - spread).abs() < 1e-12);
        }
    }
}
