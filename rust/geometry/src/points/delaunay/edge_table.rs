//! Hash table that pairs the faces at an edge.

/// Hash table of the edges of the cavity's surface. Two new tetrahedra with the same edge share a face.
#[derive(Clone, Default)]
pub struct EdgeTable {
    slots: Vec<EdgeSlot>,
    stamp: u32,
}

/// An edge's corners, the first face stored for it (4 times the tetrahedron plus the face), and the round of the entry.
#[derive(Clone, Copy, Default)]
struct EdgeSlot {
    edge: [u32; 2],
    face: u32,
    stamp: u32,
}

impl EdgeTable {
    /// Empties the table, and reserves space for the edges of `faces` triangles.
    pub fn clear(&mut self, faces: usize) {
        let size = (4 * faces).next_power_of_two();
        if self.slots.len() < size {
            self.slots = vec![EdgeSlot::default(); size];
            self.stamp = 0;
        }
        self.stamp += 1;
    }

    /// Returns the face stored for the edge. If there is none, stores this one and returns `None`.
    pub fn pair(&mut self, u: u32, v: u32, face: u32) -> Option<u32> {
        let edge = [u.min(v), u.max(v)];
        let mask = self.slots.len() - 1;
        let mut at = (edge[0].wrapping_mul(0x9E37_79B9) ^ edge[1].wrapping_mul(0x85EB_CA6B)) as usize >> 12 & mask;
        loop {
            let slot = &mut self.slots[at];
            if slot.stamp != self.stamp {
                *slot = EdgeSlot { edge, face, stamp: self.stamp };
                return None;
            }
            if slot.edge == edge {
                return Some(slot.face);
            }
            at = (at + 1) & mask;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_second_face_at_an_edge_is_paired_with_the_first(
            rounds in prop::collection::vec(prop::collection::vec((0u32..12, 0u32..12), 1..60), 1..5),
        ) {
            let mut table = EdgeTable::default();
            for edges in rounds {
                table.clear(edges.len());
                let mut first = HashMap::new();
                for ((u, v), face) in edges.into_iter().zip(0..) {
                    let expected = first.get(&(u.min(v), u.max(v))).copied();
                    prop_assert_eq!(table.pair(u, v, face), expected);
                    first.entry((u.min(v), u.max(v))).or_insert(face);
                }
            }
        }
    }
}
