//! Vectors stored coordinate by coordinate, for fast dot products with all of them.

use nalgebra::Vector3;

const BLOCK: usize = 4;

type Block = [f64; BLOCK];

/// Many vectors in blocks. A filler vector completes the last block.
pub struct VectorColumns {
    blocks: Vec<[Block; 3]>,
}

impl VectorColumns {
    /// Arranges `vectors` in blocks, completed by `filler`.
    pub fn new(vectors: &[Vector3<f64>], filler: Vector3<f64>) -> Self {
        let block_of = |chunk: &[Vector3<f64>]| {
            [0, 1, 2].map(|axis| std::array::from_fn(|entry| chunk.get(entry).unwrap_or(&filler)[axis]))
        };
        Self { blocks: vectors.chunks(BLOCK).map(block_of).collect() }
    }

    /// Dot products with `direction`, block by block.
    fn dots(&self, direction: &Vector3<f64>) -> impl Iterator<Item = Block> {
        let [dx, dy, dz] = direction.data.0[0];
        self.blocks.iter().map(move |[x, y, z]| std::array::from_fn(|i| x[i] * dx + y[i] * dy + z[i] * dz))
    }

    /// Sum of the absolute dot products with `direction`.
    pub fn sum_of_absolute_dots(&self, direction: &Vector3<f64>) -> f64 {
        let add = |sum: Block, dots: Block| -> Block { std::array::from_fn(|i| sum[i] + dots[i].abs()) };
        self.dots(direction).fold([0.0; BLOCK], add).iter().sum()
    }

    /// Difference between the largest and the smallest dot product with `direction`.
    pub fn spread_along(&self, direction: &Vector3<f64>) -> f64 {
        let start = ([f64::INFINITY; BLOCK], [f64::NEG_INFINITY; BLOCK]);
        let widen = |(low, high): (Block, Block), dots: Block| -> (Block, Block) {
            let low = std::array::from_fn(|i| if dots[i] < low[i] { dots[i] } else { low[i] });
            let high = std::array::from_fn(|i| if dots[i] > high[i] { dots[i] } else { high[i] });
            (low, high)
        };
        let (low, high) = self.dots(direction).fold(start, widen);
        high.into_iter().fold(f64::MIN, f64::max) - low.into_iter().fold(f64::MAX, f64::min)
    }

    /// Writes one flag per vector to `facing`: true if its dot product with `direction` is positive. Fillers have flags
    /// too.
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
        fn blocks_agree_with_single_dot_products(
            vectors in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 1..20),
            direction in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let vectors: Vec<Vector3<f64>> = vectors.into_iter().map(Vector3::from).collect();
            let direction = Vector3::from(direction);
            let dots: Vec<f64> = vectors.iter().map(|vector| vector.dot(&direction)).collect();
            let columns = VectorColumns::new(&vectors, Vector3::zeros());
            let sum: f64 = dots.iter().map(|dot| dot.abs()).sum();
            prop_assert!((columns.sum_of_absolute_dots(&direction) - sum).abs() < 1e-12);
            let spread = dots.iter().fold(f64::MIN, |a, &b| a.max(b)) - dots.iter().fold(f64::MAX, |a, &b| a.min(b));
            let columns_with_own_filler = VectorColumns::new(&vectors, vectors[0]);
            prop_assert!((columns_with_own_filler.spread_along(&direction) - spread).abs() < 1e-12);
        }
    }
}
