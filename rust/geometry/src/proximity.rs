//! Nearest points of surfaces to given points.

use nalgebra::{Point3, Unit, Vector3};

use crate::bvh::{Bvh, NearestPlace};

/// The place of a surface that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// How far away it is.
    pub distance: f64,
    /// The point of the surface.
    pub point: Point3<f64>,
    /// Unit normal of the triangle it lies on, as its corners are ordered; zero for a triangle without area.
    pub normal: Vector3<f64>,
}

/// The point nearest to `point` on the surfaces of `trees`, of which there must be at least one.
pub fn nearest(trees: &[&Bvh], point: &Point3<f64>) -> Nearest {
    // The part whose box is nearest most often holds the answer: what it gives prunes the others.
    let mut order: Vec<_> = trees.iter().map(|tree| (tree.bounds().squared_distance_to(point), *tree)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<NearestPlace> = None;
    for (squared, tree) in order {
        let bound = best.as_ref().map_or(f64::INFINITY, |found| found.squared);
        if squared > bound {
            break;
        }
        best = tree.nearest(point, bound, 0.0).or(best);
    }
    let NearestPlace { squared, place, triangle: [a, b, c] } = best.expect("a tree has at least one triangle");
    let normal =
        Unit::try_new((b - a).cross(&(c - a)), f64::MIN_POSITIVE).map_or_else(Vector3::zeros, Unit::into_inner);
    Nearest { distance: squared.sqrt(), point: place, normal }
}
