//! The evidence of an explanation: the probability of a log with its unknowns integrated out (D. J. C. MacKay, *Bayesian interpolation*, Neural Computation
//! 4, 1992; `docs/theory.md`, what the log says of itself). Neighbouring samples may share their errors: of two explanations the readings then decide
//! as every n-th of them would, with the likelihood to the power 1/n.

/// ln of the evidence of an explanation, by what it counts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evidence {
    /// What the readings tell, summed over the samples.
    pub of_samples: f64,
    /// What was known of shape and motion before, and how much of that the log leaves.
    pub besides: f64,
    /// Samples that share an error, by what the explanation leaves of them: so many tell as much as one.
    pub samples_per_error: f64,
}

impl Evidence {
    pub const NONE: Self = Self { of_samples: 0.0, besides: 0.0, samples_per_error: 1.0 };

    /// Of an explanation of which only the whole is known.
    pub const fn of_samples(log_evidence: f64) -> Self {
        Self { of_samples: log_evidence, ..Self::NONE }
    }

    /// What no log gives.
    pub const IMPOSSIBLE: Self = Self { besides: f64::NEG_INFINITY, ..Self::NONE };

    /// Of samples with errors of their own.
    pub fn log(&self) -> f64 {
        self.of_samples + self.besides
    }

    /// ln of the ratio of this evidence to another. A wrong explanation leaves errors with a longer memory than those of the sensors, so that the
    /// shorter one counts.
    pub fn log_ratio(&self, other: &Self) -> f64 {
        let samples_per_error = self.samples_per_error.min(other.samples_per_error);
        let of_samples = (self.of_samples - other.of_samples) / samples_per_error;
        let ratio = of_samples + (self.besides - other.besides);
        // Of two impossible ones neither is likelier.
        if ratio.is_nan() { 0.0 } else { ratio }
    }

    /// The same with something more that is not of the samples.
    pub fn with(self, log_prior: f64) -> Self {
        Self { besides: self.besides + log_prior, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_that_share_their_errors_decide_as_few_of_them_would() {
        let of = |of_samples: f64, samples_per_error: f64| Evidence { of_samples, besides: -3.0, samples_per_error };
        let [white, shared] = [1.0, 5.0].map(|samples| of(1000.0, samples).log_ratio(&of(940.0, samples)));
        assert_eq!([white, shared], [60.0, 12.0]);
        // The wrong one leaves errors with a longer memory.
        assert_eq!(of(1000.0, 2.0).log_ratio(&of(940.0, 30.0)), 30.0);
        assert_eq!(of(940.0, 30.0).log_ratio(&of(1000.0, 2.0)), -30.0);
    }

    #[test]
    fn what_was_known_before_counts_whole_whatever_the_memory() {
        let of = |besides: f64| Evidence { samples_per_error: 10.0, ..Evidence::of_samples(500.0) }.with(besides);
        assert_eq!(of(-5.0).log_ratio(&of(-25.0)), 20.0);
        assert_eq!(of(-5.0).log(), 495.0);
    }

    #[test]
    fn nothing_is_likelier_than_what_is_possible_and_of_two_impossible_ones_neither() {
        let possible = Evidence::of_samples(-1e6);
        assert_eq!(Evidence::IMPOSSIBLE.log_ratio(&possible), f64::NEG_INFINITY);
        assert_eq!(possible.log_ratio(&Evidence::IMPOSSIBLE), f64::INFINITY);
        assert_eq!(Evidence::IMPOSSIBLE.log_ratio(&Evidence::IMPOSSIBLE), 0.0);
    }
}
