//! A piece of a log between two jumps, prepared for integration by equations 19 to 21 of Moll & Erdmann 2001 or by the closed
//! forms.

use crate::estimate::closed_form;
use crate::estimate::closed_form::{Contact, relative_height};
use crate::estimate::measurements::{Instant, Measurements};
use crate::log::Log;
use crate::math::local_polynomial::FEWEST;
use crate::reconstruct::options::method::Method;
use crate::reconstruct::paper::equations::Signals;
use std::ops::Range;

/// A piece prepared for integration.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// Samples of the log.
    pub samples: Vec<usize>,
    pub measurements: Measurements,
    /// Height of the centre of mass over that at the first sample, metres.
    pub relative: Vec<f64>,
    /// Heights at the first sample with which numerator and denominator of ψ' vanish together, at one time or another.
    pub crossing_heights: Vec<f64>,
    /// For the differential equations.
    pub signals: Option<Signals>,
    pub sd_m: f64,
}

impl Piece {
    pub fn new(log: &Log, measurements: &Measurements, range: Range<usize>, method: Method, sd_m: f64) -> Option<Self> {
        let mut samples: Vec<usize> = Vec::new();
        for index in range {
            let time = |index: usize| log.samples[index].time_s;
            let later = samples.last().is_none_or(|&last| time(index) > time(last));
            if measurements.instants[index].both_seen() && later {
                samples.push(index);
            }
        }
        if samples.len() < FEWEST {
            return None;
        }
        let own = measurements.of(samples.iter().map(|&index| measurements.instants[index]).collect());
        let times_s: Vec<f64> = samples.iter().map(|&index| log.samples[index].time_s).collect();
        let relative = relative_height(&own);
        let signals = Signals::new(&own.instants, &times_s, own.size_m(), sd_m)?;
        let crossing_heights = signals.crossing_heights(&relative);
        let signals = (method == Method::Ode).then_some(signals);
        Some(Self { relative, crossing_heights, measurements: own, samples, signals, sd_m })
    }

    /// Diagonal of the range of its contacts: a measure of the information in it.
    pub fn path_length_m(&self) -> f64 {
        let (first, last) = (&self.measurements.instants[0], &self.measurements.instants[self.measurements.len() - 1]);
        let (mut low, mut high) = ([first.s1, first.s2], [last.s1, last.s2]);
        for instant in &self.measurements.instants {
            for (index, s) in [instant.s1, instant.s2].into_iter().enumerate() {
                low[index] = low[index].min(s);
                high[index] = high[index].max(s);
            }
        }
        (high[0] - low[0]).hypot(high[1] - low[1])
    }

    /// r₁ and r₂ at the first instant, for a height of the centre of mass.
    pub fn start(&self, height_m: f64) -> (f64, f64) {
        if let Some(signals) = &self.signals {
            return signals.start(height_m);
        }
        let first = &self.measurements.instants[0];
        let x = first.balance_x();
        first.palms.supports_of_center([x, height_m]).into()
    }

    /// The contacts from (r₁, r₂) at the first instant, ψ = 0 there. `None` when the integral diverges.
    pub fn integrate(&self, (r1, r2): (f64, f64)) -> Option<Vec<Contact>> {
        let contacts = match &self.signals {
            Some(signals) => signals.integrate((r1, r2)),
            None => {
                let first = &self.measurements.instants[0];
                let [_, height] = first.palms.center([r1, r2]);
                closed_form::integrate(&self.measurements, &self.relative, height, self.sd_m, QUADRATURE_RATE_SD)
                    .contacts
            }
        };
        let bounded = |c: &Contact| [c.psi, c.r1, c.d1, c.r2, c.d2].iter().all(|value| value.abs() < DIVERGED);
        contacts.iter().all(bounded).then_some(contacts)
    }

    /// Mean square error of the X coordinate of the centre of mass, square metres.
    pub fn x_error_m2(&self, contacts: &[Contact]) -> f64 {
        let error = |(instant, contact): (&Instant, &Contact)| {
            let [x, _] = instant.palms.center([contact.r1, contact.r2]);
            (x - instant.balance_x()).powi(2)
        };
        self.measurements.instants.iter().zip(contacts).map(error).sum::<f64>() / contacts.len() as f64
    }
}

/// Value, in metres or radians, from which on an integral counts as diverged.
const DIVERGED: f64 = 1e6;

/// Standard deviation of the change of the rotation from one step to the next that the quadrature expects, radians.
const QUADRATURE_RATE_SD: f64 = 0.01;
