//! Feature-wise maximum over the neighbours of every point, as in max pooling.

use crate::points::point_columns::BLOCK;

/// Maximum of every feature over rows of neighbours: writes the index of the row with the largest value to `found`.
///
/// `features` has rows of `width` values. Each row of `index` names `count` rows of `features`. Among equal values the
/// first named wins. NaN counts as larger than all numbers.
///
/// # Panics
///
/// If `index` names a row that does not exist.
pub fn neighbour_argmax(features: &[f32], width: usize, index: &[u32], count: usize, found: &mut [i64]) {
    // Indices as wide as features: wider ones would halve the number of comparisons at a time.
    let mut row = vec![0; width];
    for (named, found) in index.chunks_exact(count.max(1)).zip(found.chunks_exact_mut(width.max(1))) {
        for (start, row) in (0..).step_by(BLOCK).zip(row.chunks_mut(BLOCK)) {
            let columns_of = |number: u32| block_of(&features[number as usize * width..][start..width]);
            let at = largest_of_block(named, columns_of);
            row.copy_from_slice(&at[..row.len()]);
        }
        for (found, &at) in found.iter_mut().zip(&row) {
            *found = i64::from(at);
        }
    }
}

/// Index of the row with the largest value in each column of a block. The loop has no branches, so columns are compared
/// together.
fn largest_of_block(numbers: &[u32], values_of: impl Fn(u32) -> [f32; BLOCK]) -> [u32; BLOCK] {
    let mut largest = [f32::NEG_INFINITY; BLOCK];
    let mut at = [numbers[0]; BLOCK];
    for &number in numbers {
        let values = values_of(number);
        for entry in 0..BLOCK {
            let stays = (values[entry] <= largest[entry]) | largest[entry].is_nan();
            largest[entry] = if stays { largest[entry] } else { values[entry] };
            at[entry] = if stays { at[entry] } else { number };
        }
    }
    at
}

/// First values of a row. Missing values become minus infinity.
fn block_of(values: &[f32]) -> [f32; BLOCK] {
    let padded = || std::array::from_fn(|entry| values.get(entry).copied().unwrap_or(f32::NEG_INFINITY));
    values.first_chunk().copied().unwrap_or_else(padded)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_maximum_agrees_with_a_search_column_by_column(
            values in prop::collection::vec(prop_oneof![(-3..3i8).prop_map(f32::from), Just(f32::NAN)], 12),
            index in prop::collection::vec(0..4u32, 15),
        ) {
            let mut found = [-1; 9];
            neighbour_argmax(&values, 3, &index, 5, &mut found);
            for (named, row) in index.chunks(5).zip(found.chunks(3)) {
                for (column, &at) in row.iter().enumerate() {
                    let of = |number: u32| values[number as usize * 3 + column];
                    let is_nan = named.iter().find(|&&number| of(number).is_nan());
                    let most = named.iter().map(|&number| of(number)).fold(f32::NEG_INFINITY, f32::max);
                    let first = is_nan.or_else(|| named.iter().find(|&&number| of(number) == most));
                    prop_assert_eq!(Some(at), first.map(|&number| i64::from(number)));
                }
            }
        }
    }
}
