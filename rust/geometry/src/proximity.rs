//! Nearest points of several surfaces to given points.

use nalgebra::Point3;

use crate::parry::{Nearest, Surface};

/// The place nearest to `point` on any of `surfaces`; `None` without surfaces.
pub fn nearest(surfaces: &[&Surface], point: &Point3<f64>) -> Option<Nearest> {
    // The surface whose box is nearest most often holds the answer: what it gives prunes the others.
    let mut order: Vec<_> = surfaces.iter().map(|surface| (surface.distance_to_bounds(point), *surface)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<Nearest> = None;
    for (at_least, surface) in order {
        let reach = best.map_or(f64::MAX, |found| found.distance);
        if at_least > reach {
            break;
        }
        best = surface.nearest_within(point, reach).or(best);
    }
    best
}
