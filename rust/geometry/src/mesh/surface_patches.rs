//! Patches of a mesh: faces that are joined across edges without a concave crease between them.
//!
//! Solids that touch or were welded together meet at concave creases, as a knob and its door do, or share an edge of more
//! than two faces. A convex solid is one patch.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use crate::Mesh;
use crate::mesh::disjoint_sets::DisjointSets;

/// Cells of the grid that finds vertices on an edge, along the diagonal of the mesh.
const CELLS: f64 = 256.0;
/// Most cells, along all boundary edges together, that are searched for vertices on an edge.
const MAX_SEARCHED_CELLS: f64 = 1e6;
/// Share of the faces of a component that have a reversed copy, from which it is a model of two-sided sheets.
const TWO_SIDED: f64 = 0.8;

/// Number of the patch of every face.
///
/// Patches never join faces that have no position in common, directly or through others. A boundary edge ends at the
/// vertices that lie on it, so that the two sides of a seam need not have the same vertices; this is left out for meshes
/// that are hardly more than boundary. Where faces have no consistent winding, an edge of two faces joins them.
///
/// # Arguments
///
/// * `mesh`: the mesh; vertices at one place have one index.
/// * `tolerance`: largest distance of a vertex that lies on an edge, in the units of the mesh.
/// * `crease`: largest angle between the normals of faces that are joined across a concave edge, in radians.
pub fn surface_patches(mesh: &Mesh, tolerance: f64, crease: f64) -> Vec<u32> {
    let surface = Surface::new(mesh);
    let mut joined = DisjointSets::new(mesh.faces().len());
    surface.join_copies(&mut joined);
    let mut uses = surface.edge_uses();
    uses.sort_unstable_by_key(EdgeUse::key);
    let mut cut: Vec<EdgeUse> = Vec::with_capacity(uses.len());
    let seam = Seam::new(&surface, &uses, tolerance);
    for same_edge in uses.chunk_by(|a, b| a.ends() == b.ends()) {
        match same_edge {
            [alone] => seam.cut(*alone, &mut cut),
            _ => cut.extend_from_slice(same_edge),
        }
    }
    cut.sort_unstable_by_key(EdgeUse::key);
    for same_edge in cut.chunk_by(|a, b| a.ends() == b.ends()) {
        match same_edge {
            [_] => {}
            [first, second] => surface.join_two(*first, *second, crease, &mut joined),
            _ => surface.join_around(same_edge, crease, &mut joined),
        }
    }
    surface.join_flat(&mut joined);
    joined.numbers()
}

/// A face at an edge, which it runs along from `from` to `to`.
#[derive(Clone, Copy)]
struct EdgeUse {
    from: u32,
    to: u32,
    face: u32,
}

impl EdgeUse {
    fn ends(&self) -> (u32, u32) {
        (self.from.min(self.to), self.from.max(self.to))
    }

    fn key(&self) -> (u32, u32, u32, u32) {
        let (low, high) = self.ends();
        (low, high, self.face, self.from)
    }
}

/// A mesh with what is known of its faces.
struct Surface<'a> {
    mesh: &'a Mesh,
    /// Unit normals, turned outwards as a whole for each component. None for faces without an area.
    normals: Vec<Option<Vector3<f64>>>,
    /// True for faces that the winding was turned of.
    is_turned: Vec<bool>,
    /// The first face with the same corners; for reversed copies only in two-sided models.
    original: Vec<u32>,
}

impl<'a> Surface<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let faces = mesh.faces();
        let component = components(mesh);
        let crosses: Vec<Vector3<f64>> = (0..faces.len())
            .map(|face| {
                let [a, b, c] = mesh.triangle(face);
                (b - a).cross(&(c - a))
            })
            .collect();
        let mut middle: HashMap<u32, (Vector3<f64>, f64)> = HashMap::new();
        for (face, cross) in crosses.iter().enumerate() {
            let [a, b, c] = mesh.triangle(face);
            let (sum, area) = middle.entry(component[face]).or_default();
            *sum += (a.coords + b.coords + c.coords) / 3.0 * cross.norm();
            *area += cross.norm();
        }
        let mut volume: HashMap<u32, f64> = HashMap::new();
        for (face, cross) in crosses.iter().enumerate() {
            let (sum, area) = middle[&component[face]];
            let center = sum / area.max(f64::MIN_POSITIVE);
            *volume.entry(component[face]).or_default() += (mesh.triangle(face)[0].coords - center).dot(cross);
        }
        let is_turned: Vec<bool> = component.iter().map(|each| volume[each] < 0.0).collect();
        let normals = crosses
            .iter()
            .zip(&is_turned)
            .map(|(cross, &turned)| cross.try_normalize(0.0).map(|normal| if turned { -normal } else { normal }))
            .collect();
        let original = originals(mesh, &component);
        Self { mesh, normals, is_turned, original }
    }

    fn point(&self, vertex: u32) -> Point3<f64> {
        self.mesh.vertices()[vertex as usize]
    }

    /// Join every face with the one that it is a copy of.
    fn join_copies(&self, joined: &mut DisjointSets) {
        for (face, &original) in self.original.iter().enumerate() {
            joined.join(face as u32, original);
        }
    }

    /// The edges of all faces that have an area and are no copies, as they run seen from outside.
    fn edge_uses(&self) -> Vec<EdgeUse> {
        let mut uses = Vec::with_capacity(3 * self.normals.len());
        for (face, corners) in self.mesh.faces().iter().enumerate() {
            if self.normals[face].is_none() || self.original[face] != face as u32 {
                continue;
            }
            for side in 0..3 {
                let (mut from, mut to) = (corners[side], corners[(side + 1) % 3]);
                if self.is_turned[face] {
                    (from, to) = (to, from);
                }
                if from != to {
                    uses.push(EdgeUse { from, to, face: face as u32 });
                }
            }
        }
        uses
    }

    /// Unit vector across the edge from `origin` along `along`, into the face.
    fn inwards(&self, face: u32, origin: Point3<f64>, along: Vector3<f64>) -> Option<Vector3<f64>> {
        let corners = self.mesh.triangle(face as usize);
        let across = corners.map(|corner| {
            let offset = corner - origin;
            offset - along * along.dot(&offset)
        });
        across.into_iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?.try_normalize(0.0)
    }

    /// Join the two faces of an edge unless it is a concave crease.
    fn join_two(&self, first: EdgeUse, second: EdgeUse, crease: f64, joined: &mut DisjointSets) {
        let (Some(normal), Some(other)) = (self.normals[first.face as usize], self.normals[second.face as usize])
        else {
            return;
        };
        let origin = self.point(first.from);
        let Some(along) = (self.point(first.to) - origin).try_normalize(0.0) else { return };
        let Some(inwards) = self.inwards(second.face, origin, along) else { return };
        let is_consistent = first.from == second.to;
        let is_convex = normal.dot(&inwards) <= 0.0;
        if !is_consistent || is_convex || normal.dot(&other) >= crease.cos() {
            joined.join(first.face, second.face);
        }
    }

    /// Join the faces at an edge of more than two: those with a convex solid between them, and flat continuations.
    fn join_around(&self, uses: &[EdgeUse], crease: f64, joined: &mut DisjointSets) {
        use std::f64::consts::{PI, TAU};
        let (low, high) = uses[0].ends();
        let origin = self.point(low);
        let Some(along) = (self.point(high) - origin).try_normalize(0.0) else { return };
        let Some(x) = self.inwards(uses[0].face, origin, along) else { return };
        let y = along.cross(&x);
        // The solid of a face that runs along the edge lies at smaller angles, that of the others at larger ones.
        let mut around: Vec<(f64, bool, u32)> = uses
            .iter()
            .filter_map(|each| {
                let inwards = self.inwards(each.face, origin, along)?;
                let angle = inwards.dot(&y).atan2(inwards.dot(&x)).rem_euclid(TAU);
                let angle = if TAU - angle < 1e-6 { 0.0 } else { angle };
                Some(((angle * 1e6).round() * 1e-6, each.from != low, each.face))
            })
            .collect();
        around.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        let count = around.len();
        let mut is_joined = vec![false; count];
        for place in 0..count {
            let next = (place + 1) % count;
            let gap = (around[next].0 - around[place].0).rem_euclid(TAU);
            let has_solid = around[place].1 && !around[next].1;
            if has_solid && gap > 0.0 && gap <= PI + crease {
                joined.join(around[place].2, around[next].2);
                (is_joined[place], is_joined[next]) = (true, true);
            }
        }
        for place in 0..count {
            let flat =
                (0..count).filter(|&other| other != place && !(is_joined[place] && is_joined[other])).find(|&other| {
                    let angle = (around[other].0 - around[place].0).rem_euclid(TAU);
                    around[other].1 != around[place].1 && (angle - PI).abs() <= crease
                });
            if let Some(other) = flat {
                joined.join(around[place].2, around[other].2);
            }
        }
    }

    /// Join every face without an area with another one that has the same vertex.
    fn join_flat(&self, joined: &mut DisjointSets) {
        let mut at: HashMap<u32, u32> = HashMap::new();
        for (face, corners) in self.mesh.faces().iter().enumerate() {
            if self.normals[face].is_some() {
                for &corner in corners {
                    at.entry(corner).or_insert(face as u32);
                }
            }
        }
        for (face, corners) in self.mesh.faces().iter().enumerate() {
            if self.normals[face].is_none() {
                for &corner in corners {
                    match at.get(&corner) {
                        Some(&other) => {
                            joined.join(face as u32, other);
                            break;
                        }
                        None => {
                            at.insert(corner, face as u32);
                        }
                    }
                }
            }
        }
    }
}

/// The vertices at the boundary of a surface, in a grid.
struct Seam<'a> {
    surface: &'a Surface<'a>,
    tolerance: f64,
    cell: f64,
    vertices: HashMap<[i64; 3], Vec<u32>>,
}

impl<'a> Seam<'a> {
    /// `uses` are sorted by their edges.
    fn new(surface: &'a Surface<'a>, uses: &[EdgeUse], tolerance: f64) -> Self {
        let cell = (surface.mesh.diagonal() / CELLS).max(2.0 * tolerance).max(f64::MIN_POSITIVE);
        let alone: Vec<&EdgeUse> = uses
            .chunk_by(|a, b| a.ends() == b.ends())
            .filter_map(|same| if let [edge] = same { Some(edge) } else { None })
            .collect();
        let length: f64 = alone.iter().map(|edge| (surface.point(edge.to) - surface.point(edge.from)).norm()).sum();
        let is_searched = length / cell + alone.len() as f64 <= MAX_SEARCHED_CELLS;
        let mut ends: Vec<u32> = alone.iter().filter(|_| is_searched).flat_map(|edge| [edge.from, edge.to]).collect();
        ends.sort_unstable();
        ends.dedup();
        let mut seam = Self { surface, tolerance, cell, vertices: HashMap::new() };
        for vertex in ends {
            let cell = seam.cell_of(surface.point(vertex));
            seam.vertices.entry(cell).or_default().push(vertex);
        }
        seam
    }

    fn cell_of(&self, point: Point3<f64>) -> [i64; 3] {
        point.coords.map(|x| (x / self.cell).floor() as i64).into()
    }

    /// Add an edge of one face to `found`, cut at the vertices that lie on it.
    fn cut(&self, edge: EdgeUse, found: &mut Vec<EdgeUse>) {
        let (start, end) = (self.surface.point(edge.from), self.surface.point(edge.to));
        let length = (end - start).norm();
        let mut on: Vec<(f64, u32)> = Vec::new();
        if length > 2.0 * self.tolerance && !self.vertices.is_empty() {
            let along = (end - start) / length;
            let steps = (length / self.cell).ceil() as usize;
            let mut cells: Vec<[i64; 3]> = Vec::new();
            for step in 0..=steps {
                let [i, j, k] = self.cell_of(start + along * (length * step as f64 / steps as f64));
                for around in 0..27 {
                    cells.push([i + around % 3 - 1, j + around / 3 % 3 - 1, k + around / 9 - 1]);
                }
            }
            cells.sort_unstable();
            cells.dedup();
            for &vertex in cells.iter().filter_map(|cell| self.vertices.get(cell)).flatten() {
                let offset = self.surface.point(vertex) - start;
                let place = along.dot(&offset);
                let is_inside = place > self.tolerance && place < length - self.tolerance;
                if is_inside && (offset - along * place).norm() <= self.tolerance {
                    on.push((place, vertex));
                }
            }
        }
        on.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut from = edge.from;
        for to in on.into_iter().map(|(_, vertex)| vertex).chain([edge.to]) {
            found.push(EdgeUse { from, to, ..edge });
            from = to;
        }
    }
}

/// Component of every face: faces that share a vertex are connected.
fn components(mesh: &Mesh) -> Vec<u32> {
    let mut joined = DisjointSets::new(mesh.vertices().len());
    for [a, b, c] in mesh.faces() {
        joined.join(*a, *b);
        joined.join(*a, *c);
    }
    mesh.faces().iter().map(|face| joined.first_of(face[0])).collect()
}

/// For every face the first one with the same corners and winding; in two-sided models with the same corners.
fn originals(mesh: &Mesh, component: &[u32]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], [Option<u32>; 2]> = HashMap::new();
    let mut reversed: HashMap<u32, (usize, usize)> = HashMap::new();
    let keys: Vec<([u32; 3], usize)> = mesh.faces().iter().map(|&face| sorted_corners(face)).collect();
    for (face, &(corners, winding)) in keys.iter().enumerate() {
        first.entry(corners).or_default()[winding].get_or_insert(face as u32);
    }
    for (face, (corners, winding)) in keys.iter().enumerate() {
        let (copies, all) = reversed.entry(component[face]).or_default();
        *copies += usize::from(first[corners][1 - winding].is_some());
        *all += 1;
    }
    keys.iter()
        .enumerate()
        .map(|(face, (corners, winding))| {
            let (copies, all) = reversed[&component[face]];
            let [forward, backward] = first[corners];
            let own = first[corners][*winding].expect("the face itself is one");
            let is_two_sided = copies as f64 >= TWO_SIDED * all as f64;
            if is_two_sided { forward.unwrap_or(own).min(backward.unwrap_or(own)) } else { own }
        })
        .collect()
}

/// The corners of a face in ascending order, and whether that reverses it.
fn sorted_corners(mut face: [u32; 3]) -> ([u32; 3], usize) {
    let mut swaps = 0;
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if face[i] > face[j] {
            face.swap(i, j);
            swaps += 1;
        }
    }
    (face, swaps % 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_shapes::block;
    use proptest::prelude::*;

    const CREASE: f64 = 0.5;

    /// The blocks as one mesh, where vertices at one place have one index.
    fn welded(blocks: &[Mesh]) -> Mesh {
        let whole = Mesh::union(blocks);
        let mut place: HashMap<[u64; 3], u32> = HashMap::new();
        let mut vertices = Vec::new();
        let index: Vec<u32> = whole
            .vertices()
            .iter()
            .map(|vertex| {
                *place.entry(vertex.coords.map(|x| (x + 0.0).to_bits()).into()).or_insert_with(|| {
                    vertices.push(*vertex);
                    vertices.len() as u32 - 1
                })
            })
            .collect();
        let faces = whole.faces().iter().map(|face| face.map(|corner| index[corner as usize])).collect();
        Mesh::new(vertices, faces).expect("finite")
    }

    fn count_of(patches: &[u32]) -> usize {
        patches.iter().max().map_or(0, |&last| last as usize + 1)
    }

    proptest! {
        #[test]
        fn blocks_that_share_corners_are_one_patch_each(count in 1usize..6, turned in any::<bool>()) {
            let blocks: Vec<Mesh> =
                (0..count).map(|i| block([i as f64, 0.0, 0.0], [i as f64 + 1.0, 1.0, 1.0 + (i % 2) as f64])).collect();
            let mut whole = welded(&blocks);
            if turned {
                let faces = whole.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
                whole = Mesh::new(whole.vertices().to_vec(), faces).expect("finite");
            }
            let patches = surface_patches(&whole, 1e-6, CREASE);
            prop_assert_eq!(count_of(&patches), count);
            for (face, patch) in patches.iter().enumerate() {
                prop_assert_eq!(*patch as usize, face / 12);
            }
        }
    }

    /// A square in the plane z = 0 between two corners.
    fn square(low: [f64; 2], high: [f64; 2]) -> Mesh {
        let corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]];
        let vertices = corners.map(|[x, y]| Point3::new(x, y, 0.0)).to_vec();
        Mesh::new(vertices, vec![[0, 1, 2], [0, 2, 3]]).expect("finite")
    }

    #[test]
    fn a_seam_with_different_vertices_joins_its_sides() {
        let whole =
            welded(&[square([0.0, 0.0], [1.0, 2.0]), square([1.0, 0.0], [2.0, 1.0]), square([1.0, 1.0], [2.0, 2.0])]);
        assert_eq!(count_of(&surface_patches(&whole, 1e-6, CREASE)), 1);
    }

    #[test]
    fn squares_that_share_one_corner_are_apart() {
        let whole = welded(&[square([0.0, 0.0], [1.0, 1.0]), square([1.0, 1.0], [2.0, 2.0])]);
        assert_eq!(count_of(&surface_patches(&whole, 1e-6, CREASE)), 2);
    }

    #[test]
    fn a_block_of_two_sided_sheets_is_one_patch() {
        let one = block([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]);
        let faces = one.faces().iter().flat_map(|&[a, b, c]| [[a, b, c], [a, c, b]]).collect();
        let whole = welded(&[Mesh::new(one.vertices().to_vec(), faces).expect("finite")]);
        assert_eq!(count_of(&surface_patches(&whole, 1e-6, CREASE)), 1);
    }

    #[test]
    fn a_face_without_an_area_belongs_to_a_neighbour() {
        let one = block([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]);
        let mut faces = one.faces().to_vec();
        faces.push([0, 0, 1]);
        let whole = welded(&[Mesh::new(one.vertices().to_vec(), faces).expect("finite")]);
        assert_eq!(count_of(&surface_patches(&whole, 1e-6, CREASE)), 1);
    }
}
