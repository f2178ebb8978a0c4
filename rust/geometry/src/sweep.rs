//! Free travel of a part along a joint.
//!
//! Parts of real objects touch or overlap a little at rest, so it is not contact that ends a travel but penetration that
//! grows with it. Both bodies are stood for by probes, points slightly inside their surfaces. A probe collides where its
//! path crosses the other body's surface; one that is inside the other body at rest is not used. The moving part's probes
//! move forth against the obstacles, those of the obstacles move back against the part.

use nalgebra::Point3;
use rayon::prelude::*;

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

/// The travels of many candidates of one part among its obstacles.
pub fn sweep(
    moving: &[Solid<'_>],
    obstacles: &[Solid<'_>],
    candidates: &[Candidate],
    options: &SweepOptions,
) -> Vec<Travel> {
    let own = bounds_of(moving);
    let swept = candidates.iter().fold(own, |bounds, candidate| bounds.merged(&swept_bounds(&own, candidate)));
    let scene = Scene {
        forth: Side::new(moving, obstacles, &swept, &own, options),
        back: Side::new(obstacles, moving, &own, &swept, options),
    };
    candidates.par_iter().map(|candidate| scene.travel(candidate, options)).collect()
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
        let mut at = if probe.grace > 0.0 { (probe.grace / stride).ceil().min(last as f64) as usize } else { 0 };
        let mut point = motions[at].apply(&probe.point);
        while at < last {
            let clear = (grid.clearance(&point) / stride).min(last as f64) as usize;
            if clear > 0 {
                at = (at + clear).min(last);
                point = motions[at].apply(&probe.point);
                continue;
            }
            let next = motions[at + 1].apply(&probe.point);
            let met = self.trees.iter().filter_map(|tree| tree.first_crossing(&point, &next)).min_by(f64::total_cmp);
            if let Some(share) = met {
                return Some(at as f64 + share);
            }
            at += 1;
            point = next;
        }
        None
    }
}

/// Both bodies' probes.
struct Scene<'a> {
    forth: Side<'a>,
    back: Side<'a>,
}

impl Scene<'_> {
    fn travel(&self, candidate: &Candidate, options: &SweepOptions) -> Travel {
        let mut result = Travel { free: candidate.limits, penetration: [0.0; 2] };
        for (direction, &limit) in candidate.limits.iter().enumerate() {
            if limit == 0.0 {
                continue;
            }
            let steps = match candidate.axis.kind {
                JointKind::Prismatic => options.steps.min(STRAIGHT_STEPS),
                _ => options.steps,
            };
            let step = limit / steps as f64;
            for (side, sign) in [(&self.forth, 1.0), (&self.back, -1.0)] {
                let motions: Vec<RigidMotion> =
                    (0..=steps).map(|at| candidate.displacement(sign * step * at as f64)).collect();
                let collisions = side.collisions(candidate, limit, &motions);
                let count = side.probes.len().max(1) as f64;
                result.penetration[direction] = result.penetration[direction].max(collisions.len() as f64 / count);
                let ignored = (options.ignored_share * count) as usize;
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
            let moved = candidate.displacement(travel).apply(&corner);
            swept = swept.merged(&Aabb { low: moved, high: moved });
        }
    }
    match candidate.axis.kind {
        JointKind::Prismatic => swept,
        _ => swept.loosened(radius * (1.0 - (0.5 * (upper - lower) / looks as f64).min(std::f64::consts::PI).cos())),
    }
}
