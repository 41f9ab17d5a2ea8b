//! Plans: small TOML files that say what to try. Every value may be a list, and all of them are tried with each other.

pub(crate) mod bounded;
pub(crate) mod many;
pub(crate) mod plan_error;
pub(crate) mod unfold;

use std::io::Read;
use std::path::Path;

use palpate::reconstruct::Method;
use serde::Deserialize;

use crate::job::object::ShapeName;
use crate::job::score::{ReconstructChoice, ScoreChoice};
use crate::job::simulate_job::MotionKind;
use crate::job::touchpad::Touchpads;
use crate::plan::bounded::{AxisRatio, Corners, Harmonics, NotNegative, Order, Positive, Samples, Seed, Share, Trials};
use crate::plan::many::Many;
use crate::plan::plan_error::{PlanError, PlanProblem};

/// Largest plan that is read, KiB.
const LIMIT_KIB: u64 = 1024;

/// A plan that was read; [`Sweep::new`](crate::Sweep::new) unfolds it.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Name of its file, for messages.
    pub(crate) file: String,
    pub(crate) kind: PlanKind,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PlanKind {
    Simulate(Box<SimulatePlan>),
    Reconstruct(ReconstructPlan),
}

/// `kind = "simulate"`: objects, motions and touchpads to be tried with each other.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SimulatePlan {
    #[serde(rename = "kind")]
    _kind: KindName,
    /// Seeds that each combination is tried with.
    #[serde(default = "one_trial")]
    pub(crate) trials: Trials,
    /// The first of them.
    #[serde(default = "first_seed")]
    pub(crate) seed: Seed,
    #[serde(default)]
    pub(crate) objects: ObjectLists,
    #[serde(default = "random_motion")]
    pub(crate) motions: Many<MotionKind>,
    pub(crate) samples: Option<Many<Samples>>,
    #[serde(default)]
    pub(crate) touchpads: Vec<TouchpadLists>,
    /// File of the rig from which the constants of each job are drawn.
    pub(crate) rig: Option<String>,
    #[serde(default)]
    pub(crate) reconstruct: ReconstructValues,
    #[serde(default)]
    pub(crate) score: ScoreValues,
}

/// `kind = "reconstruct"`: logs, with truths beside them or not.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ReconstructPlan {
    #[serde(rename = "kind")]
    _kind: KindName,
    pub(crate) logs: Many<String>,
    /// File of the rig that wrote them.
    pub(crate) rig: Option<String>,
    #[serde(default)]
    pub(crate) reconstruct: ReconstructValues,
    #[serde(default)]
    pub(crate) score: LogScoreValues,
}

/// Kinds of objects; see [`Object`](crate::Object).
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectLists {
    pub(crate) mixed: Option<MixedLists>,
    pub(crate) named: Option<NamedLists>,
    pub(crate) fourier: Option<FourierLists>,
    pub(crate) ellipse: Option<EllipseLists>,
    pub(crate) polygon: Option<PolygonLists>,
    pub(crate) outline: Option<OutlineLists>,
}

/// Nothing to choose: `objects.mixed = {}`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MixedLists {}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NamedLists {
    pub(crate) name: Many<ShapeName>,
    /// The size in the name, or the usual one, where it is left out.
    pub(crate) mean_radius_m: Option<Many<Positive>>,
}

/// Outlines from files; their centres of mass and sizes are those of the files where nothing else is said.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct OutlineLists {
    pub(crate) file: Many<String>,
    pub(crate) mean_radius_m: Option<Many<Positive>>,
    pub(crate) mass_offset: Option<Many<Share>>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FourierLists {
    pub(crate) order: Many<Order>,
    #[serde(default = "usual_radius")]
    pub(crate) mean_radius_m: Many<Positive>,
    #[serde(default = "usual_offset")]
    pub(crate) mass_offset: Many<Share>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EllipseLists {
    pub(crate) axis_ratio: Many<AxisRatio>,
    #[serde(default = "usual_radius")]
    pub(crate) mean_radius_m: Many<Positive>,
    #[serde(default = "usual_offset")]
    pub(crate) mass_offset: Many<Share>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PolygonLists {
    pub(crate) corners: Many<Corners>,
    #[serde(default = "usual_radius")]
    pub(crate) mean_radius_m: Many<Positive>,
    #[serde(default = "usual_offset")]
    pub(crate) mass_offset: Many<Share>,
}

/// One entry of `touchpads`; what is left out is ideal. See [`Touchpads`](crate::Touchpads).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TouchpadLists {
    #[serde(default = "nothing")]
    pub(crate) noise_sd_m: Many<NotNegative>,
    pub(crate) counts_per_inch: Option<Many<Positive>>,
    #[serde(default = "nothing")]
    pub(crate) angle_noise_sd_rad: Many<NotNegative>,
    #[serde(default = "no_dropout")]
    pub(crate) dropout: Many<Share>,
    pub(crate) length_m: Option<Many<Positive>>,
}

/// `reconstruct`: the options, one value each.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ReconstructValues {
    #[serde(default)]
    method: Method,
    harmonics: Option<Harmonics>,
    sensor_sd_m: Option<Positive>,
}

/// `score` of a simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ScoreValues {
    #[serde(default)]
    reference: bool,
    #[serde(default)]
    bound: bool,
}

/// `score` of logs, whose true noise is unknown: no bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LogScoreValues {
    #[serde(default)]
    reference: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum KindName {
    Simulate,
    Reconstruct,
}

/// What tells the kinds of plans apart.
#[derive(Deserialize)]
struct Head {
    kind: KindName,
}

impl From<&ReconstructValues> for ReconstructChoice {
    fn from(values: &ReconstructValues) -> Self {
        Self {
            method: values.method,
            harmonics: values.harmonics.map(|harmonics| harmonics.0),
            sensor_sd_m: values.sensor_sd_m.map(|sd| sd.0),
        }
    }
}

impl From<ScoreValues> for ScoreChoice {
    fn from(ScoreValues { reference, bound }: ScoreValues) -> Self {
        Self { reference, bound }
    }
}

impl From<LogScoreValues> for ScoreChoice {
    fn from(LogScoreValues { reference }: LogScoreValues) -> Self {
        Self { reference, bound: false }
    }
}

fn one_trial() -> Trials {
    Trials(1)
}

fn first_seed() -> Seed {
    Seed(1)
}

fn random_motion() -> Many<MotionKind> {
    MotionKind::Random.into()
}

fn usual_radius() -> Many<Positive> {
    Positive(0.03).into()
}

fn usual_offset() -> Many<Share> {
    Share(0.1).into()
}

fn nothing() -> Many<NotNegative> {
    NotNegative(0.0).into()
}

fn no_dropout() -> Many<Share> {
    Share(0.0).into()
}

/// Reads a plan from a file.
///
/// # Errors
/// The file cannot be read, or is no plan.
pub fn read_plan(path: &Path) -> Result<Plan, PlanError> {
    let (file, text) = read_text(path)?;
    parse_plan(&file, &text)
}

/// Reads a touchpad from a TOML file with the keys of an entry of `touchpads` in a plan, one value each.
///
/// # Errors
/// The file cannot be read, or is no touchpad.
pub fn read_touchpad(path: &Path) -> Result<Touchpads, PlanError> {
    let (file, text) = read_text(path)?;
    let lists: TouchpadLists = parsed(&file, &text)?;
    match unfold::touchpads(&lists)[..] {
        [pads] => Ok(pads),
        _ => Err(PlanError { file, line: None, key: None, problem: PlanProblem::SeveralTouchpads }),
    }
}

/// Name and text of a file, up to the limit.
fn read_text(path: &Path) -> Result<(String, String), PlanError> {
    let file = path.display().to_string();
    let failed = |problem| PlanError { file: file.clone(), line: None, key: None, problem };
    let unreadable = |error: std::io::Error| failed(PlanProblem::Unreadable(error.to_string()));
    let mut text = String::new();
    let limit = 1024 * LIMIT_KIB;
    std::fs::File::open(path).map_err(unreadable)?.take(limit + 1).read_to_string(&mut text).map_err(unreadable)?;
    if text.len() as u64 > limit {
        return Err(failed(PlanProblem::TooLarge(LIMIT_KIB)));
    }
    Ok((file, text))
}

/// Takes in the text of a plan; `file` is what messages call it.
///
/// # Errors
/// The text is no plan.
pub fn parse_plan(file: &str, text: &str) -> Result<Plan, PlanError> {
    let Head { kind } = parsed(file, text)?;
    let kind = match kind {
        KindName::Simulate => PlanKind::Simulate(Box::new(parsed(file, text)?)),
        KindName::Reconstruct => PlanKind::Reconstruct(parsed(file, text)?),
    };
    Ok(Plan { file: file.to_owned(), kind })
}

fn parsed<'text, T: Deserialize<'text>>(file: &str, text: &'text str) -> Result<T, PlanError> {
    let told = |error: &toml::de::Error, key: Option<String>| PlanError {
        file: file.to_owned(),
        line: error.span().map(|span| line_at(text, span.start)).filter(|_| key.as_deref() != Some(ROOT)),
        key: key.filter(|key| key != ROOT),
        problem: PlanProblem::Text(error.message().lines().collect::<Vec<_>>().join("; ")),
    };
    let document = toml::Deserializer::parse(text).map_err(|error| told(&error, None))?;
    serde_path_to_error::deserialize(document).map_err(|error| told(error.inner(), Some(error.path().to_string())))
}

/// What a path is called that leads nowhere.
const ROOT: &str = ".";

/// Number of the line, from 1, that holds the byte at `offset`.
fn line_at(text: &str, offset: usize) -> usize {
    1 + text.bytes().take(offset).filter(|byte| *byte == b'\n').count()
}
