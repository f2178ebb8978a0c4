//! The pieces that a mesh falls into.

use std::collections::HashMap;

use crate::Mesh;

/// The connected pieces of a mesh, in the order of their first faces.
///
/// Faces hang together where they share a place: files often repeat a vertex for every face that meets there.
pub fn connected_pieces(mesh: &Mesh) -> Vec<Mesh> {
    let mut places: HashMap<[u64; 3], u32> = HashMap::with_capacity(mesh.vertices().len());
    let place_of: Vec<u32> = mesh
        .vertices()
        .iter()
        .map(|vertex| {
            let next = places.len() as u32;
            // of a zero there are two, which are one place
            *places.entry(vertex.coords.map(|x| (x + 0.0).to_bits()).into()).or_insert(next)
        })
        .collect();
    let mut leaders: Vec<u32> = (0..places.len() as u32).collect();
    for face in mesh.faces() {
        let [a, b, c] = face.map(|vertex| leader_of(&mut leaders, place_of[vertex as usize]));
        let least = a.min(b).min(c);
        for leader in [a, b, c] {
            leaders[leader as usize] = least;
        }
    }
    let mut piece_of: HashMap<u32, usize> = HashMap::new();
    let mut pieces: Vec<Vec<[u32; 3]>> = Vec::new();
    for face in mesh.faces() {
        let leader = leader_of(&mut leaders, place_of[face[0] as usize]);
        let piece = *piece_of.entry(leader).or_insert(pieces.len());
        if piece == pieces.len() {
            pieces.push(Vec::new());
        }
        pieces[piece].push(*face);
    }
    if pieces.len() == 1 {
        return vec![mesh.clone()];
    }
    pieces.into_iter().map(|faces| mesh.part_of(&faces)).collect()
}

/// The place that stands for all that hang together with `place`; the way there is halved.
fn leader_of(leaders: &mut [u32], mut place: u32) -> u32 {
    while leaders[place as usize] != place {
        leaders[place as usize] = leaders[leaders[place as usize] as usize];
        place = leaders[place as usize];
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::soup::block;
    use nalgebra::Point3;
    use proptest::prelude::*;

    /// The mesh with a vertex of its own for every corner of every face.
    fn unwelded(mesh: &Mesh) -> Mesh {
        let corners: Vec<Point3<f64>> = (0..mesh.faces().len()).flat_map(|face| mesh.triangle(face)).collect();
        let faces = (0..mesh.faces().len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        Mesh::new(corners, faces).expect("finite")
    }

    proptest! {
        #[test]
        fn blocks_that_do_not_touch_are_a_piece_each(count in 1usize..8, repeats in any::<bool>()) {
            let blocks: Vec<Mesh> = (0..count)
                .map(|i| block([2.0 * i as f64, 0.0, 0.0], [2.0 * i as f64 + 1.0, 1.0, 1.0]))
                .collect();
            let whole = Mesh::union(&blocks);
            let pieces = connected_pieces(&if repeats { unwelded(&whole) } else { whole });
            prop_assert_eq!(pieces.len(), count);
            for (piece, block) in pieces.iter().zip(&blocks) {
                prop_assert_eq!(piece.bounds(), block.bounds());
                prop_assert_eq!(piece.faces().len(), block.faces().len());
            }
        }
    }

    #[test]
    fn what_meets_in_a_point_is_one_piece_whatever_the_sign_of_zero() {
        let corners =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, -0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let mesh = Mesh::new(corners.map(Point3::from).to_vec(), vec![[0, 1, 2], [3, 4, 5]]).expect("finite");
        assert_eq!(connected_pieces(&mesh), [mesh]);
    }
}
