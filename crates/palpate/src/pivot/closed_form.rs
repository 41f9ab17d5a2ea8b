//! Contact angles of one segment by quadrature, without statics, friction or an unknown constant: from r' = −d follows
//!
//! dθ = −dr/d,
//!
//! with r the height of the pivot over the pad and d the offset of the contact. Where d = 0 both vanish. There r = r₀ − d²/(2κ) + …
//! with κ = d' = r − v at the crossing, so that the readings around it, which need not be in the order of time, give κ, and
//! dθ = dd/κ + …. Whether θ goes on or turns back needs no guess: d changes its sign where θ goes on, and returns with the same sign
//! where it turns.

use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// Samples on either side that smooth an offset.
const HALF_WIDTH: usize = 3;

/// The crossing of d = 0 reaches as far as this many standard deviations of an offset …
const CROSSING_SDS: f64 = 8.0;

/// … and at least as far as this share of the object's size: what is further is a quadrature with an error of a few per cent.
const LEAST_CROSSING: f64 = 0.03;

/// The parabola is taken from readings as far as so many times that.
const PARABOLA_REACH: f64 = 2.5;

/// Where the arm moves along the pad by at least this share of what the parabola says the object turned by, times its height, the object may
/// roll: crossings that run into each other are no parabola.
const ROLLING_SHARE: f64 = 0.5;

/// There the turn is that of rolling, dθ = du/r with u the foot of the pivot, times a factor that readings up to so many samples away tell …
const ROLLING_REACH: usize = 8;

/// … and that is 1 with this standard deviation where they tell nothing.
const ROLLING_SD: f64 = 0.5;

/// What was measured in one segment, metres.
pub(super) struct Stretch<'a> {
    /// Height of the pivot over the pad.
    pub r_m: &'a [f64],
    /// Offset of the contact from the foot of the pivot.
    pub d_m: &'a [f64],
    /// The foot of the pivot along the pad.
    pub along_m: &'a [f64],
    /// Noise of height and offset.
    pub sd_m: [f64; 2],
    /// Rough size of the object.
    pub size_m: f64,
}

impl Stretch<'_> {
    /// Contact angles relative to the first sample, radians. Crossings are taken `width` times as wide as stated above, and may be rolled
    /// through.
    pub fn angles(&self, width: f64, may_roll: bool) -> Vec<f64> {
        let count = self.r_m.len();
        let smooth = smoothed(self.d_m);
        let near_m = width * (CROSSING_SDS * self.sd_m[1]).max(LEAST_CROSSING * self.size_m);
        let mut theta = vec![0.0; count];
        let is_near = |index: usize| smooth[index].abs() < near_m;
        let mut index = 1;
        while index < count {
            if !(is_near(index) || is_near(index - 1)) {
                let middle = 0.5 * (smooth[index] + smooth[index - 1]);
                theta[index] = theta[index - 1] - (self.r_m[index] - self.r_m[index - 1]) / middle;
                index += 1;
                continue;
            }
            // One crossing, from where d becomes small to where it is no longer.
            let start = index - 1;
            let mut end = index;
            while end + 1 < count && (is_near(end) || is_near(end + 1)) {
                end += 1;
            }
            let reach_m = PARABOLA_REACH * near_m;
            let parabola = Parabola::new(self.r_m, &smooth, start, end, reach_m, self.size_m);
            let turned: f64 = (start + 1..=end)
                .map(|sample| (parabola.turn(smooth[sample]) - parabola.turn(smooth[sample - 1])).abs())
                .sum();
            let rolled: f64 = (start + 1..=end).map(|sample| self.rolling(sample).abs()).sum();
            if !may_roll || rolled < ROLLING_SHARE * turned {
                for sample in start + 1..=end {
                    theta[sample] = theta[start] + parabola.turn(smooth[sample]) - parabola.turn(smooth[start]);
                }
            } else {
                for sample in start + 1..=end {
                    theta[sample] = theta[sample - 1] + self.rolled(&smooth, sample);
                }
            }
            index = end + 1;
        }
        theta
    }

    /// The turn up to a sample if the object rolls.
    fn rolling(&self, sample: usize) -> f64 {
        let height_m = self.r_m[sample].abs().max(1e-3 * self.size_m);
        (self.along_m[sample] - self.along_m[sample - 1]) / height_m
    }

    /// The same by as much of it as the readings around it agree with.
    fn rolled(&self, d_m: &[f64], sample: usize) -> f64 {
        let from = sample.saturating_sub(ROLLING_REACH);
        let to = (sample + ROLLING_REACH).min(d_m.len() - 1);
        // r by rolling, up to a constant, against r as measured: the factor by least squares.
        let mut predicted = vec![0.0];
        for index in from + 1..=to {
            let fall = -0.5 * (d_m[index] + d_m[index - 1]) * self.rolling(index);
            predicted.push(predicted[index - from - 1] + fall);
        }
        let count = predicted.len() as f64;
        let (mean, measured) = (predicted.iter().sum::<f64>() / count, self.r_m[from..=to].iter().sum::<f64>() / count);
        let (mut square, mut product) = (0.0, 0.0);
        for (predicted, r) in predicted.iter().zip(&self.r_m[from..=to]) {
            square += (predicted - mean).powi(2);
            product += (predicted - mean) * (r - measured);
        }
        let variance = self.sd_m[0].powi(2).max(1e-12 * self.size_m.powi(2));
        let held = variance / (ROLLING_SD * ROLLING_SD);
        self.rolling(sample) * (product + held) / (square + held)
    }
}

/// r near a crossing of d = 0 as a function of d.
struct Parabola {
    twice: f64,
    thrice: f64,
    fourth: f64,
}

impl Parabola {
    /// The turn of the object as a function of d, up to a constant.
    fn turn(&self, d: f64) -> f64 {
        -d * (self.twice + d * (self.thrice / 2.0 + d * self.fourth / 3.0))
    }

    /// From the readings between two samples and those on either side with |d| within reach.
    fn new(r_m: &[f64], d_m: &[f64], start: usize, end: usize, reach_m: f64, size_m: f64) -> Self {
        // Readings on either side that are within reach belong to the same parabola.
        let mut from = start;
        while from > 0 && d_m[from - 1].abs() < reach_m {
            from -= 1;
        }
        let mut to = end;
        while to + 1 < r_m.len() && d_m[to + 1].abs() < reach_m {
            to += 1;
        }
        let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
        for sample in from..=to {
            let x = d_m[sample] / reach_m;
            let row = Vector4::new(1.0, x * x, x * x * x, x * x * x * x);
            normal += row * row.transpose();
            right += row * (r_m[sample] - r_m[start]);
        }
        // Held a little, so that a side without readings bends nothing: r = … − d²/(2κ) with |κ| about the object's size.
        let count = (to - from + 1) as f64;
        normal[(2, 2)] += 1e-3 * count;
        normal[(3, 3)] += 1e-3 * count;
        normal[(1, 1)] += 1e-9 * count;
        let fit = normal.cholesky().map_or_else(Vector4::zeros, |factor| factor.solve(&right));
        // −1/κ = 2 β; no steeper than an object can be whose curvature hardly differs from its height.
        let steepest = 50.0 / size_m;
        let twice = (2.0 * fit[1] / (reach_m * reach_m)).clamp(-steepest, steepest);
        let thrice = 3.0 * fit[2] / (reach_m * reach_m * reach_m);
        // At the ends the bend may take half of the slope, no more.
        let most = 0.5 * twice.abs() / reach_m;
        let thrice = thrice.clamp(-most, most);
        let fourth = (4.0 * fit[3] / reach_m.powi(4)).clamp(-most / reach_m, most / reach_m);
        Self { twice, thrice, fourth }
    }
}

/// Local parabolas through each value and [`HALF_WIDTH`] on either side.
fn smoothed(values: &[f64]) -> Vec<f64> {
    let count = values.len();
    if count < 2 * HALF_WIDTH + 1 {
        return values.to_vec();
    }
    let at = |index: usize| {
        let from = index.saturating_sub(HALF_WIDTH).min(count - 2 * HALF_WIDTH - 1);
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (sample, value) in values.iter().enumerate().skip(from).take(2 * HALF_WIDTH + 1) {
            let x = (sample as f64 - index as f64) / HALF_WIDTH as f64;
            let row = Vector3::new(1.0, x, x * x);
            normal += row * row.transpose();
            right += row * *value;
        }
        normal.cholesky().map_or(values[index], |factor| factor.solve(&right)[0])
    };
    (0..count).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::SupportFunction;

    fn pebble() -> SupportFunction {
        SupportFunction::new(0.03, vec![[0.003, 0.002], [0.002, -0.001], [0.0004, 0.0006]])
    }

    /// Of an object that rolls.
    fn angles(r_m: &[f64], d_m: &[f64], theta: &[f64], d_sd_m: f64) -> Vec<f64> {
        let mut along_m = vec![0.0];
        for index in 1..theta.len() {
            along_m.push(along_m[index - 1] + r_m[index] * (theta[index] - theta[index - 1]));
        }
        Stretch { r_m, d_m, along_m: &along_m, sd_m: [0.2 * d_sd_m, d_sd_m], size_m: 0.03 }.angles(1.0, true)
    }

    fn measured(shape: &SupportFunction, theta: &[f64]) -> (Vec<f64>, Vec<f64>) {
        theta.iter().map(|theta| shape.at(*theta)).map(|contact| (contact.r, contact.d)).unzip()
    }

    #[test]
    fn a_turn_is_found_through_crossings_of_the_foot() {
        let shape = pebble();
        let theta: Vec<f64> = (0..400).map(|i| 0.3 + 0.015 * f64::from(i)).collect();
        let (r, d) = measured(&shape, &theta);
        assert!(d.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count() >= 2, "it passes over the contact");
        let found = angles(&r, &d, &theta, 0.0);
        for (found, theta) in found.iter().zip(&theta) {
            assert!((found - (theta - 0.3)).abs() < 0.03, "{found} {theta}");
        }
    }

    #[test]
    fn the_quadrature_is_exact_to_second_order_away_from_crossings() {
        let shape = pebble();
        let error = |steps: usize| {
            let theta: Vec<f64> = (0..=steps).map(|i| 0.4 + 0.5 * i as f64 / steps as f64).collect();
            let (r, d) = measured(&shape, &theta);
            assert!(d.iter().all(|d| d.abs() > LEAST_CROSSING * 0.03), "{d:?}");
            (angles(&r, &d, &theta, 0.0)[steps] - 0.5).abs()
        };
        let (coarse, fine) = (error(20), error(40));
        assert!(fine < 1e-4 && coarse / fine > 3.5 && coarse / fine < 4.5, "{coarse} {fine}");
    }

    #[test]
    fn a_crossing_without_rolling_is_found_from_the_parabola() {
        // The arm stands still along the pad: the object slides through d = 0.
        let shape = SupportFunction::new(0.03, vec![[0.003, 0.0], [0.001, 0.0]]);
        let theta: Vec<f64> = (0..100).map(|i| -0.5 + 0.01 * f64::from(i)).collect();
        let (r, d) = measured(&shape, &theta);
        let found = Stretch { r_m: &r, d_m: &d, along_m: &[0.0; 100], sd_m: [0.0; 2], size_m: 0.03 }.angles(1.0, true);
        assert!(found.iter().zip(&theta).all(|(found, theta)| (found - theta - 0.5).abs() < 5e-3), "{found:?}");
    }

    #[test]
    fn at_a_crossing_it_goes_on_or_turns_back_as_the_object_does() {
        let shape = pebble();
        // A crossing of d = 0, found by bisection.
        let (mut low, mut high) = (0.3, 1.7);
        assert!(shape.at(low).d * shape.at(high).d < 0.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if shape.at(middle).d * shape.at(low).d > 0.0 { low = middle } else { high = middle }
        }
        let zero = low;
        let on: Vec<f64> = (0..80).map(|i| zero - 0.4 + 0.01 * f64::from(i)).collect();
        let back: Vec<f64> = (0..80).map(|i| zero - 0.01 * f64::from(i32::abs(i - 40))).collect();
        for path in [on, back] {
            let (r, d) = measured(&shape, &path);
            let found = angles(&r, &d, &path, 1e-4);
            let (turned, true_turn) = (found[79], path[79] - path[0]);
            assert!((turned - true_turn).abs() < 0.03, "{turned} for {true_turn}");
        }
    }
}
