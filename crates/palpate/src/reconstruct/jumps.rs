//! Where the object jumped to another pose, seen in its motion.

use super::noise::median;

/// A turn by less than this between two samples is never called a jump, radians.
const SMALLEST_JUMP: f64 = 0.1;

/// A jump turns the object at least this many times further than the samples around it.
const CONTRAST: f64 = 6.0;

/// Brings angles of neighbouring samples within half a turn of each other.
pub(super) fn unwrap(psi: &mut [f64]) {
    for index in 1..psi.len() {
        let turns = ((psi[index] - psi[index - 1]) / std::f64::consts::TAU).round();
        psi[index] -= turns * std::f64::consts::TAU;
    }
}

/// Indices of the first sample after each jump.
pub(super) fn jumps(psi: &[f64]) -> Vec<usize> {
    let steps: Vec<f64> = psi.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    (0..steps.len())
        .filter(|&index| {
            let around = index.saturating_sub(8)..(index + 9).min(steps.len());
            let mut others: Vec<f64> = around.filter(|&other| other != index).map(|other| steps[other]).collect();
            steps[index] > SMALLEST_JUMP && steps[index] > CONTRAST * median(&mut others)
        })
        .map(|index| index + 1)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leap_is_a_jump_and_a_steady_turn_is_not() {
        let mut psi: Vec<f64> = (0..100).map(|i| 0.05 * i as f64).collect();
        assert!(jumps(&psi).is_empty());
        psi[40..].iter_mut().for_each(|psi| *psi += 0.8);
        assert_eq!(jumps(&psi), [40]);
    }

    #[test]
    fn unwrapping_leaves_no_step_over_half_a_turn() {
        let mut psi = vec![3.0, -3.0, 3.1, 9.5];
        unwrap(&mut psi);
        assert!(psi.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= std::f64::consts::PI));
    }
}
