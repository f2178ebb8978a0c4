//! Similarity transforms between sets of points.

use nalgebra::{Matrix2, Matrix3, Point3, Rotation3, Vector3};

use crate::pose::nearest_rotation::nearest_rotation;

/// Smallest singular value or squared extent, as a share of the largest. Smaller values count as zero.
const NEGLIGIBLE: f64 = 1e-12;
/// A source point and its observed target point.
pub type PointPair = (Point3<f64>, Point3<f64>);

/// A similarity transform: `target = scale * rotation * source + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// Rotation.
    pub rotation: Rotation3<f64>,
    /// Scale, above zero.
    pub scale: f64,
    /// Translation.
    pub translation: Vector3<f64>,
}

impl Similarity {
    /// Image of a source point.
    pub fn apply(&self, source: &Point3<f64>) -> Point3<f64> {
        self.rotation * source * self.scale + self.translation
    }

    /// Least-squares fit to point pairs; `None` if they do not determine it (collinear points, or fewer than three).
    ///
    /// Source: Umeyama, Least-squares estimation of transformation parameters between two point patterns, 1991.
    pub fn fit(pairs: &[PointPair]) -> Option<Self> {
        if pairs.len() < 3 {
            return None;
        }
        Moments::of(pairs).fit()
    }

    /// Least-squares fit to weighted point pairs. Weights are at least 0, and not all of them are 0.
    pub(crate) fn fit_weighted<'a>(pairs: impl IntoIterator<Item = (&'a PointPair, f64)>) -> Option<Self> {
        Moments::weighted(pairs).fit()
    }

    /// Least-squares fit to three pairs, in closed form; `None` if a triangle has no area.
    ///
    /// Both triangles are flat, so the best rotation maps one plane to the other. The rest is the polar factor of a 2 x
    /// 2 matrix.
    pub fn of_triangles(source: &[Point3<f64>; 3], target: &[Point3<f64>; 3]) -> Option<Self> {
        let (from, to) = (TriangleFrame::of(source)?, TriangleFrame::of(target)?);
        let products = from.corners.iter().zip(&to.corners).map(|(p, q)| q * p.transpose());
        let mixed: Matrix2<f64> = products.sum();
        let turned = (mixed.m11 + mixed.m22, mixed.m21 - mixed.m12);
        let mirrored = (mixed.m11 - mixed.m22, mixed.m21 + mixed.m12);
        let (as_turned, as_mirrored) = (turned.0.hypot(turned.1), mirrored.0.hypot(mirrored.1));
        let largest = as_turned.max(as_mirrored);
        let [spread, spread_of_target] = [&from, &to].map(TriangleFrame::spread);
        // The product of the two spreads may overflow or underflow, so their square roots are multiplied.
        if largest <= NEGLIGIBLE * (spread.sqrt() * spread_of_target.sqrt()).max(f64::MIN_POSITIVE) {
            return None;
        }
        // A reflection within the plane turns the plane over.
        let ((cosine, sine), side) =
            if as_turned >= as_mirrored { (turned, 1.0) } else { ((mirrored.0, mirrored.1), -1.0) };
        let (cosine, sine) = (cosine / largest, sine / largest);
        let within = Matrix3::new(cosine, -sine * side, 0.0, sine, cosine * side, 0.0, 0.0, 0.0, side);
        let rotation = Rotation3::from_matrix_unchecked(to.axes * within * from.axes.transpose());
        let scale = largest / spread;
        Some(Self { rotation, scale, translation: to.middle - rotation * from.middle * scale })
    }
}

/// True if the residual of a pair is below the threshold.
pub fn is_inlier(similarity: &Similarity, (source, target): &PointPair, threshold: f64) -> bool {
    (similarity.apply(source) - target).norm_squared() < threshold * threshold
}

/// Moments of point pairs, as needed by least-squares fits.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moments {
    /// Sum of the weights; the number of pairs if they are unweighted.
    pub(crate) weight: f64,
    /// Mean of the source points.
    pub(crate) source: Vector3<f64>,
    /// Mean of the target points.
    pub(crate) target: Vector3<f64>,
    /// Sum of `target * source^T` about the means.
    pub(crate) covariance: Matrix3<f64>,
    /// Sum of the squared distances of the source points from their mean.
    spread: f64,
}

impl Moments {
    pub(crate) fn of<'a>(pairs: impl IntoIterator<Item = &'a PointPair>) -> Self {
        Self::weighted(pairs.into_iter().map(|pair| (pair, 1.0)))
    }

    pub(crate) fn weighted<'a>(pairs: impl IntoIterator<Item = (&'a PointPair, f64)>) -> Self {
        let mut pairs = pairs.into_iter().peekable();
        // Sums relative to the first pair lose nothing to rounding: it is about as far from the others as they spread.
        let near = pairs.peek().map_or([Vector3::zeros(); 2], |((source, target), _)| [source.coords, target.coords]);
        let (mut whole, mut sums, mut products, mut squares) = (0.0, [Vector3::zeros(); 2], Matrix3::zeros(), 0.0);
        for (pair, weight) in pairs {
            let [source, target] = [pair.0.coords - near[0], pair.1.coords - near[1]];
            let weighted = source * weight;
            whole += weight;
            sums[0] += weighted;
            sums[1] += target * weight;
            products += target * weighted.transpose();
            squares += source.dot(&weighted);
        }
        let share = if whole > 0.0 { 1.0 / whole } else { 0.0 };
        let [source, target] = sums.map(|sum| sum * share);
        Self {
            weight: whole,
            source: source + near[0],
            target: target + near[1],
            covariance: products - target * source.transpose() * whole,
            spread: (squares - source.norm_squared() * whole).max(0.0),
        }
    }

    /// Least-squares fit; `None` if the pairs do not determine it.
    fn fit(&self) -> Option<Similarity> {
        let (rotation, stretches) = nearest_rotation(self.covariance)?;
        if stretches[1] <= NEGLIGIBLE * stretches[0] || self.spread == 0.0 {
            return None;
        }
        let scale = stretches.sum() / self.spread;
        let translation = self.target - rotation * self.source * scale;
        (scale > 0.0 && scale.is_finite()).then_some(Similarity { rotation, scale, translation })
    }
}

/// A triangle in its own plane.
struct TriangleFrame {
    middle: Vector3<f64>,
    /// Columns: two directions in the plane and its normal, right-handed.
    axes: Matrix3<f64>,
    /// Corners relative to the middle, along the first two axes.
    corners: [nalgebra::Vector2<f64>; 3],
}

impl TriangleFrame {
    fn of(corners: &[Point3<f64>; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let (side, other) = (b - a, c - a);
        let normal = side.cross(&other);
        let area = normal.norm();
        if area <= NEGLIGIBLE.sqrt() * side.norm_squared().max(other.norm_squared()) {
            return None;
        }
        let (first, normal) = (side.normalize(), normal / area);
        let second = normal.cross(&first);
        let middle = (a.coords + b.coords + c.coords) / 3.0;
        let within = |corner: &Point3<f64>| {
            let offset = corner.coords - middle;
            nalgebra::Vector2::new(first.dot(&offset), second.dot(&offset))
        };
        Some(Self {
            middle,
            axes: Matrix3::from_columns(&[first, second, normal]),
            corners: [within(a), within(b), within(c)],
        })
    }

    /// Sum of the squared distances of the corners from their middle.
    fn spread(&self) -> f64 {
        self.corners.iter().map(|corner| corner.norm_squared()).sum()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::pose::nearest_rotation::angle_between;

    fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
    }

    fn similarities() -> impl Strategy<Value = Similarity> {
        (vector(3.0), 0.1..5.0, vector(2.0)).prop_map(|(turn, scale, translation)| Similarity {
            rotation: Rotation3::new(turn),
            scale,
            translation,
        })
    }

    fn points(count: usize) -> impl Strategy<Value = Vec<Point3<f64>>> {
        prop::collection::vec(vector(1.0).prop_map(Point3::from), count)
    }

    fn squares(similarity: &Similarity, pairs: &[PointPair]) -> f64 {
        pairs.iter().map(|(a, b)| (similarity.apply(a) - b).norm_squared()).sum()
    }

    proptest! {
        #[test]
        fn exact_pairs_return_the_similarity(true_one in similarities(), cloud in points(8)) {
            let pairs: Vec<_> = cloud.iter().map(|a| (*a, true_one.apply(a))).collect();
            prop_assume!((cloud[1] - cloud[0]).cross(&(cloud[2] - cloud[0])).norm() > 0.01);
            let found = Similarity::fit(&pairs).expect("determined");
            prop_assert!((found.rotation.matrix() - true_one.rotation.matrix()).norm() < 1e-6);
            prop_assert!((found.scale - true_one.scale).abs() < 1e-9 * true_one.scale);
            prop_assert!((found.translation - true_one.translation).norm() < 1e-7);
        }

        #[test]
        fn a_pair_of_weight_two_counts_as_two(a in points(6), b in points(6)) {
            let pairs: Vec<_> = a.into_iter().zip(b).collect();
            let twice: Vec<_> = pairs.iter().chain(&pairs[..2]).copied().collect();
            let weighted = pairs.iter().enumerate().map(|(row, pair)| (pair, if row < 2 { 2.0 } else { 1.0 }));
            if let (Some(one), Some(other)) = (Similarity::fit(&twice), Similarity::fit_weighted(weighted)) {
                let (first, second) = (squares(&one, &twice), squares(&other, &twice));
                prop_assert!((first - second).abs() < 1e-9 * (1.0 + first), "{first} {second}");
            }
        }

        #[test]
        fn the_closed_form_agrees_with_the_general_fit(a in points(3), b in points(3)) {
            let (a, b) = ([a[0], a[1], a[2]], [b[0], b[1], b[2]]);
            let pairs: Vec<_> = a.into_iter().zip(b).collect();
            if let (Some(closed), Some(found)) = (Similarity::of_triangles(&a, &b), Similarity::fit(&pairs)) {
                prop_assert!((closed.rotation.matrix().determinant() - 1.0).abs() < 1e-9);
                let (ours, theirs) = (squares(&closed, &pairs), squares(&found, &pairs));
                prop_assert!((ours - theirs).abs() < 1e-9 * (1.0 + theirs), "{ours} {theirs}");
            }
        }

        #[test]
        fn no_nearby_similarity_fits_better(a in points(6), b in points(6), near in vector(0.01), by in 0.99..1.01) {
            let pairs: Vec<_> = a.into_iter().zip(b).collect();
            if let Some(found) = Similarity::fit(&pairs) {
                let rotation = Rotation3::new(near) * found.rotation;
                let other = Similarity { rotation, scale: found.scale * by, ..found };
                prop_assert!(squares(&found, &pairs) <= squares(&other, &pairs) + 1e-12);
            }
        }
    }

    #[test]
    fn thin_rods_get_the_right_rotation_about_their_length() {
        let turn = Rotation3::new(Vector3::new(0.4, -0.3, 0.9));
        for thickness in [1e-2, 1e-3, 1e-4, 1e-5] {
            let corners = (0..40).map(|i| {
                let (sine, cosine) = f64::from(i * i).sin_cos();
                Point3::new(f64::from(i) / 40.0, thickness * cosine, thickness * sine)
            });
            let pairs: Vec<_> = corners.map(|corner| (corner, turn * corner)).collect();
            let found = Similarity::fit(&pairs).expect("determined");
            assert!(angle_between(&found.rotation, &turn) < 1e-15 / (thickness * thickness), "{thickness}");
        }
    }

    #[test]
    fn exact_triangles_return_the_similarity_at_any_scale() {
        let source = [[0.0, 0.0, 0.0], [1.0, 0.2, 0.1], [0.3, 0.8, -0.2]].map(Point3::from);
        for scale in [1e-60, 1e-13, 1e-6, 1.0, 1e13, 1e60] {
            let rotation = Rotation3::new(Vector3::new(0.4, -0.3, 0.9));
            let true_one = Similarity { rotation, scale, translation: Vector3::new(1.0, 2.0, 3.0) * scale };
            let found = Similarity::of_triangles(&source, &source.map(|corner| true_one.apply(&corner)));
            let found = found.expect("determined");
            assert!(angle_between(&found.rotation, &rotation) < 1e-9, "{scale}");
            assert!((found.scale / scale - 1.0).abs() < 1e-9, "{scale}");
        }
    }

    #[test]
    fn collinear_points_determine_nothing() {
        let line: Vec<_> = (0..5).map(|i| Point3::new(i as f64, 2.0 * i as f64, 0.0)).map(|p| (p, p)).collect();
        assert_eq!(Similarity::fit(&line), None);
        assert_eq!(Similarity::fit(&line[..2]), None);
        let corners = [line[0].0, line[1].0, line[2].0];
        assert_eq!(Similarity::of_triangles(&corners, &corners), None);
    }
}
