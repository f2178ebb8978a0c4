//! Probes: sample points that represent a body in collision tests.

use nalgebra::{Point3, Vector3};

use crate::Mesh;
use crate::mesh::aabb::Aabb;
use crate::mesh::bvh::Bvh;
use crate::points::quasi_random::quasi_random;

/// One mesh of a rigid body, with its search tree.
#[derive(Clone, Copy)]
pub struct BodyMesh<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Bounding volume hierarchy over its triangles.
    pub tree: &'a Bvh,
}

/// A point slightly inside a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// Position.
    pub point: Point3<f64>,
    /// Distance that the probe may move before a collision counts: 0, or the tolerance for a sheet without an inside.
    pub grace: f64,
}

/// Draws per requested probe. Draws outside the region are discarded.
const DRAWS_PER_PROBE: usize = 8;
/// Ray directions in general position, for the inside test by counting crossings.
const DIRECTIONS: [[f64; 3]; 3] = [[0.6126, 0.2837, 0.7377], [-0.3391, 0.8954, -0.2884], [0.1733, -0.4712, 0.8649]];
/// Smallest distance from a probe to its own surface, as a share of its inward shift. Nearer probes are discarded.
const SHALLOW: f64 = 0.9;
/// Start of a ray above its own surface, in units of the tolerance.
const LIFT: f64 = 1e-3;

/// Probes of a body, at most `count`, evenly spread over the surface inside `region`.
///
/// Every mesh gets probes in proportion to the square root of its area. Each probe is shifted inwards by `tolerance`,
/// or to the middle of a wall thinner than twice that. Points inside `other` are discarded, because there the bodies
/// overlap at rest.
pub fn sample_probes(
    body: &[BodyMesh<'_>],
    other: &[BodyMesh<'_>],
    region: &Aabb,
    count: usize,
    tolerance: f64,
) -> Vec<Probe> {
    let mut cumulated = Vec::new();
    let mut total = 0.0;
    for (part, solid) in body.iter().enumerate() {
        let areas = reached_areas(solid.mesh, region);
        let sum: f64 = areas.iter().map(|&(_, area)| area).sum();
        // A small knob gets more than its share of the area, because it can block a motion as well as a large wall.
        let weight = if sum > 0.0 { sum.sqrt().recip() } else { 0.0 };
        for (face, area) in areas {
            total += weight * area;
            cumulated.push((total, part, face));
        }
    }
    let mut probes = Vec::new();
    if total <= 0.0 {
        return probes;
    }
    for draw in 0..count * DRAWS_PER_PROBE {
        if probes.len() == count {
            break;
        }
        let [along, u, v] = quasi_random(draw, 0.5);
        let (_, part, face) =
            cumulated[cumulated.partition_point(|entry| entry.0 < along * total).min(cumulated.len() - 1)];
        let [a, b, c] = body[part].mesh.triangle(face);
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let point = a + (b - a) * u + (c - a) * v;
        if region.squared_distance(&Aabb { low: point, high: point }) > 0.0 {
            continue;
        }
        let normal = body[part].mesh.scaled_normal(face).normalize();
        let tree = body[part].tree;
        let probe = match inward(tree, &point, &normal, tolerance) {
            Some(inset) => Probe { point: point + inset, grace: 0.0 },
            None => Probe { point, grace: tolerance },
        };
        // Near an edge, the shift from one face may leave another face as near as before.
        let depth = (SHALLOW * (probe.point - point).norm()).powi(2);
        if tree.squared_distance_to_point(&probe.point, depth, depth).is_some() {
            continue;
        }
        if !other.iter().any(|solid| is_inside(solid.tree, &probe.point)) {
            probes.push(probe);
        }
    }
    probes
}

/// Faces that may reach into `region`, with their areas.
fn reached_areas(mesh: &Mesh, region: &Aabb) -> Vec<(usize, f64)> {
    (0..mesh.faces().len())
        .filter(|&face| Aabb::of(&mesh.triangle(face)).squared_distance(region) == 0.0)
        .map(|face| (face, 0.5 * mesh.scaled_normal(face).norm()))
        .collect()
}

/// Shift from a surface point to the inside; `None` if the surface has no inside.
fn inward(tree: &Bvh, point: &Point3<f64>, normal: &Vector3<f64>, tolerance: f64) -> Option<Vector3<f64>> {
    let odd =
        |direction: Vector3<f64>| tree.count_crossings(&(point + direction * (tolerance * LIFT)), &direction) % 2 == 1;
    let direction = match (odd(*normal), odd(-normal)) {
        (true, false) => *normal,
        (false, true) => -normal,
        _ => return None,
    };
    let start = point + direction * (tolerance * LIFT);
    let span = 2.0 * tolerance;
    let thickness = tree.first_crossing(&start, &(start + direction * span)).map_or(span, |share| share * span);
    Some(direction * (0.5 * thickness))
}

/// True if most rays from `point` cross the surface an odd number of times.
fn is_inside(tree: &Bvh, point: &Point3<f64>) -> bool {
    if tree.bounds().squared_distance(&Aabb { low: *point, high: *point }) > 0.0 {
        return false;
    }
    let odd = |direction: [f64; 3]| tree.count_crossings(point, &Vector3::from(direction)) % 2 == 1;
    let [first, second] = [odd(DIRECTIONS[0]), odd(DIRECTIONS[1])];
    if first == second { first } else { odd(DIRECTIONS[2]) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_shapes::{block, isometry, mapped};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn probes_of_a_block_lie_inside_at_the_given_depth(
            sides in prop::array::uniform3(0.2..1.0f64), place in isometry(), inside_out in any::<bool>(),
        ) {
            const DEPTH: f64 = 0.02;
            let upright = block(sides.map(|x| -x), sides);
            let mut mesh = mapped(&upright, |p| place * p);
            if inside_out {
                let faces = mesh.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
                mesh = Mesh::new(mesh.vertices().to_vec(), faces).expect("finite");
            }
            let tree = Bvh::new(&mesh);
            let probes = sample_probes(&[BodyMesh { mesh: &mesh, tree: &tree }], &[], tree.bounds(), 100, DEPTH);
            prop_assert!(probes.len() > 80);
            for probe in probes {
                let point = place.inverse() * probe.point;
                let depth = (0..3).map(|axis| sides[axis] - point[axis].abs()).fold(f64::INFINITY, f64::min);
                prop_assert!((SHALLOW * DEPTH - 1e-9..=DEPTH + 1e-9).contains(&depth), "{depth}");
                prop_assert_eq!(probe.grace, 0.0);
            }
        }
    }
}
