//! Sample points that stand for a body in collision tests.

use nalgebra::{Point3, Vector3};

use crate::Mesh;
use crate::aabb::Aabb;
use crate::bvh::Bvh;
use crate::quasi_random::quasi_random;

/// A part or several that move as one: meshes with their trees.
#[derive(Clone, Copy)]
pub struct Solid<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The tree over its triangles.
    pub tree: &'a Bvh,
}

/// A point a little inside a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// The point.
    pub point: Point3<f64>,
    /// How far it may move before what it meets counts: 0, or the tolerance where the body is a sheet without inside.
    pub grace: f64,
}

/// Draws that may fall outside the region, for every probe wanted.
const DRAWS_PER_PROBE: usize = 8;
/// Directions in general position, along which insides are told from outsides by counting crossings.
const DIRECTIONS: [[f64; 3]; 3] = [[0.6126, 0.2837, 0.7377], [-0.3391, 0.8954, -0.2884], [0.1733, -0.4712, 0.8649]];
/// A probe that is nearer to its own surface than this share of the way that it was moved is not used.
const SHALLOW: f64 = 0.9;
/// Start of a ray off its own surface, in units of the tolerance.
const LIFT: f64 = 1e-3;

/// At most `count` points spread evenly over the surface of every mesh inside `region`, in number as the roots of the areas,
/// each moved inwards by `tolerance`, or to the middle of a wall thinner than twice that. Points that are inside `other` are left out: those bodies overlap as given.
pub fn probes_of(body: &[Solid<'_>], other: &[Solid<'_>], region: &Aabb, count: usize, tolerance: f64) -> Vec<Probe> {
    let mut cumulated = Vec::new();
    let mut total = 0.0;
    for (part, solid) in body.iter().enumerate() {
        let areas = reached_areas(solid.mesh, region);
        let sum: f64 = areas.iter().map(|&(_, area)| area).sum();
        // A small knob gets more than its share of the surface: it can be in the way like a large wall.
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
        // Beside an edge, the way inwards from one face leaves the other as near as it was.
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

/// The faces that may reach into `region`, with their areas.
fn reached_areas(mesh: &Mesh, region: &Aabb) -> Vec<(usize, f64)> {
    (0..mesh.faces().len())
        .filter(|&face| Aabb::of(&mesh.triangle(face)).squared_distance(region) == 0.0)
        .map(|face| (face, 0.5 * mesh.scaled_normal(face).norm()))
        .collect()
}

/// The way from a surface point to the inside; `None` where the surface bounds no inside.
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

/// Whether most rays from `point` leave an odd number of times.
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
    use crate::soup::{block, isometry, mapped};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn probes_of_a_block_lie_inside_as_deep_as_told(
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
            let probes = probes_of(&[Solid { mesh: &mesh, tree: &tree }], &[], tree.bounds(), 100, DEPTH);
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
