//! What summary.json says.

use palpate::Reconstruction;
use palpate::compare::TruthError;
use palpate::number_or_null;
use palpate::reconstruct::{
    CalibrationEstimate, ConstantEstimate, Doubt, Findings, FoundSymmetry, FrictionEstimate, Jump, MeasuredForces,
    Verdict,
};
use palpate::shape::Symmetry;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The summary of a result, `summary.json`. A number that could not be computed (NaN or infinite) is `null` in JSON and reads back
/// as NaN.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Shape and motion are statistically consistent with the log, unique and convex.
    pub certified: bool,
    /// `certified`, and force/torque balance holds within the noise, so that the centre of mass can be trusted too.
    pub com_certified: bool,
    /// Why not certified; empty when both verdicts are yes.
    pub reason: String,
    /// The same one by one, with the numbers behind each. Empty in files of older versions; see [`Summary::verdict`].
    #[serde(default, with = "crate::result::doubts")]
    pub doubts: Vec<Doubt>,
    /// Weighted squared residuals per degree of freedom; near 1 for a fit that is consistent with the noise.
    #[serde(with = "number_or_null")]
    pub chi2_per_dof: f64,
    /// Times in seconds of the first sample after each jump.
    pub jumps: Vec<f64>,
    /// The same jumps, with what happened.
    #[serde(default)]
    pub jump_details: Vec<JumpSummary>,
    /// Fraction of the boundary (in normal angle) that was felt, 0 to 1.
    #[serde(with = "number_or_null")]
    pub coverage: f64,
    /// Number of distinct arrangements that fit equally well; 1 when the answer is unique.
    pub alternatives: usize,
    /// How the object is symmetric.
    #[serde(default)]
    pub symmetry: SymmetrySummary,
    /// Standard deviation of the contact positions, metres.
    #[serde(with = "number_or_null")]
    pub sensor_sd_m: f64,
    /// Standard deviation of the balance equation, metres.
    #[serde(with = "number_or_null")]
    pub balance_sd_m: f64,
    /// Relative standard deviation of the size, from the tolerance of what the scales of both pads have in common; 0 where the rig is exact.
    #[serde(default)]
    pub size_sd: f64,
    /// Standard deviation of a parallel shift of the boundary, metres, from that of what both surface offsets have in common.
    #[serde(default)]
    pub offset_sd_m: f64,
    /// The constants of the rig as the log has them, by name; empty where the rig is exact.
    #[serde(default)]
    pub calibration: BTreeMap<String, ConstantSummary>,
    /// What forces the result rests on: `frictionless`, `coulomb` or `inertial`.
    #[serde(default = "frictionless")]
    pub forces: String,
    /// Coefficients of friction; `None` without.
    #[serde(default)]
    pub friction: Option<FrictionSummary>,
    /// Radius of gyration about the centre of mass, metres; `None` where the inertia of the object does not count.
    #[serde(default)]
    pub gyration_radius_m: Option<CoefficientSummary>,
    /// Drag on the rotation over the moment of inertia, 1/s; likewise.
    #[serde(default)]
    pub damping_per_s: Option<CoefficientSummary>,
    /// Weight of the object by measured forces, newtons; `None` where none were measured.
    #[serde(default)]
    pub weight_n: Option<CoefficientSummary>,
    /// Standard deviation of a measured force, newtons; likewise.
    #[serde(default)]
    pub force_sd_n: Option<f64>,
    /// What is odd about measured forces, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub oddities: Vec<String>,
    /// Number of samples of the log.
    pub samples: usize,
    /// Number of harmonics of the support function.
    pub harmonics: usize,
    /// Duration of the reconstruction, seconds.
    #[serde(with = "number_or_null")]
    pub seconds: f64,
    /// Version of palpate.
    pub version: String,
    /// File name of the log, if it had one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<String>,
    /// What the reader of the log had to say about it.
    #[serde(default)]
    pub notes: Vec<String>,
    /// How far the result is from the truth, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth: Option<TruthSummary>,
}

/// Coefficients of friction of both palms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrictionSummary {
    /// Of palm 1.
    pub mu1: CoefficientSummary,
    /// Of palm 2.
    pub mu2: CoefficientSummary,
}

/// A number with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoefficientSummary {
    /// What was found.
    #[serde(with = "number_or_null")]
    pub value: f64,
    /// Its standard deviation.
    #[serde(with = "number_or_null")]
    pub sd: f64,
}

fn frictionless() -> String {
    "frictionless".to_owned()
}

/// What forces a result rests on.
fn forces_of(reconstruction: &Reconstruction) -> String {
    match (reconstruction.friction, reconstruction.inertia) {
        (_, Some(_)) => "inertial".to_owned(),
        (Some(_), None) => "coulomb".to_owned(),
        (None, None) => frictionless(),
    }
}

impl From<&FrictionEstimate> for FrictionSummary {
    fn from(friction: &FrictionEstimate) -> Self {
        let of =
            |palm: usize| CoefficientSummary { value: friction.coefficients[palm], sd: friction.coefficient_sds[palm] };
        Self { mu1: of(0), mu2: of(1) }
    }
}

/// A calibration constant of the rig; its unit is that of its name.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConstantSummary {
    /// What the log has it to be.
    #[serde(with = "number_or_null")]
    pub value: f64,
    /// Its standard deviation.
    #[serde(with = "number_or_null")]
    pub sd: f64,
    /// What the rig was stated to have.
    #[serde(with = "number_or_null")]
    pub stated: f64,
    /// The standard deviation of that.
    #[serde(with = "number_or_null")]
    pub prior_sd: f64,
}

/// One jump of the object to another resting pose. A number that could not be computed is `null` in JSON and reads back as NaN.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JumpSummary {
    /// Time of the first sample after it, seconds.
    pub time_s: f64,
    /// Orientation before, radians.
    #[serde(with = "number_or_null")]
    pub psi_before_rad: f64,
    /// Orientation after, radians.
    #[serde(with = "number_or_null")]
    pub psi_after_rad: f64,
    /// How much lower the centre of mass is afterwards, over the palms as they are then, metres.
    #[serde(with = "number_or_null")]
    pub height_drop_m: f64,
    /// Whether the object that was found would make this jump: downhill all the way.
    pub physical: bool,
}

impl From<&Jump> for JumpSummary {
    fn from(jump: &Jump) -> Self {
        Self {
            time_s: jump.time_s,
            psi_before_rad: jump.psi_before_rad,
            psi_after_rad: jump.psi_after_rad,
            height_drop_m: jump.height_drop_m(),
            physical: jump.physical,
        }
    }
}

/// How an object is symmetric: `order` 2 and more is its own image when turned by 2π/`order`, and its ψ is then defined up to multiples
/// of that between pieces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SymmetrySummary {
    /// Order of rotation; 1 = none.
    pub order: u32,
    /// Whether it is its own mirror image.
    pub mirror: bool,
    /// The probability of this, 0 to 1; `null` where it was not asked.
    pub probability: Option<f64>,
    /// Standard deviation of the difference of r between copies that were both felt, metres; `null` where there is none.
    #[serde(default)]
    pub deviation_sd_m: Option<f64>,
}

impl Default for SymmetrySummary {
    /// Not asked.
    fn default() -> Self {
        FoundSymmetry::default().into()
    }
}

impl From<FoundSymmetry> for SymmetrySummary {
    fn from(found: FoundSymmetry) -> Self {
        let FoundSymmetry { symmetry: Symmetry { order, mirror }, probability, deviation_sd_m } = found;
        Self { order, mirror, probability, deviation_sd_m }
    }
}

impl From<SymmetrySummary> for FoundSymmetry {
    fn from(SymmetrySummary { order, mirror, probability, deviation_sd_m }: SymmetrySummary) -> Self {
        Self { symmetry: Symmetry { order, mirror }, probability, deviation_sd_m }
    }
}

/// How far a result is from the truth. A number that could not be computed is `null` in JSON and reads back as NaN.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthSummary {
    /// Root mean square error of r(θ) over the felt boundary after the best rotation, metres.
    #[serde(with = "number_or_null")]
    pub rms_r_m: f64,
    /// The same after the best translation as well: the error of the form alone, metres.
    #[serde(with = "number_or_null")]
    pub rms_form_m: f64,
    /// Hausdorff distance of the boundaries, metres.
    #[serde(with = "number_or_null")]
    pub hausdorff_m: f64,
    /// Root mean square error of ψ, radians.
    #[serde(with = "number_or_null")]
    pub rms_psi_rad: f64,
    /// Root mean square error of the centre of mass in the global frame, metres.
    #[serde(with = "number_or_null")]
    pub rms_com_m: f64,
}

impl From<TruthError> for TruthSummary {
    fn from(TruthError { rms_r_m, rms_form_m, hausdorff_m, rms_psi_rad, rms_com_m }: TruthError) -> Self {
        Self { rms_r_m, rms_form_m, hausdorff_m, rms_psi_rad, rms_com_m }
    }
}

impl From<TruthSummary> for TruthError {
    fn from(TruthSummary { rms_r_m, rms_form_m, hausdorff_m, rms_psi_rad, rms_com_m }: TruthSummary) -> Self {
        Self { rms_r_m, rms_form_m, hausdorff_m, rms_psi_rad, rms_com_m }
    }
}

fn constants(calibration: &CalibrationEstimate) -> impl Iterator<Item = (String, ConstantSummary)> {
    calibration.constants.iter().map(|constant| {
        let &ConstantEstimate { value, sd, stated, prior_sd, .. } = constant;
        (constant.name.clone(), ConstantSummary { value, sd, stated, prior_sd })
    })
}

impl Summary {
    /// The summary of a reconstruction that took `seconds`. Set `log` and `truth` where there is something to say, and add to `notes`.
    pub fn new(reconstruction: &Reconstruction, seconds: f64) -> Self {
        // JSON has no NaN, and a list of times has no gaps.
        let jumps = || reconstruction.jumps.iter().filter(|jump| jump.time_s.is_finite());
        Self {
            certified: reconstruction.is_certified(),
            com_certified: reconstruction.is_com_certified(),
            reason: reconstruction.verdict.reason(),
            doubts: reconstruction.verdict.doubts.clone(),
            chi2_per_dof: reconstruction.chi2_per_dof,
            jumps: jumps().map(|jump| jump.time_s).collect(),
            jump_details: jumps().map(JumpSummary::from).collect(),
            coverage: reconstruction.coverage,
            alternatives: reconstruction.alternatives,
            symmetry: reconstruction.symmetry.into(),
            sensor_sd_m: reconstruction.sensor_sd_m,
            balance_sd_m: reconstruction.balance_sd_m,
            size_sd: reconstruction.calibration.as_ref().map_or(0.0, |calibration| calibration.size_sd),
            offset_sd_m: reconstruction.calibration.as_ref().map_or(0.0, |calibration| calibration.offset_sd_m),
            calibration: reconstruction.calibration.iter().flat_map(constants).collect(),
            forces: forces_of(reconstruction),
            friction: reconstruction.friction.as_ref().map(FrictionSummary::from),
            gyration_radius_m: reconstruction
                .inertia
                .map(|found| CoefficientSummary { value: found.gyration_radius_m, sd: found.gyration_radius_sd_m }),
            damping_per_s: reconstruction
                .inertia
                .map(|found| CoefficientSummary { value: found.damping_per_s, sd: found.damping_sd_per_s }),
            weight_n: None,
            force_sd_n: None,
            oddities: Vec::new(),
            samples: reconstruction.motion.len(),
            harmonics: reconstruction.shape.harmonics_m().len(),
            seconds,
            version: env!("CARGO_PKG_VERSION").to_string(),
            log: None,
            notes: [reconstruction.findings.as_ref().and_then(left_out), still_open(reconstruction)]
                .into_iter()
                .flatten()
                .collect(),
            truth: None,
        }
    }

    /// The same with what measured forces say.
    #[must_use]
    pub fn with_forces(mut self, forces: Option<&MeasuredForces>) -> Self {
        self.weight_n = forces.map(|forces| CoefficientSummary { value: forces.weight_n, sd: forces.weight_sd_n });
        self.force_sd_n = forces.map(|forces| forces.force_sd_n);
        self.oddities = forces.map(MeasuredForces::oddities).unwrap_or_default();
        self
    }

    /// The summary of another arrangement that fits as well as the one summarised here. For that very reason it is not certified;
    /// how far it is from a truth is left out.
    #[must_use]
    pub fn of_alternative(&self, other: &Reconstruction) -> Self {
        let of_other = Self::new(other, self.seconds);
        let told = if other.verdict.doubts.is_empty() { self } else { &of_other };
        Self {
            certified: false,
            com_certified: false,
            reason: told.reason.clone(),
            doubts: told.doubts.clone(),
            alternatives: self.alternatives,
            version: self.version.clone(),
            log: self.log.clone(),
            notes: self.notes.clone(),
            ..of_other
        }
    }

    /// The verdict. Where the doubts do not say what `certified` and `com_certified` say (an older version wrote none, and a newer one
    /// may know others), it is the reason in words.
    pub fn verdict(&self) -> Verdict {
        let verdict = Verdict::new(self.doubts.clone());
        if (verdict.is_certified(), verdict.is_com_certified()) == (self.certified, self.com_certified) {
            return verdict;
        }
        let text = self.reason.clone();
        Verdict::new(match (self.certified, self.com_certified) {
            (true, true) => Vec::new(),
            (true, false) => vec![Doubt::ReportedOfCenterOfMass { text }],
            (false, _) => vec![Doubt::Reported { text }],
        })
    }

    /// The summary as indented JSON with a line break at the end, the same text as `summary.json`.
    ///
    /// # Errors
    /// None in practice: every field has a JSON form.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|json| json + "\n")
    }
}

/// What to say of samples whose pose is open; where they are a reason for a doubt, that says so.
fn still_open(reconstruction: &Reconstruction) -> Option<String> {
    let samples = reconstruction.findings.as_ref()?.ambiguous;
    let is_doubt = |doubt: &Doubt| matches!(doubt, Doubt::AmbiguousPoses { .. });
    let is_told = samples == 0 || reconstruction.verdict.doubts.iter().any(is_doubt);
    let (noun, its) = if samples == 1 { ("sample", "its") } else { ("samples", "their") };
    (!is_told).then(|| format!("the pose of {samples} {noun} is open: {its} psi_sd_rad and com_sd_m say so"))
}

/// What to say of gross outliers.
fn left_out(findings: &Findings) -> Option<String> {
    let Findings { outliers, readings, .. } = *findings;
    let share = 100.0 * outliers as f64 / readings.max(1) as f64;
    (outliers > 0)
        .then(|| format!("{outliers} of {readings} contact readings ({share:.1} %) are outliers and were left out"))
}
