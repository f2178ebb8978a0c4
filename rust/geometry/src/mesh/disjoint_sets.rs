//! Disjoint sets of numbers.

use std::collections::HashMap;

/// Disjoint sets of numbers (union-find with path halving); each is represented by its least member.
pub(crate) struct DisjointSets {
    above: Vec<u32>,
}

impl DisjointSets {
    /// `count` sets of one number each.
    pub(crate) fn new(count: usize) -> Self {
        Self { above: (0..count as u32).collect() }
    }

    /// The least member of the set that `member` is in.
    pub(crate) fn first_of(&mut self, mut member: u32) -> u32 {
        while self.above[member as usize] != member {
            self.above[member as usize] = self.above[self.above[member as usize] as usize];
            member = self.above[member as usize];
        }
        member
    }

    /// Unite the sets of two members.
    pub(crate) fn join(&mut self, first: u32, second: u32) {
        let (first, second) = (self.first_of(first), self.first_of(second));
        self.above[first.max(second) as usize] = first.min(second);
    }

    /// Number of the set of every member, from 0 in the order of their first members.
    pub(crate) fn numbers(&mut self) -> Vec<u32> {
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        (0..self.above.len() as u32)
            .map(|member| {
                let next = numbers.len() as u32;
                *numbers.entry(self.first_of(member)).or_insert(next)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn members_have_one_number_if_a_chain_of_joined_pairs_links_them(
            pairs in prop::collection::vec((0u32..12, 0u32..12), 0..20)
        ) {
            let mut sets = DisjointSets::new(12);
            let mut linked: Vec<u32> = (0..12).collect();
            for &(first, second) in &pairs {
                sets.join(first, second);
                let (old, new) = (linked[first as usize], linked[second as usize]);
                linked.iter_mut().filter(|label| **label == old).for_each(|label| *label = new);
            }
            let numbers = sets.numbers();
            for first in 0..12 {
                for second in 0..12 {
                    prop_assert_eq!(numbers[first] == numbers[second], linked[first] == linked[second]);
                }
            }
            let count = *numbers.iter().max().expect("12 members") as usize + 1;
            prop_assert!((0..count as u32).all(|number| numbers.contains(&number)));
        }
    }
}
