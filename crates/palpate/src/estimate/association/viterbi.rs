//! Viterbi decoding of a switching model, forward and backward (min-sum): the cheapest path through the trellis of poses, and for
//! every pose of every sample the cheapest path through it (its min-marginal).

use crate::estimate::association::candidates::Choice;
use crate::estimate::association::transitions::near;

/// The choices of all samples, each with the cost of the cheapest path up to it and of the cheapest path after it.
pub(crate) struct Trellis<'a> {
    choices: &'a [Vec<Choice>],
    steps: &'a [Vec<f64>],
    /// For each choice, its predecessor on the cheapest path to it, and the cost up to and including it.
    until: Vec<Vec<(usize, f64)>>,
    /// For each choice, its successor on the cheapest path after it, and the cost after it.
    after: Vec<Vec<(usize, f64)>>,
}

impl<'a> Trellis<'a> {
    pub fn new(choices: &'a [Vec<Choice>], steps: &'a [Vec<f64>]) -> Self {
        let least = |costs: &mut dyn Iterator<Item = f64>| {
            costs.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
        };
        let mut until: Vec<Vec<(usize, f64)>> = Vec::with_capacity(choices.len());
        for (index, here) in choices.iter().enumerate() {
            let reached = here.iter().enumerate().map(|(end, choice)| {
                let Some(before) = index.checked_sub(1) else { return (0, choice.misfit) };
                let step = |start: usize| steps[before][start * here.len() + end];
                let paths = until[before].iter().enumerate();
                let (from, cost) = least(&mut paths.map(|(start, (_, cost))| cost + step(start)));
                (from, cost + choice.misfit)
            });
            let reached = reached.collect();
            until.push(reached);
        }
        let mut after: Vec<Vec<(usize, f64)>> = choices.iter().map(|here| vec![(0, 0.0); here.len()]).collect();
        for index in (1..choices.len()).rev() {
            let here = &choices[index];
            for start in 0..choices[index - 1].len() {
                let step = |end: usize| steps[index - 1][start * here.len() + end];
                let paths = here.iter().enumerate();
                after[index - 1][start] =
                    least(&mut paths.map(|(end, choice)| step(end) + choice.misfit + after[index][end].1));
            }
        }
        Self { choices, steps, until, after }
    }

    /// The cheapest path, and its cost.
    pub fn best(&self) -> (Vec<usize>, f64) {
        let last = self.until.last().map_or(&[][..], |last| last);
        let end = last.iter().enumerate().min_by(|a, b| a.1.1.total_cmp(&b.1.1));
        end.map_or((Vec::new(), 0.0), |(choice, (_, cost))| (self.through(self.until.len() - 1, choice), *cost))
    }

    /// Cost of the cheapest path on which a sample is not near `psi` (up to multiples of `period`), and the choice of that sample on it.
    pub fn elsewhere(&self, index: usize, psi: f64, period: f64) -> (f64, usize) {
        let others = self.choices[index].iter().enumerate().filter(|(_, choice)| !near(choice.psi, psi, period));
        others
            .map(|(choice, _)| (self.until[index][choice].1 + self.after[index][choice].1, choice))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((f64::INFINITY, 0))
    }

    /// The cheapest path through a choice.
    pub fn through(&self, index: usize, choice: usize) -> Vec<usize> {
        let mut path = vec![choice; self.choices.len()];
        for before in (0..index).rev() {
            path[before] = self.until[before + 1][path[before + 1]].0;
        }
        for behind in index + 1..path.len() {
            path[behind] = self.after[behind - 1][path[behind - 1]].0;
        }
        path
    }

    /// Sum of the transition costs along a path.
    pub fn steps_along(&self, path: &[usize]) -> f64 {
        let steps = self.steps.iter().zip(self.choices.iter().skip(1)).zip(path.windows(2));
        steps.map(|((steps, to), step)| steps[step[0] * to.len() + step[1]]).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::evidence::motion_prior::UNPREDICTED_JUMP;

    /// Two poses explain each sample about equally well; the noise prefers now one, now the other.
    fn undecided() -> (Vec<Vec<Choice>>, Vec<Vec<f64>>) {
        let choices: Vec<Vec<Choice>> = (0..8)
            .map(|i| {
                let (one, two) = if i % 2 == 0 { (3.0, 1.0) } else { (1.0, 3.0) };
                vec![Choice { psi: 0.0, misfit: one }, Choice { psi: 1.0, misfit: two }]
            })
            .collect();
        (choices, vec![vec![0.0, UNPREDICTED_JUMP.deviance(), UNPREDICTED_JUMP.deviance(), 0.0]; 7])
    }

    #[test]
    fn the_cheapest_path_never_jumps_where_samples_decided_alone_would_jump_often() {
        let (mut choices, steps) = undecided();
        choices[0][1].misfit += 2.0;
        let trellis = Trellis::new(&choices, &steps);
        let (path, cost) = trellis.best();
        assert_eq!(path, [0; 8]);
        assert!((cost - 16.0).abs() < 1e-12);
        // The other pose at all samples costs two more.
        for index in 0..8 {
            let (other, choice) = trellis.elsewhere(index, 0.0, std::f64::consts::TAU);
            assert!((other - cost - 2.0).abs() < 1e-12, "{other}");
            assert_eq!(trellis.through(index, choice), [1; 8]);
        }
        assert_eq!(trellis.steps_along(&[0, 1, 1, 0, 0, 0, 0, 0]), 2.0 * UNPREDICTED_JUMP.deviance());
    }

    #[test]
    fn a_jump_is_taken_where_it_lowers_the_cost_and_samples_beside_it_are_ambiguous() {
        let (mut choices, steps) = undecided();
        choices[0].truncate(1);
        choices[7].remove(0);
        let steps: Vec<Vec<f64>> = steps
            .into_iter()
            .enumerate()
            .map(|(i, step)| match i {
                0 => step[..2].to_vec(),
                6 => vec![step[1], step[3]],
                _ => step,
            })
            .collect();
        // From sample 4 on the second pose explains all.
        choices[4..7].iter_mut().for_each(|choices| choices[0].misfit += 50.0);
        let trellis = Trellis::new(&choices, &steps);
        let (path, cost) = trellis.best();
        let orientations: Vec<f64> = path.iter().zip(&choices).map(|(&c, choices)| choices[c].psi).collect();
        assert_eq!(orientations[4..], [1.0; 4]);
        assert_eq!(orientations.windows(2).filter(|pair| pair[0] != pair[1]).count(), 1);
        let margin: Vec<f64> = orientations
            .iter()
            .enumerate()
            .map(|(index, psi)| trellis.elsewhere(index, *psi, std::f64::consts::TAU).0 - cost)
            .collect();
        assert!(margin[0].is_infinite() && margin[7].is_infinite());
        assert!(margin[3] < 4.0 && margin[5] > 40.0, "{margin:?}");
    }
}
