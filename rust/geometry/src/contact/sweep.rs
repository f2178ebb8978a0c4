//! Free travel of a part along a joint.
//!
//! Parts of real objects touch or overlap slightly at rest. Travel therefore ends at growing penetration, not at
//! contact. Both bodies are represented by probes: points slightly inside their surfaces. A probe collides where its
//! path crosses the other body's surface. Probes inside the other body at rest are discarded. The moving part's probes
//! move against the obstacles, and the obstacles' probes move back against the part.

use nalgebra::Point3;

use crate::contact::clearance_grid::ClearanceGrid;
use crate::contact::collision_probes::{BodyMesh, Probe, sample_probes};
use crate::mesh::aabb::Aabb;
use crate::mesh::bvh::Bvh;
use crate::motion::joint_axis::{JointAxis, JointKind, RigidMotion};

/// A candidate joint with limits. Travel is in radians for revolute and screw joints, and a length for prismatic ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CandidateJoint {
    /// Axis of the joint.
    pub axis: JointAxis,
    /// Length per radian of a screw.
    pub pitch: f64,
    /// Limits of the travel: downwards (at most 0) and upwards (at least 0).
    pub limits: [f64; 2],
}

impl CandidateJoint {
    fn displacement(&self, travel: f64) -> RigidMotion {
        let shift = if self.axis.kind == JointKind::Prismatic { travel } else { self.pitch * travel };
        self.axis.displacement(travel, shift)
    }

    /// Path length of a point per unit of travel.
    fn speed(&self, point: &Point3<f64>) -> f64 {
        let radius = (point - self.axis.pivot).cross(&self.axis.direction).norm();
        match self.axis.kind {
            JointKind::Prismatic => 1.0,
            JointKind::Revolute => radius,
            JointKind::Screw => radius.hypot(self.pitch),
        }
    }
}

/// Largest number of steps of a straight motion. It affects the time, not the result.
const STRAIGHT_STEPS: usize = 5;

/// Largest rounding error of a coordinate, in diagonals of the swept box.
const ROUNDING: f64 = 1e-9;

/// Resolution and tolerances of a sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweepOptions {
    /// Number of probes of either body.
    pub probes: usize,
    /// Number of steps per direction. Rotations are straight in between.
    pub steps: usize,
    /// Overlap at rest that is no collision, as a share of the moving part's diagonal.
    pub tolerance: f64,
    /// Share of the probes of either body that may collide before the travel ends.
    pub ignored_share: f64,
}

/// Free travel of a candidate joint, downwards and upwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// Travel up to the collision, or the limit if there is none.
    pub free: [f64; 2],
    /// Share of the probes that collide up to the limit, of the body with the larger share.
    pub penetration: [f64; 2],
}

/// Probes of one body against the surface of the other.
struct ProbeSide<'a> {
    probes: Vec<Probe>,
    trees: Vec<&'a Bvh>,
    grid: Option<ClearanceGrid>,
}

impl<'a> ProbeSide<'a> {
    fn new(
        body: &[BodyMesh<'_>],
        other: &[BodyMesh<'a>],
        reached: &Aabb,
        region: &Aabb,
        options: &SweepOptions,
    ) -> Self {
        let tolerance = options.tolerance * reached.squared_diagonal().min(region.squared_diagonal()).sqrt();
        // No path leaves the reached box, but for rounding.
        let near = reached.grown(ROUNDING * reached.squared_diagonal().sqrt());
        let is_near = |tree: &&Bvh| tree.bounds().squared_distance(&near) == 0.0;
        let trees: Vec<&Bvh> = other.iter().map(|solid| solid.tree).filter(is_near).collect();
        let bounds = bounds_of(other).intersection(reached);
        Self {
            probes: sample_probes(body, other, region, options.probes, tolerance),
            grid: bounds.map(|bounds| ClearanceGrid::new(&trees, &bounds)),
            trees,
        }
    }

    /// Steps at which the probes first collide, with fractions, in ascending order.
    fn collisions(&self, candidate: &CandidateJoint, travel: f64, motions: &[RigidMotion]) -> Vec<f64> {
        let Some(grid) = &self.grid else { return Vec::new() };
        let step = travel.abs() / (motions.len() - 1) as f64;
        let mut found: Vec<f64> = self
            .probes
            .iter()
            .filter_map(|probe| {
                let stride = candidate.speed(&probe.point) * step;
                self.collision(grid, probe, stride, motions)
            })
            .collect();
        found.sort_unstable_by(f64::total_cmp);
        found
    }

    fn collision(&self, grid: &ClearanceGrid, probe: &Probe, stride: f64, motions: &[RigidMotion]) -> Option<f64> {
        let last = motions.len() - 1;
        let start = if probe.grace > 0.0 { (probe.grace / stride).min(last as f64) } else { 0.0 };
        let mut at = start as usize;
        // Share of the first step that the grace distance takes.
        let mut gone = start - at as f64;
        let mut point = motions[at] * probe.point;
        if gone > 0.0 {
            point += (motions[at + 1] * probe.point - point) * gone;
        }
        while at < last {
            let clear = (gone + grid.clearance(&point) / stride).min(last as f64) as usize;
            if clear > 0 {
                (at, gone) = ((at + clear).min(last), 0.0);
                point = motions[at] * probe.point;
                continue;
            }
            let next = motions[at + 1] * probe.point;
            let met = self.trees.iter().filter_map(|tree| tree.first_crossing(&point, &next)).min_by(f64::total_cmp);
            if let Some(share) = met {
                return Some(at as f64 + gone + share * (1.0 - gone));
            }
            (at, gone, point) = (at + 1, 0.0, next);
        }
        None
    }
}

/// A part among obstacles: the probes of both bodies that any of the candidate joints can bring into contact.
pub struct SweepScene<'a> {
    moving_side: ProbeSide<'a>,
    obstacle_side: ProbeSide<'a>,
    options: SweepOptions,
}

impl<'a> SweepScene<'a> {
    /// Samples probes in the region that `candidates` can reach.
    pub fn new(
        moving: &[BodyMesh<'a>],
        obstacles: &[BodyMesh<'a>],
        candidates: &[CandidateJoint],
        options: SweepOptions,
    ) -> Self {
        let own = bounds_of(moving);
        let swept = candidates.iter().fold(own, |bounds, candidate| bounds.merged(&swept_bounds(&own, candidate)));
        Self {
            moving_side: ProbeSide::new(moving, obstacles, &swept, &own, &options),
            obstacle_side: ProbeSide::new(obstacles, moving, &own, &swept, &options),
            options,
        }
    }

    /// Free travel of one of the candidates.
    pub fn travel(&self, candidate: &CandidateJoint) -> Travel {
        let mut result = Travel { free: candidate.limits, penetration: [0.0; 2] };
        for (direction, &limit) in candidate.limits.iter().enumerate() {
            if limit == 0.0 {
                continue;
            }
            let steps = match candidate.axis.kind {
                JointKind::Prismatic => self.options.steps.min(STRAIGHT_STEPS),
                _ => self.options.steps,
            };
            let step = limit / steps as f64;
            for (side, sign) in [(&self.moving_side, 1.0), (&self.obstacle_side, -1.0)] {
                let motions: Vec<RigidMotion> =
                    (0..=steps).map(|at| candidate.displacement(sign * step * at as f64)).collect();
                let collisions = side.collisions(candidate, limit, &motions);
                let count = side.probes.len().max(1) as f64;
                result.penetration[direction] = result.penetration[direction].max(collisions.len() as f64 / count);
                let ignored = (self.options.ignored_share * count) as usize;
                if let Some(at) = collisions.get(ignored) {
                    let free = step * at;
                    if free.abs() < result.free[direction].abs() {
                        result.free[direction] = free;
                    }
                }
            }
        }
        result
    }
}

fn bounds_of(body: &[BodyMesh<'_>]) -> Aabb {
    body.iter().fold(Aabb::empty(), |bounds, solid| bounds.merged(solid.tree.bounds()))
}

/// Box around the path of a moving box.
fn swept_bounds(bounds: &Aabb, candidate: &CandidateJoint) -> Aabb {
    /// Step between positions in radians. In between, a corner deviates by at most its radius times the versine of half
    /// a step.
    const LOOK: f64 = 0.25;
    let [lower, upper] = candidate.limits;
    let looks = match candidate.axis.kind {
        JointKind::Prismatic => 1,
        _ => (((upper - lower) / LOOK).ceil() as usize).clamp(1, 64),
    };
    let mut swept = *bounds;
    let mut radius = 0.0f64;
    for corner in bounds.corners() {
        radius = radius.max((corner - candidate.axis.pivot).cross(&candidate.axis.direction).norm());
        for look in 0..=looks {
            let travel = lower + (upper - lower) * look as f64 / looks as f64;
            let moved = candidate.displacement(travel) * corner;
            swept = swept.merged(&Aabb { low: moved, high: moved });
        }
    }
    match candidate.axis.kind {
        JointKind::Prismatic => swept,
        _ => swept.grown(radius * (1.0 - (0.5 * (upper - lower) / looks as f64).min(std::f64::consts::PI).cos())),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{IsometryMatrix3, Unit, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::Mesh;
    use crate::contact::part_distance::PartBvh;
    use crate::test_shapes::{block, isometry, mapped};

    const OPTIONS: SweepOptions = SweepOptions { probes: 300, steps: 16, tolerance: 0.01, ignored_share: 0.005 };
    /// Largest deviation of the straight steps from the arc, for radii of at most three lengths.
    const STRAY: f64 = 0.02;

    fn candidates() -> impl Strategy<Value = CandidateJoint> {
        let kinds = prop::sample::select(vec![JointKind::Revolute, JointKind::Prismatic, JointKind::Screw]);
        let vector = || prop::array::uniform3(-1.0..1.0f64);
        (kinds, vector(), vector(), 0.2..1.5f64, -0.3..0.3f64).prop_filter_map(
            "a direction",
            |(kind, direction, pivot, limit, pitch)| {
                let direction = Unit::try_new(Vector3::from(direction), 0.1)?;
                Some(CandidateJoint {
                    axis: JointAxis { kind, direction, pivot: pivot.into() },
                    pitch,
                    limits: [-limit, limit],
                })
            },
        )
    }

    fn blocks() -> impl Strategy<Value = (Mesh, Mesh)> {
        let sides = || prop::array::uniform3(0.1..0.5f64);
        (sides(), sides(), isometry()).prop_map(|(a, b, place)| {
            let obstacle = mapped(&block(b.map(|x| -x), b), |p| place * p);
            (block(a.map(|x| -x), a), obstacle)
        })
    }

    fn travel(moving: &Mesh, obstacle: &Mesh, candidate: &CandidateJoint) -> Travel {
        let trees = [Bvh::new(moving), Bvh::new(obstacle)];
        let solids = [BodyMesh { mesh: moving, tree: &trees[0] }, BodyMesh { mesh: obstacle, tree: &trees[1] }];
        SweepScene::new(&solids[..1], &solids[1..], std::slice::from_ref(candidate), OPTIONS).travel(candidate)
    }

    /// Exact distances between the two along the path, at the start and at `looks` further positions.
    fn distances(
        moving: &Mesh,
        obstacle: &Mesh,
        motion: impl Fn(f64) -> IsometryMatrix3<f64>,
        looks: usize,
    ) -> Vec<f64> {
        let there = Bvh::new(obstacle);
        let at = |look: usize| {
            let motion = motion(look as f64 / looks as f64);
            let here = Bvh::new(&mapped(moving, |p| motion * p));
            let found = PartBvh::new(vec![&here]).distance(&PartBvh::new(vec![&there]), f64::INFINITY);
            found.expect("unbounded").distance
        };
        (0..=looks).map(at).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn travel_ends_where_the_blocks_meet((moving, obstacle) in blocks(), candidate in candidates()) {
            const LOOKS: usize = 60;
            let found = travel(&moving, &obstacle, &candidate);
            for (side, limit) in candidate.limits.into_iter().enumerate() {
                let apart = distances(&moving, &obstacle, |share| candidate.displacement(share * limit), LOOKS);
                prop_assume!(apart[0] > STRAY);
                prop_assert!(found.free[side].abs() <= limit.abs() && found.free[side] * limit >= 0.0);
                match apart.iter().position(|&distance| distance <= STRAY) {
                    None => {
                        prop_assert_eq!(found.free[side], limit);
                        prop_assert_eq!(found.penetration[side], 0.0);
                    }
                    // The travel does not end before the parts are near. Between two positions nothing moves farther
                    // than a tenth.
                    Some(near) => prop_assert!(found.free[side] / limit >= (near as f64 - 1.0) / LOOKS as f64 - 1e-9),
                }
            }
        }

        #[test]
        fn a_block_slides_to_the_end_of_the_gap_plus_the_tolerance(
            gap in 0.05..0.5f64, sides in prop::array::uniform3(0.2..0.5f64), motion in isometry(), exponent in -20i32..20,
        ) {
            let scale = 2f64.powi(exponent);
            let low = [-sides[0], -sides[1], sides[2] + gap];
            let obstacle = block(low, [sides[0], sides[1], sides[2] + gap + 0.5]);
            let place = |mesh: &Mesh| mapped(mesh, |p| (motion * p) * scale);
            let direction = Unit::new_normalize(motion.rotation * Vector3::z());
            let axis = JointAxis { kind: JointKind::Prismatic, direction, pivot: Point3::origin() };
            let candidate = CandidateJoint { axis, pitch: 0.0, limits: [-scale, scale] };
            let moving = block(sides.map(|x| -x), sides);
            let found = travel(&place(&moving), &place(&obstacle), &candidate);
            prop_assert_eq!(found.free[0], -scale);
            let over = found.free[1] / scale - gap;
            // Probes lie inside by a hundredth of the diagonal.
            prop_assert!((-1e-9..=0.011 * place(&moving).diagonal() / scale).contains(&over), "{over}");
            prop_assert!(found.penetration[1] > 0.05);
        }
    }
}
