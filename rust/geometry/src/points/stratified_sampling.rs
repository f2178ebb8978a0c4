//! Stratified sampling of elements by weight.

use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// Approximate number of blocks of elements per draw.
const BLOCKS_PER_DRAW: usize = 4;

/// Elements in a row, each as long as its weight.
///
/// Only the summed weights of blocks are stored. For large meshes, computing a weight again is faster than reading it.
pub struct StratifiedSampler<W> {
    count: usize,
    weight: W,
    block_size: usize,
    blocks: Vec<f64>,
    total: f64,
}

impl<W: Fn(usize) -> f64> StratifiedSampler<W> {
    /// Sums the weights of `count` elements, for batches of `draws` draws.
    pub fn new(count: usize, draws: usize, weight: W) -> Self {
        let block_size = (count / draws.saturating_mul(BLOCKS_PER_DRAW)).max(1);
        let block_sum = |first: usize| {
            let end = count.min(first + block_size);
            // Two sums allow the square roots in the weights to be computed in pairs.
            let (mut even, mut odd) = (0.0, 0.0);
            for element in (first..end - (end - first) % 2).step_by(2) {
                let pair = [weight(element), weight(element + 1)];
                even += pair[0];
                odd += pair[1];
            }
            if (end - first) % 2 == 1 { even + odd + weight(end - 1) } else { even + odd }
        };
        let blocks: Vec<f64> = match block_size {
            1 => (0..count).map(&weight).collect(),
            _ => (0..count).step_by(block_size).map(block_sum).collect(),
        };
        let total = blocks.iter().sum();
        Self { count, weight, block_size, blocks, total }
    }

    /// Sum of the weights.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Draws `draws` elements in random order: one at a random position in each of `draws` equal pieces of the row.
    pub fn draw_shuffled(&self, draws: usize, rng: &mut ChaCha8Rng) -> Vec<u32> {
        let jitter: Vec<f64> = (0..draws).map(|_| rng.random()).collect();
        let mut drawn = self.blocks_at(&jitter);
        if self.block_size > 1 {
            self.find_within_blocks(&jitter, &mut drawn);
        }
        drawn.shuffle(rng);
        drawn
    }

    /// Block at each position: stratum `i` has its position at `i + jitter[i]` steps along the row.
    ///
    /// Every block is written at the first position it covers, over blocks that cover none. A running maximum fills the
    /// gaps. No branch depends on the draws.
    fn blocks_at(&self, jitter: &[f64]) -> Vec<u32> {
        let mut blocks = vec![0; jitter.len()];
        let per_weight = jitter.len() as f64 / self.total;
        let mut before = 0.0;
        for (block, &weight) in self.blocks.iter().enumerate() {
            let steps = before * per_weight;
            let stratum = steps as usize;
            if weight > 0.0 && stratum < jitter.len() {
                let first_covered = stratum + usize::from(jitter[stratum] < steps - stratum as f64);
                if let Some(slot) = blocks.get_mut(first_covered) {
                    *slot = block as u32;
                }
            }
            before += weight;
        }
        let mut covering = 0;
        for block in &mut blocks {
            covering = covering.max(*block);
            *block = covering;
        }
        blocks
    }

    /// Replaces each block by its element at the position.
    fn find_within_blocks(&self, jitter: &[f64], drawn: &mut [u32]) {
        let step = self.total / jitter.len() as f64;
        let (mut block, mut before_block) = (0, 0.0);
        for (stratum, slot) in drawn.iter_mut().enumerate() {
            let target = (stratum as f64 + jitter[stratum]) * step;
            while block < *slot as usize {
                before_block += self.blocks[block];
                block += 1;
            }
            let first = block * self.block_size;
            let mut sum = before_block;
            // If rounding leaves the target beyond the end of the block, the last element with a weight covers it.
            let mut covering = first;
            for element in first..self.count.min(first + self.block_size) {
                let weight = (self.weight)(element);
                if weight > 0.0 {
                    covering = element;
                }
                sum += weight;
                if sum > target {
                    break;
                }
            }
            *slot = covering as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::SeedableRng;

    proptest! {
        #[test]
        fn elements_are_drawn_in_proportion_to_their_weights(
            mut weights in prop::collection::vec(0.0..1.0f64, 1..400),
            zeros in prop::collection::vec(any::<bool>(), 400),
            draws in 1usize..300,
            seed in any::<u64>(),
        ) {
            for (weight, zero) in weights.iter_mut().zip(zeros) {
                *weight = if zero { 0.0 } else { *weight };
            }
            let total: f64 = weights.iter().sum();
            prop_assume!(total > 0.0);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let drawn = StratifiedSampler::new(weights.len(), draws, |i| weights[i]).draw_shuffled(draws, &mut rng);
            prop_assert_eq!(drawn.len(), draws);
            for (element, weight) in weights.iter().enumerate() {
                let times = drawn.iter().filter(|&&other| other as usize == element).count() as f64;
                // An element covers parts of two strata at its ends, and whole strata in between.
                prop_assert!((times - draws as f64 * weight / total).abs() < 2.0);
                prop_assert!(*weight > 0.0 || times == 0.0);
            }
        }
    }
}
