//! Points stored coordinate by coordinate, for fast distances to all of them.

/// Points per block.
pub(crate) const BLOCK: usize = 8;

/// Points in blocks, coordinate by coordinate. Infinite coordinates complete the last block.
pub(crate) struct PointColumns {
    chunks: Vec<[[f32; BLOCK]; 3]>,
}

impl PointColumns {
    /// Arranges `points` in blocks.
    pub(crate) fn new(points: &[[f32; 3]]) -> Self {
        let chunk_of = |chunk: &[[f32; 3]]| {
            [0, 1, 2]
                .map(|axis| std::array::from_fn(|entry| chunk.get(entry).map_or(f32::INFINITY, |point| point[axis])))
        };
        Self { chunks: points.chunks(BLOCK).map(chunk_of).collect() }
    }

    /// Zeros, one per point and filler.
    pub(crate) fn zeros(&self) -> Vec<[f32; BLOCK]> {
        vec![[0.0; BLOCK]; self.chunks.len()]
    }

    /// Writes the squared distances of all points to `point`.
    pub(crate) fn squared_distances(&self, point: &[f32; 3], squared: &mut [[f32; BLOCK]]) {
        for (squared, [x, y, z]) in squared.iter_mut().zip(&self.chunks) {
            *squared = std::array::from_fn(|entry| {
                let [dx, dy, dz] = [x[entry] - point[0], y[entry] - point[1], z[entry] - point[2]];
                dx * dx + dy * dy + dz * dz
            });
        }
    }
}

/// Smallest value of a block.
pub(crate) fn least_of(block: &[f32; BLOCK]) -> f32 {
    block.iter().fold(f32::INFINITY, |least, &entry| if entry < least { entry } else { least })
}
