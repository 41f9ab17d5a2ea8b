//! palpate and a peer by turns.

use std::time::Instant;

use crate::studies::python_cost::median;

/// How often each works.
#[derive(Clone, Copy, Debug)]
pub struct Turns {
    /// Times that are counted, at the most.
    pub most: usize,
    /// No further turn begins after this long, seconds.
    pub budget_s: f64,
}

/// Median times, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medians {
    /// Of palpate.
    pub palpate_s: f64,
    /// Of the peer.
    pub peer_s: f64,
}

impl Turns {
    /// Lets both work by turns; each gives the seconds that count. The first call of each warms up, and counts only where it took so
    /// long that there is no time for another.
    pub fn take(
        self,
        mut palpate: impl FnMut() -> anyhow::Result<f64>,
        mut peer: impl FnMut() -> anyhow::Result<f64>,
    ) -> anyhow::Result<Medians> {
        let began = Instant::now();
        let (first_palpate_s, first_peer_s) = (palpate()?, peer()?);
        let (mut palpate_s, mut peer_s) = (Vec::new(), Vec::new());
        for turn in 0..self.most {
            let spent = began.elapsed().as_secs_f64() > self.budget_s;
            if spent && turn > 0 {
                break;
            }
            let again = |first_s: f64| !spent || first_s < self.budget_s;
            // Neither is always the first.
            for palpate_is_next in [turn % 2 == 0, turn % 2 == 1] {
                if palpate_is_next && again(first_palpate_s) {
                    palpate_s.push(turn_of(&mut palpate)?);
                } else if !palpate_is_next && again(first_peer_s) {
                    peer_s.push(turn_of(&mut peer)?);
                }
            }
        }
        let median_or =
            |times_s: &mut Vec<f64>, first_s: f64| if times_s.is_empty() { first_s } else { median(times_s) };
        Ok(Medians {
            palpate_s: median_or(&mut palpate_s, first_palpate_s),
            peer_s: median_or(&mut peer_s, first_peer_s),
        })
    }
}

/// A turn lasts at least this long, seconds: a short piece of work is done again until then, and the median counts. Else it would be the
/// caches that are timed, which hold what the other did.
const SHORTEST_TURN_S: f64 = 0.02;

fn turn_of(work: &mut impl FnMut() -> anyhow::Result<f64>) -> anyhow::Result<f64> {
    let mut times_s = vec![work()?];
    while times_s.iter().sum::<f64>() < SHORTEST_TURN_S {
        times_s.push(work()?);
    }
    Ok(median(&mut times_s))
}

/// How long a piece of work takes, seconds, and what it gives.
pub fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let began = Instant::now();
    let result = work();
    (began.elapsed().as_secs_f64(), result)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_work_is_done_again_until_the_turn_is_over() {
        let mut calls = 0;
        let mut next = [5e-3, 9e-3, 1e-3, 7e-3].into_iter();
        let seconds = turn_of(&mut || {
            calls += 1;
            Ok(next.next().unwrap_or(f64::NAN))
        });
        assert_eq!((seconds.expect("nothing fails"), calls), (6e-3, 4));
    }

    #[test]
    fn the_first_call_is_not_counted_unless_it_is_the_only_one() {
        let sequence = || {
            let mut next = [9.0, 1.0, 3.0, 2.0].into_iter();
            move || Ok(next.next().unwrap_or(f64::NAN))
        };
        let many = Turns { most: 3, budget_s: f64::INFINITY }.take(sequence(), sequence()).expect("nothing fails");
        assert_eq!(many, Medians { palpate_s: 2.0, peer_s: 2.0 });
        let one = Turns { most: 3, budget_s: -1.0 }.take(sequence(), sequence()).expect("nothing fails");
        assert_eq!(one, Medians { palpate_s: 9.0, peer_s: 9.0 });
    }
}
