//! Mistakes recognised by undoing them: each of the commonest is undone in a part of the log, and the first without which that is certified
//! is named. What is cheap comes first: the readings alone, then palms that would hold nothing, then a brief search. The commonest are tried as soon as
//! neither the first way of the search nor inertia has explained the log as it is written: all that comes after it takes ten times as long as they do.

use rayon::prelude::*;
use std::borrow::Cow;
use std::cell::OnceCell;

use super::Mistake;
use super::by_readings::hold;
use crate::log::{Log, Sample};
use crate::reconstruct::options::error::ReconstructError;
use crate::reconstruct::ordinary_rig::{differs_from_stated, thinned};
use crate::reconstruct::reconstructor::{OrdinaryRig, Reconstructor};
use crate::reconstruct::result::reconstruction::Reconstruction;
use crate::reconstruct::search::schedule::Stage;
use crate::reconstruct::start::Start;
use crate::reconstruct::verdict::doubt::{Doubt, Verdict};
use crate::sensor::{Rig, Tolerances};
use crate::shape::SupportFunction;

/// Mistakes in names and signs, the commonest first.
const FIXED: [Mistake; 9] = [
    Mistake::PadsSwapped,
    Mistake::Phi1Clockwise,
    Mistake::Phi2FromHorizontal,
    Mistake::AnglesSwapped,
    Mistake::Phi1FromVertical,
    Mistake::Phi1FromVerticalClockwise,
    Mistake::Phi2Clockwise,
    Mistake::BothClockwise,
    Mistake::PalmsSwapped,
];

/// Standard deviation of the zeros of the pads, metres, where they are looked for: a search finds them within twice of that.
const ZERO_SD_M: f64 = 2e-3;

/// Distance between zeros, or ends of the pads, from which such a search begins, metres.
const ZERO_STEP_M: f64 = 5e-3;

/// Steps to each side that are tried: of the zeros, and of the far ends, which are first read off the log roughly.
const ZERO_STEPS: [f64; 9] = [0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0];
const END_STEPS: [f64; 9] = ZERO_STEPS;

/// A zero within so many standard deviations of what is stated is as stated.
const AS_STATED_SDS: f64 = 3.0;

impl Verdict {
    /// Whether a mistake in the log may be behind this.
    fn may_be_a_mistake(&self) -> bool {
        let is_suspicious = |doubt: &Doubt| {
            doubt.is_contradiction() || matches!(doubt, Doubt::UnlikelyRig { .. } | Doubt::Unbalanced { .. })
        };
        self.doubts.iter().any(is_suspicious)
    }

    /// Whether shape or motion are known too poorly to be certified: digits that are missing may be why.
    fn is_imprecise(&self) -> bool {
        let is_uncertain =
            |doubt: &Doubt| matches!(doubt, Doubt::UncertainOrientation { .. } | Doubt::UncertainBoundary { .. });
        self.doubts.iter().any(is_uncertain)
    }
}

impl Reconstructor<'_> {
    /// As [`run`](Self::run), and where no object explains the log, with the mistake in how it is written that would make it so: the first of
    /// the doubts is [`Doubt::Mistaken`], and what is reconstructed is the log without it ([`log_as_read`](Self::log_as_read)). A log that
    /// is explained at once costs nothing more.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    ///
    /// ```
    /// use palpate::reconstruct::{Doubt, Mistake, Reconstructor};
    /// # use palpate::{plan::{PalmLimits, plan_turn}, shape::NamedShape, simulate::{SimulateOptions, simulate}};
    /// # let egg = NamedShape::Egg.shape(0.03)?;
    /// # let plan = plan_turn(&egg, &PalmLimits::default(), 40.0)?;
    /// # let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
    /// # let mut log = simulate(&egg, &plan.motion.sample(5.0)?, &options)?.log;
    /// for sample in &mut log.samples {
    ///     std::mem::swap(&mut sample.s1_m, &mut sample.s2_m);
    /// }
    /// let found = Reconstructor::new().run_or_name_mistake(&log)?;
    /// assert!(!found.is_certified());
    /// assert_eq!(found.verdict.doubts[0], Doubt::Mistaken { mistake: Mistake::PadsSwapped });
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn run_or_name_mistake(&self, log: &Log) -> Result<Reconstruction, ReconstructError> {
        if self.integrates() || !self.starts_from_nothing() {
            return self.run(log);
        }
        if let Some(mistake) = Mistake::in_units(log).filter(|_| self.known_rig() != Rig::default()) {
            // Whatever such readings come to, nobody's palms are as long or as short, or open as little.
            return self.run_without(&Recognised::by_readings(mistake), log, None);
        }
        if let Some(mistake) = Mistake::leaps_to_zero(log) {
            return self.run_without(&Recognised::by_readings(mistake), log, None);
        }
        let (ordinary, at_once, later) = (OnceCell::new(), OnceCell::new(), OnceCell::new());
        let ordinary = || ordinary.get_or_init(|| self.explained_by_ordinary_rig(log)).clone();
        let at_once = || at_once.get_or_init(|| self.recognised_at_once(log, &ordinary)).clone();
        let recognised = || at_once().or_else(|| later.get_or_init(|| self.recognised_later(log, None)).clone());
        let has_fine_digits = || Mistake::coarse_digits(log).is_none();
        // What takes long, or is no reason to give up, comes last.
        let as_written = self.run_while(log, &ordinary, &|stage, is_explained| match stage {
            // Through coarse digits, friction and inertia are not told from anything else.
            Stage::Forces => has_fine_digits(),
            Stage::FirstWay => is_explained || at_once().is_none(),
            Stage::FirstArrangement => at_once().is_none() && has_fine_digits(),
            Stage::EqualTrust => is_explained || recognised().is_none(),
        });
        let recognised = match &as_written {
            Ok(found) if !found.verdict.may_be_a_mistake() => {
                Mistake::coarse_digits(log).filter(|_| found.verdict.is_imprecise()).map(Recognised::by_readings)
            }
            Ok(found) => at_once().or_else(|| match later.get() {
                Some(named) => named.clone().or_else(|| zero_off(found)),
                None => self.recognised_later(log, Some(found)),
            }),
            Err(ReconstructError::NoStart { .. } | ReconstructError::NotSolvable) => recognised(),
            Err(_) => None,
        };
        match recognised {
            Some(recognised) => self.run_without(&recognised, log, Some(as_written)),
            None => as_written,
        }
    }

    /// The log without a mistake, or as it is where that is not to be undone, with the mistake as the first doubt.
    fn run_without(
        &self,
        &Recognised { mistake, ref shape }: &Recognised,
        log: &Log,
        as_written: Option<Result<Reconstruction, ReconstructError>>,
    ) -> Result<Reconstruction, ReconstructError> {
        let found = match (mistake, mistake.undone_for(log, self.known_rig().calibration.zero_m)) {
            (Mistake::RigNotExact, _) => self.with_ordinary_rig().run(log),
            (_, Some(undone)) => match shape {
                Some(shape) => self
                    .clone()
                    .start(Start::Shape(shape.clone()))
                    .run(&undone)
                    .ok()
                    .filter(|found| found.verdict.is_explained())
                    .map_or_else(|| self.run(&undone), Ok),
                None => self.run(&undone),
            },
            (_, None) => as_written.unwrap_or_else(|| self.run(log)),
        };
        let mut found = found.map_err(|error| match error {
            ReconstructError::NoStart { .. } => {
                ReconstructError::NoStart { advice: format!("{mistake}: {}", mistake.remedy()) }
            }
            other => other,
        })?;
        found.verdict.doubts.insert(0, Doubt::Mistaken { mistake });
        Ok(found)
    }

    /// The log that a result of [`run_or_name_mistake`](Self::run_or_name_mistake) is of: that which it was made from, without the mistake that
    /// its verdict names.
    pub fn log_as_read<'b>(&self, log: &'b Log, found: &Reconstruction) -> Cow<'b, Log> {
        let undone = match found.verdict.doubts.first() {
            Some(Doubt::Mistaken { mistake }) => mistake.undone_for(log, self.known_rig().calibration.zero_m),
            _ => None,
        };
        undone.map_or(Cow::Borrowed(log), Cow::Owned)
    }

    /// The mistake without which a log would be explained, of those that are soon tried: what the readings show, names and signs, a rig that is taken as
    /// exact, and pads read from their far ends where the readings look so. `None` where nothing speaks for one.
    fn recognised_at_once(&self, log: &Log, ordinary: &OrdinaryRig) -> Option<Recognised> {
        if let Some(mistake) = Mistake::by_readings(log) {
            return Some(Recognised::by_readings(mistake));
        }
        if let Some(found) = ordinary() {
            // A log that is explained as it is written has no other mistake.
            let named = |found: Reconstruction| Recognised { mistake: Mistake::RigNotExact, shape: Some(found.shape) };
            return Some(found).filter(differs_from_stated).map(named);
        }
        let few = thinned(log);
        let stated = self.known_rig();
        let tolerant = self.with_ordinary_rig();
        let explained = |log: &Log| tolerant.run_briefly(log).ok().filter(Reconstruction::is_com_certified);
        let named = |mistake: Mistake, found: Reconstruction| Recognised { mistake, shape: Some(found.shape) };
        let mended = |mistake: Mistake| {
            let undone = mistake.undone_for(&few, stated.calibration.zero_m)?;
            let found = if hold(&undone) { explained(&undone) } else { None };
            found.map(|found| named(mistake, found))
        };
        let [likely, _] = Reading::of_pads(&few);
        FIXED
            .into_par_iter()
            .find_map_first(mended)
            .or_else(|| likely.par_iter().find_map_first(|reading| tolerant.explained_by(reading, &few)))
    }

    /// The same of all others, or but for a zero of its rig, as `found`.
    fn recognised_later(&self, log: &Log, found: Option<&Reconstruction>) -> Option<Recognised> {
        let few = thinned(log);
        let tolerant = self.with_ordinary_rig();
        let by_zeros =
            || Reading::of_pads(&few)[1].par_iter().find_map_first(|reading| tolerant.explained_by(reading, &few));
        found.and_then(zero_off).or_else(|| Mistake::coarse_digits(log).map(Recognised::by_readings)).or_else(by_zeros)
    }

    /// How the pads are read where this reading of them, or one nearby, explains a log.
    fn explained_by(&self, reading: &Reading, few: &Log) -> Option<Recognised> {
        let stated = self.known_rig();
        let place_m = |palm: usize| Some(reading.place_m[palm]).filter(|_| reading.is_far[palm]);
        let turned = Mistake::ReadFromTip { length1_m: place_m(0), length2_m: place_m(1) };
        let zero_m = |palm: usize| {
            Some(reading.place_m[palm] + stated.calibration.zero_m[palm]).filter(|_| !reading.is_far[palm])
        };
        let moved = Mistake::ZeroOff { zero1_m: zero_m(0), zero2_m: zero_m(1) };
        let log = moved.undone_for(&turned.undone_for(few, [0.0; 2])?, stated.calibration.zero_m)?;
        let is_on_pad = |s: Option<f64>| s.is_none_or(|s| s > -2.0 * ZERO_SD_M);
        if !log.samples.iter().all(|sample| is_on_pad(sample.s1_m) && is_on_pad(sample.s2_m)) {
            return None;
        }
        let tolerances =
            Tolerances { zero_sd_m: stated.tolerances.zero_sd_m.map(|sd| sd.max(ZERO_SD_M)), ..stated.tolerances };
        let found = self.clone().rig(Rig::new(stated.calibration, tolerances)).run_briefly(&log).ok()?;
        let is_of_rig = |doubt: &Doubt| matches!(doubt, Doubt::UnlikelyRig { .. });
        let of_rig = found.calibration.as_ref().filter(|_| found.verdict.doubts.iter().all(is_of_rig))?;
        let named = |mistake: Mistake| Some(Recognised { mistake, shape: Some(found.shape.clone()) });
        let off_m = [0, 1].map(|palm| of_rig.calibration.zero_m[palm] - stated.calibration.zero_m[palm]);
        if reading.is_far.contains(&true) {
            let length_m = |palm: usize| Some(reading.place_m[palm] - off_m[palm]).filter(|_| reading.is_far[palm]);
            return named(Mistake::ReadFromTip { length1_m: length_m(0), length2_m: length_m(1) });
        }
        let zero_m = |palm: usize| {
            let off_m = reading.place_m[palm] + off_m[palm];
            let is_off = off_m.abs() > AS_STATED_SDS * stated.tolerances.zero_sd_m[palm];
            is_off.then_some(stated.calibration.zero_m[palm] + off_m)
        };
        zero_m(0).or(zero_m(1)).and_then(|_| named(Mistake::ZeroOff { zero1_m: zero_m(0), zero2_m: zero_m(1) }))
    }
}

/// The zeros that an explanation of a log has far from what the rig is stated to have, where nothing else speaks against it.
fn zero_off(found: &Reconstruction) -> Option<Recognised> {
    let is_of_rig = |doubt: &Doubt| matches!(doubt, Doubt::UnlikelyRig { .. });
    let constants = found.calibration.as_ref().filter(|_| found.verdict.doubts.iter().all(is_of_rig))?;
    let zero_m = |name: &str| {
        let constant = constants.constants.iter().find(|constant| constant.name == name)?;
        let off_m = (constant.value - constant.stated).abs();
        (off_m > AS_STATED_SDS * constant.prior_sd).then_some(constant.value)
    };
    let [zero1_m, zero2_m] = ["s1_zero_m", "s2_zero_m"].map(zero_m);
    zero1_m
        .or(zero2_m)
        .map(|_| Recognised { mistake: Mistake::ZeroOff { zero1_m, zero2_m }, shape: Some(found.shape.clone()) })
}

/// A mistake, and the shape that a part of the log without it has; `None` where the readings alone show the mistake.
#[derive(Clone)]
struct Recognised {
    mistake: Mistake,
    shape: Option<SupportFunction>,
}

impl Recognised {
    fn by_readings(mistake: Mistake) -> Self {
        Self { mistake, shape: None }
    }
}

/// A way to read the pads.
struct Reading {
    /// Whether each is read from its far end.
    is_far: [bool; 2],
    /// Where that end is, or by what the zero is off, metres.
    place_m: [f64; 2],
}

impl Reading {
    /// Readings of the pads from the far end, or with a zero elsewhere: those that a log speaks for, and all others. None where its palms hold nothing.
    fn of_pads(few: &Log) -> [Vec<Self>; 2] {
        if !hold(few) {
            return [vec![], vec![]];
        }
        let [from_base, from_tip] = [false, true].map(|is_far| [0, 1].map(|palm| Trend::of(few, palm, is_far)));
        // The contacts are about as far out on both palms, on the whole.
        let around = |middle_m: f64, [pad1, pad2]: &[Trend; 2]| {
            let half_m = 0.5 * (pad1.mean_m - pad2.mean_m);
            [middle_m + half_m, middle_m - half_m]
        };
        let [zero_m, end_m] = [&from_base, &from_tip].map(|[pad1, pad2]| 0.5 * (pad1.at_base_m + pad2.at_base_m));
        let mut both_ends: Vec<Self> = END_STEPS
            .map(|steps| Self { is_far: [true; 2], place_m: around(end_m + steps * ZERO_STEP_M, &from_tip) })
            .into();
        let one_end = [
            Self { is_far: [true, false], place_m: [from_tip[0].mean_m + from_base[1].mean_m, 0.0] },
            Self { is_far: [false, true], place_m: [0.0, from_base[0].mean_m + from_tip[1].mean_m] },
        ];
        let mut zeros_m = ZERO_STEPS.map(|steps| steps * ZERO_STEP_M);
        zeros_m.sort_by(|a, b| (a - zero_m).abs().total_cmp(&(b - zero_m).abs()));
        let zeros = zeros_m.map(|zero_m| Self { is_far: [false; 2], place_m: around(zero_m, &from_base) });
        let runs_backwards = from_tip.iter().all(|pad| pad.runs_backwards);
        let likely = if runs_backwards { std::mem::take(&mut both_ends) } else { vec![] };
        [likely, one_end.into_iter().chain(zeros).chain(both_ends).collect()]
    }
}

/// How the readings of a pad go with the opening of the palms.
struct Trend {
    /// Their mean, metres.
    mean_m: f64,
    /// What they tend to as the palms open, metres: 0 from the base, and the length of the pad from its far end.
    at_base_m: f64,
    /// Whether contacts seem to move out as the palms open, as they do from the far end.
    runs_backwards: bool,
}

impl Trend {
    /// As of a circle of radius R between the palms, whose contacts are at s = R/tan(φ₂/2) from where these meet: rough for any other shape.
    fn of(log: &Log, palm: usize, is_far: bool) -> Self {
        let of_sample = |sample: &Sample| {
            let s_m = [sample.s1_m, sample.s2_m][palm]?;
            let shift_m = sample.palms.base_shifts_m(&sample.palms.angles())[palm];
            let from_meeting_m = if is_far { s_m - shift_m } else { s_m + shift_m };
            Some(((0.5 * sample.palms.phi2_rad).tan().recip(), from_meeting_m))
        };
        let points: Vec<(f64, f64)> = log.samples.iter().filter_map(of_sample).collect();
        let count = points.len().max(1) as f64;
        let (mean_cot, mean_m) =
            points.iter().fold((0.0, 0.0), |(x, y), (cot, s_m)| (x + cot / count, y + s_m / count));
        let (squares, products) = points.iter().fold((0.0, 0.0), |(xx, xy), (cot, s_m)| {
            (xx + (cot - mean_cot).powi(2), xy + (cot - mean_cot) * (s_m - mean_m))
        });
        let slope_m = products / f64::max(squares, f64::MIN_POSITIVE);
        Self { mean_m, at_base_m: mean_m - slope_m * mean_cot, runs_backwards: slope_m < 0.0 }
    }
}
