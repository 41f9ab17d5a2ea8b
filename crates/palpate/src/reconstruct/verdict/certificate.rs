//! Is the answer right, and is it the only one? A wrong answer that is certified is the worst failure there is, so every
//! doubt ends in words for the user.

use crate::estimate::measurements::Problem;
use crate::estimate::model::force::{balance_limit_m, unstable_samples};
use crate::reconstruct::verdict::jumps::{Leap, to_and_fro};

/// Orientation less certain than this (radians) does not count as known: over all samples, and at the worst.
const MAX_PSI_SD: [f64; 2] = [0.03, 0.3];

/// Felt boundary less certain than this, as a share of the mean radius, does not count as known: as a rule, and where the object found
/// leaps between neighbouring poses. (Such leaps may be poses at wrong minima that hold the optimum on the slope of a long valley; the
/// error bars know nothing of that.)
const MAX_R_SD: [f64; 2] = [0.02, 5e-3];

/// A leap by less than this leads to a neighbouring pose, radians.
const NEIGHBOURING: f64 = 0.25;

/// Samples whose pose cannot be told are forgiven as long as the motion would be wrong by no more than this if all of them were
/// elsewhere, radians (root mean square).
const MOST_ASTRAY: f64 = 0.01;

/// Less of the boundary than this tells no object: noise alone could pass for the motion of a still one.
const LEAST_COVERAGE: f64 = 0.1;

/// Going to and fro between poses as often as this is laid to the noise of one sample.
const SHAKE: usize = 1;

/// What the certificate looks at.
pub(crate) struct Evidence<'a> {
    pub problem: &'a Problem,
    pub coefficients: &'a [f64],
    pub psi: &'a [f64],
    pub chi2_per_dof: f64,
    /// The largest χ² per degree of freedom that the noise explains.
    pub chi2_limit: f64,
    pub noise_stated: bool,
    pub sensor_m: f64,
    pub balance_m: f64,
    pub expected_sensor_m: f64,
    pub leaps: &'a [Leap],
    pub times_s: &'a [f64],
    /// Share of the boundary that was felt.
    pub coverage: f64,
    /// Samples whose pose cannot be told.
    pub unplaced: usize,
    /// By how much the orientation would be wrong if all of them were elsewhere, radians (root mean square over all samples).
    pub astray: f64,
    /// Standard deviation of ψ, radians: root mean square over all samples that could be placed, and largest.
    pub psi_sd: [f64; 2],
    pub largest_felt_r_sd_m: f64,
    pub convex: bool,
}

/// The verdict and its reason.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Verdict {
    pub certified: bool,
    pub com_certified: bool,
    /// Nothing speaks against the answer, though the log may not tell all.
    pub explained: bool,
    pub reason: String,
}

/// Judges a result.
pub(crate) fn judge(evidence: &Evidence) -> Verdict {
    let mut doubts = contradictions(evidence);
    let explained = doubts.is_empty();
    doubts.extend(gaps(evidence));
    let certified = doubts.is_empty();
    let balanced = is_balanced(evidence);
    if certified && !balanced {
        doubts.push(format!(
            "shape and motion are certified, the centre of mass is not: force/torque balance is missed by {:.2} mm \
             (friction, or fast palms)",
            1e3 * evidence.balance_m
        ));
    }
    Verdict { certified, com_certified: certified && balanced, explained, reason: doubts.join("; ") }
}

fn is_balanced(evidence: &Evidence) -> bool {
    evidence.balance_m <= balance_limit_m(evidence.expected_sensor_m, evidence.coefficients[0].abs())
}

/// What speaks against the answer.
fn contradictions(evidence: &Evidence) -> Vec<String> {
    let mut doubts = Vec::new();
    let mean_radius = evidence.coefficients[0];
    if !(mean_radius.is_finite() && mean_radius > 0.0) {
        doubts.push("no object explains the log (the mean radius comes out negative)".to_owned());
    }
    let unphysical: Vec<&Leap> = evidence.leaps.iter().filter(|leap| !leap.physical).collect();
    if let Some(first) = unphysical.first() {
        let others = if unphysical.len() > 1 { format!(" and {} more", unphysical.len() - 1) } else { String::new() };
        doubts.push(format!(
            "the object found would not turn by {:.0} deg at {} s{others}: a jump goes downhill to the next pose",
            (first.psi_after - first.psi_before).to_degrees(),
            evidence.times_s.get(first.sample).copied().unwrap_or(f64::NAN),
        ));
    }
    if evidence.chi2_per_dof > evidence.chi2_limit || !evidence.chi2_per_dof.is_finite() {
        let source = if evidence.noise_stated { "stated" } else { "seen between neighbouring samples" };
        doubts.push(format!(
            "the fit leaves {:.3} mm in the contact positions, the noise {source} explains {:.3} mm: a jump, friction, fast \
             palms, a wrong unit or sign, or palms that are not where the log says",
            1e3 * evidence.sensor_m,
            1e3 * evidence.expected_sensor_m
        ));
    }
    if !evidence.convex {
        doubts.push("the shape is not convex".to_owned());
    }
    let unstable = unstable_samples(evidence.problem, evidence.coefficients, evidence.psi, evidence.balance_m);
    if unstable * 100 > evidence.problem.len() {
        doubts.push(format!(
            "{unstable} of {} poses would not be at rest (their potential energy is not at a minimum)",
            evidence.problem.len()
        ));
    }
    doubts
}

/// What the log does not tell, however it is explained.
fn gaps(evidence: &Evidence) -> Vec<String> {
    let mut doubts = Vec::new();
    if evidence.coverage < LEAST_COVERAGE {
        doubts.push(format!(
            "only {:.0} % of the boundary was felt, too little to tell an object by: move the palms further, so that it rolls",
            100.0 * evidence.coverage
        ));
    }
    if evidence.astray > MOST_ASTRAY {
        let (samples, them, their) =
            if evidence.unplaced == 1 { ("sample", "it", "its") } else { ("samples", "them", "their") };
        doubts.push(format!(
            "the pose of {} {samples} cannot be told: another orientation explains {them} about as well ({their} psi_sd_rad \
             says so)",
            evidence.unplaced,
        ));
    }
    let to_and_fro = to_and_fro(evidence.leaps);
    if to_and_fro > SHAKE {
        doubts.push(format!(
            "the object found goes to and fro between neighbouring poses ({to_and_fro} times): it is too round, or the sensors too \
             noisy, to tell them apart"
        ));
    }
    if !evidence.psi_sd.iter().zip(MAX_PSI_SD).all(|(sd, limit)| *sd <= limit) {
        doubts.push(format!(
            "the orientation is known only to {:.1} deg (one standard deviation over all samples, {:.1} deg at the worst of \
             them): the felt boundary is too round, or too little of it was felt",
            evidence.psi_sd[0].to_degrees(),
            evidence.psi_sd[1].to_degrees()
        ));
    }
    let largest = evidence.largest_felt_r_sd_m;
    let held = evidence.leaps.iter().any(|leap| (leap.psi_after - leap.psi_before).abs() < NEIGHBOURING);
    if largest > MAX_R_SD[usize::from(held)] * evidence.coefficients[0] || !largest.is_finite() {
        doubts.push(format!(
            "parts of the felt boundary are known only to {:.2} mm (one standard deviation)",
            1e3 * largest
        ));
    }
    doubts
}

/// Why a result that is not the only one is not certified.
pub(crate) fn ambiguity(alternatives: usize) -> String {
    format!(
        "{alternatives} different objects explain the log equally well; a motion that feels more of the boundary, or feels it \
         twice, would tell them apart"
    )
}
