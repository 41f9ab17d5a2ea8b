//! Viterbi's algorithm, forward and backward: the cheapest way through the choices of every sample, and the cheapest through each.

use crate::estimate::association::candidates::Choice;
use crate::estimate::association::transitions::near;

/// All ways through the choices: what each choice costs together with the cheapest way up to it, and with the cheapest way on.
pub(crate) struct Trellis<'a> {
    choices: &'a [Vec<Choice>],
    steps: &'a [Vec<f64>],
    /// Cost up to and with each choice, and the choice before it on the way there.
    until: Vec<Vec<(usize, f64)>>,
    /// Cost after each choice, and the choice behind it.
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
                let ways = until[before].iter().enumerate();
                let (from, cost) = least(&mut ways.map(|(start, (_, cost))| cost + step(start)));
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
                let ways = here.iter().enumerate();
                after[index - 1][start] =
                    least(&mut ways.map(|(end, choice)| step(end) + choice.misfit + after[index][end].1));
            }
        }
        Self { choices, steps, until, after }
    }

    /// The cheapest way, and its cost.
    pub fn best(&self) -> (Vec<usize>, f64) {
        let last = self.until.last().map_or(&[][..], |last| last);
        let end = last.iter().enumerate().min_by(|a, b| a.1.1.total_cmp(&b.1.1));
        end.map_or((Vec::new(), 0.0), |(choice, (_, cost))| (self.through(self.until.len() - 1, choice), *cost))
    }

    /// What the cheapest way costs that puts a sample elsewhere than near `psi`, and the choice that it goes through.
    pub fn elsewhere(&self, index: usize, psi: f64) -> (f64, usize) {
        let others = self.choices[index].iter().enumerate().filter(|(_, choice)| !near(choice.psi, psi));
        others
            .map(|(choice, _)| (self.until[index][choice].1 + self.after[index][choice].1, choice))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((f64::INFINITY, 0))
    }

    /// The cheapest way through a choice.
    pub fn through(&self, index: usize, choice: usize) -> Vec<usize> {
        let mut way = vec![choice; self.choices.len()];
        for before in (0..index).rev() {
            way[before] = self.until[before + 1][way[before + 1]].0;
        }
        for behind in index + 1..way.len() {
            way[behind] = self.after[behind - 1][way[behind - 1]].0;
        }
        way
    }

    /// What the steps of a way cost together.
    pub fn steps_along(&self, way: &[usize]) -> f64 {
        let steps = self.steps.iter().zip(self.choices.iter().skip(1)).zip(way.windows(2));
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
    fn the_cheapest_way_leaps_never_where_each_sample_alone_would_leap_often() {
        let (mut choices, steps) = undecided();
        choices[0][1].misfit += 2.0;
        let lattice = Trellis::new(&choices, &steps);
        let (way, cost) = lattice.best();
        assert_eq!(way, [0; 8]);
        assert!((cost - 16.0).abs() < 1e-12);
        // The other pose all the way costs two more.
        for index in 0..8 {
            let (other, choice) = lattice.elsewhere(index, 0.0);
            assert!((other - cost - 2.0).abs() < 1e-12, "{other}");
            assert_eq!(lattice.through(index, choice), [1; 8]);
        }
        assert_eq!(lattice.steps_along(&[0, 1, 1, 0, 0, 0, 0, 0]), 2.0 * UNPREDICTED_JUMP.deviance());
    }

    #[test]
    fn a_leap_is_taken_where_it_pays_and_its_neighbours_are_uncertain() {
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
        let lattice = Trellis::new(&choices, &steps);
        let (way, cost) = lattice.best();
        let orientations: Vec<f64> = way.iter().zip(&choices).map(|(&c, choices)| choices[c].psi).collect();
        assert_eq!(orientations[4..], [1.0; 4]);
        assert_eq!(orientations.windows(2).filter(|pair| pair[0] != pair[1]).count(), 1);
        let margin: Vec<f64> =
            orientations.iter().enumerate().map(|(index, psi)| lattice.elsewhere(index, *psi).0 - cost).collect();
        assert!(margin[0].is_infinite() && margin[7].is_infinite());
        assert!(margin[3] < 4.0 && margin[5] > 40.0, "{margin:?}");
    }
}
