//! Bounding box that follows the symmetries of a part.

use crate::fit::minimum_volume_box::BoxFitter;
use crate::fit::oriented_box::OrientedBox;
use crate::fit::symmetry_test::{SymmetryTest, TestOptions};
use crate::mesh::part_surface::PartSurface;

/// Largest number of boxes on facets of the hull that are tried.
const CANDIDATES: usize = 48;

/// Sine of the largest angle between the axes of boxes that count as one candidate.
const SAME_AXIS: f64 = 0.005;

/// Symmetric box of Fish et al. 2014, and its number of symmetric planes.
///
/// The box has the least volume among the candidates with the most symmetric middle planes (at most three). Candidates
/// are the box of minimum volume and the best boxes along the normals of the hull's facets.
///
/// A plane is symmetric if its error is below the tolerance. The error is the 90th percentile of the squared distances
/// of mirrored samples to the surface, over the squared diagonal. The tolerance thus applies to a square, unlike that
/// of [`crate::fit::symmetry_detection::find_symmetries`].
pub fn symmetric_box(surface: &PartSurface<'_>, options: &TestOptions) -> (OrientedBox, u8) {
    let fitter = BoxFitter::new(surface.mesh().vertices());
    let test = SymmetryTest::new(surface, &TestOptions { tolerance: options.tolerance.sqrt(), ..*options });
    most_symmetric_box(&fitter, fitter.minimum_volume(), &test)
}

pub(crate) fn most_symmetric_box(
    fitter: &BoxFitter,
    minimal: OrientedBox,
    test: &SymmetryTest<'_>,
) -> (OrientedBox, u8) {
    if minimal.half_extents.x == 0.0 {
        return (minimal, 3);
    }
    let mut best = (minimal, symmetric_planes(test, &minimal));
    if best.1 == 3 {
        return best;
    }
    let mut tried = vec![minimal];
    for candidate in fitter.facet_boxes(CANDIDATES) {
        if tried.iter().any(|known| have_same_axes(known, &candidate)) {
            continue;
        }
        let planes = symmetric_planes(test, &candidate);
        if planes > best.1 {
            best = (candidate, planes);
        }
        if planes == 3 {
            break;
        }
        tried.push(candidate);
    }
    best
}

fn symmetric_planes(test: &SymmetryTest<'_>, candidate: &OrientedBox) -> u8 {
    candidate.axes.iter().filter(|normal| test.has_mirror(candidate.center, **normal)).count() as u8
}

fn have_same_axes(a: &OrientedBox, b: &OrientedBox) -> bool {
    a.axes.iter().all(|x| b.axes.iter().any(|y| x.cross(y).norm() < SAME_AXIS))
}
