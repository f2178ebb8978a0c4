//! Quasi-random sequence that fills a cube evenly for any number of points.

/// Point number `index` in [0, 1)³ of the additive recurrence with the generalised golden ratio (the R3 sequence).
pub fn quasi_random(index: usize, start: f64) -> [f64; 3] {
    const RATIO: f64 = 1.220_744_084_605_759_5;
    [1, 2, 3].map(|power| (start + (index + 1) as f64 / RATIO.powi(power)).fract())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_octants_have_the_same_number_of_points() {
        let mut counts = [0; 8];
        for index in 0..8_000 {
            let place = quasi_random(index, 0.5);
            assert!(place.iter().all(|x| (0.0..1.0).contains(x)));
            counts[place.iter().fold(0, |octant, &x| 2 * octant + usize::from(x >= 0.5))] += 1;
        }
        assert!(counts.iter().all(|&count| (950..=1_050).contains(&count)), "{counts:?}");
    }
}
