//! Free travel of a part along a joint.
//!
//! Parts of real objects touch or overlap a little at rest, so it is not contact that ends a travel but penetration that
//! grows with it. Both bodies are stood for by probes, points slightly inside their surfaces. A probe collides where its
//! path crosses the other body's surface; one that is inside the other body at rest is not used. The moving part's probes
//! move forth against the obstacles, those of the obstacles move back against the part.

use nalgebra::Point3;

use crate::aabb::Aabb;
use crate::bvh::Bvh;
use crate::clearance::ClearanceGrid;
use crate::motion::{JointAxis, JointKind, RigidMotion};
use crate::probes::{Probe, Solid, probes_of};

/// A joint to try, and how far. Revolute and screw joints travel in radians, prismatic ones in lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The joint.
    pub axis: JointAxis,
    /// Length per radian of a screw.
    pub pitch: f64,
    /// Travels to try: downwards (at most 0) and upwards (at least 0).
    pub limits: [f64; 2],
}

impl Candidate {
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

/// Steps of a straight motion: what they are cut into changes the time, not the result.
const STRAIGHT_STEPS: usize = 5;

/// How finely to look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweepOptions {
    /// Probes of either body.
    pub probes: usize,
    /// Steps a direction; rotations are taken straight in between.
    pub steps: usize,
    /// Overlap at rest that is no collision, over the diagonal of the moving part.
    pub tolerance: f64,
    /// Travel ends once more than this share of the probes of either body has collided.
    pub ignored_share: f64,
}

/// What a candidate's travel met, downwards and upwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// The travel at which it ends; the limit tried if nothing is in the way.
    pub free: [f64; 2],
    /// Share of the probes, of the body that has the larger one, that collide on the whole way.
    pub penetration: [f64; 2],
}

/// Probes of one body against the surface of the other.
struct Side<'a> {
    probes: Vec<Probe>,
    trees: Vec<&'a Bvh>,
    grid: Option<ClearanceGrid>,
}

impl<'a> Side<'a> {
    fn new(body: &[Solid<'_>], other: &[Solid<'a>], reached: &Aabb, region: &Aabb, options: &SweepOptions) -> Self {
        let tolerance = options.tolerance * reached.squared_diagonal().min(region.squared_diagonal()).sqrt();
        let trees: Vec<&Bvh> = other.iter().map(|solid| solid.tree).collect();
        let bounds = bounds_of(other).common(reached);
        Self {
            probes: probes_of(body, other, region, options.probes, tolerance),
            trees,
            grid: bounds.map(|bounds| ClearanceGrid::new(&other.iter().map(|s| s.tree).collect::<Vec<_>>(), &bounds)),
        }
    }

    /// Steps, fractions included, at which the probes first collide, in ascending order.
    fn collisions(&self, candidate: &Candidate, travel: f64, motions: &[RigidMotion]) -> Vec<f64> {
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
        // Of the step that begins there, the share that the grace takes.
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

/// A part among its obstacles: the probes of both bodies, which any of some candidates can bring together.
pub struct Scene<'a> {
    forth: Side<'a>,
    back: Side<'a>,
    options: SweepOptions,
}

impl<'a> Scene<'a> {
    /// Looks at what `candidates` can reach.
    pub fn new(moving: &[Solid<'a>], obstacles: &[Solid<'a>], candidates: &[Candidate], options: SweepOptions) -> Self {
        let own = bounds_of(moving);
        let swept = candidates.iter().fold(own, |bounds, candidate| bounds.merged(&swept_bounds(&own, candidate)));
        Self {
            forth: Side::new(moving, obstacles, &swept, &own, &options),
            back: Side::new(obstacles, moving, &own, &swept, &options),
            options,
        }
    }

    /// The travel of one of the candidates.
    pub fn travel(&self, candidate: &Candidate) -> Travel {
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
            for (side, sign) in [(&self.forth, 1.0), (&self.back, -1.0)] {
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

fn bounds_of(body: &[Solid<'_>]) -> Aabb {
    body.iter().fold(Aabb::empty(), |bounds, solid| bounds.merged(solid.tree.bounds()))
}

/// A box around all that a box meets on its way.
fn swept_bounds(bounds: &Aabb, candidate: &Candidate) -> Aabb {
    /// Radians between two looks; in between, a corner strays at most by its radius times the versine of half of it.
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
        _ => swept.loosened(radius * (1.0 - (0.5 * (upper - lower) / looks as f64).min(std::f64::consts::PI).cos())),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{IsometryMatrix3, Unit, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::Mesh;
    use crate::adjacency::Part;
    use crate::soup::{block, isometry, mapped};

    const OPTIONS: SweepOptions = SweepOptions { probes: 300, steps: 16, tolerance: 0.01, ignored_share: 0.005 };
    /// Rotations are straight between steps: how far a path of at most three lengths radius strays from its arc.
    const STRAY: f64 = 0.02;

    fn candidates() -> impl Strategy<Value = Candidate> {
        let kinds = prop::sample::select(vec![JointKind::Revolute, JointKind::Prismatic, JointKind::Screw]);
        let vector = || prop::array::uniform3(-1.0..1.0f64);
        (kinds, vector(), vector(), 0.2..1.5f64, -0.3..0.3f64).prop_filter_map(
            "a direction",
            |(kind, direction, pivot, limit, pitch)| {
                let direction = Unit::try_new(Vector3::from(direction), 0.1)?;
                Some(Candidate {
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

    fn travel(moving: &Mesh, obstacle: &Mesh, candidate: &Candidate) -> Travel {
        let trees = [Bvh::new(moving), Bvh::new(obstacle)];
        let solids = [Solid { mesh: moving, tree: &trees[0] }, Solid { mesh: obstacle, tree: &trees[1] }];
        Scene::new(&solids[..1], &solids[1..], std::slice::from_ref(candidate), OPTIONS).travel(candidate)
    }

    /// Exact distances of the two on the way, `looks` of them after the first.
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
            let found = Part::new(vec![&here]).distance(&Part::new(vec![&there]), f64::INFINITY);
            found.expect("unbounded").distance
        };
        (0..=looks).map(at).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn travel_ends_where_the_blocks_meet_and_nowhere_else((moving, obstacle) in blocks(), candidate in candidates()) {
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
                    // Not before they are near; between two looks nothing moves farther than a tenth.
                    Some(near) => prop_assert!(found.free[side] / limit >= (near as f64 - 1.0) / LOOKS as f64 - 1e-9),
                }
            }
        }

        #[test]
        fn a_block_slides_as_far_as_the_gap_and_a_little(
            gap in 0.05..0.5f64, sides in prop::array::uniform3(0.2..0.5f64), motion in isometry(), exponent in -20i32..20,
        ) {
            let scale = 2f64.powi(exponent);
            let low = [-sides[0], -sides[1], sides[2] + gap];
            let obstacle = block(low, [sides[0], sides[1], sides[2] + gap + 0.5]);
            let place = |mesh: &Mesh| mapped(mesh, |p| (motion * p) * scale);
            let direction = Unit::new_normalize(motion.rotation * Vector3::z());
            let axis = JointAxis { kind: JointKind::Prismatic, direction, pivot: Point3::origin() };
            let candidate = Candidate { axis, pitch: 0.0, limits: [-scale, scale] };
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
