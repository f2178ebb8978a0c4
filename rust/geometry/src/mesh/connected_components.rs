//! Connected components of a mesh.

use std::collections::HashMap;

use crate::Mesh;
use crate::mesh::disjoint_sets::DisjointSets;

/// Connected components of a mesh, in the order of their first faces.
///
/// Faces are connected if they share a position. Vertex indices do not suffice: files often repeat a vertex for every
/// face.
pub fn connected_components(mesh: &Mesh) -> Vec<Mesh> {
    let mut places: HashMap<[u64; 3], u32> = HashMap::with_capacity(mesh.vertices().len());
    let place_of: Vec<u32> = mesh
        .vertices()
        .iter()
        .map(|vertex| {
            let next = places.len() as u32;
            // Adding 0 maps minus zero to zero.
            *places.entry(vertex.coords.map(|x| (x + 0.0).to_bits()).into()).or_insert(next)
        })
        .collect();
    let mut connected = DisjointSets::new(places.len());
    for face in mesh.faces() {
        let [a, b, c] = face.map(|vertex| place_of[vertex as usize]);
        connected.join(a, b);
        connected.join(a, c);
    }
    let mut component_of: HashMap<u32, usize> = HashMap::new();
    let mut components: Vec<Vec<[u32; 3]>> = Vec::new();
    for face in mesh.faces() {
        let first = connected.first_of(place_of[face[0] as usize]);
        let component = *component_of.entry(first).or_insert(components.len());
        if component == components.len() {
            components.push(Vec::new());
        }
        components[component].push(*face);
    }
    if components.len() == 1 {
        return vec![mesh.clone()];
    }
    components.into_iter().map(|faces| mesh.submesh(&faces)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_shapes::block;
    use nalgebra::Point3;
    use proptest::prelude::*;

    /// The mesh with a separate vertex for every corner of every face.
    fn unwelded(mesh: &Mesh) -> Mesh {
        let corners: Vec<Point3<f64>> = (0..mesh.faces().len()).flat_map(|face| mesh.triangle(face)).collect();
        let faces = (0..mesh.faces().len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        Mesh::new(corners, faces).expect("finite")
    }

    proptest! {
        #[test]
        fn separate_blocks_are_separate_components(count in 1usize..8, repeats in any::<bool>()) {
            let blocks: Vec<Mesh> = (0..count)
                .map(|i| block([2.0 * i as f64, 0.0, 0.0], [2.0 * i as f64 + 1.0, 1.0, 1.0]))
                .collect();
            let whole = Mesh::union(&blocks);
            let components = connected_components(&if repeats { unwelded(&whole) } else { whole });
            prop_assert_eq!(components.len(), count);
            for (component, block) in components.iter().zip(&blocks) {
                prop_assert_eq!(component.bounds(), block.bounds());
                prop_assert_eq!(component.faces().len(), block.faces().len());
            }
        }
    }

    #[test]
    fn triangles_that_share_a_corner_are_connected_despite_signed_zeros() {
        let corners =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, -0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let mesh = Mesh::new(corners.map(Point3::from).to_vec(), vec![[0, 1, 2], [3, 4, 5]]).expect("finite");
        assert_eq!(connected_components(&mesh), [mesh]);
    }
}
