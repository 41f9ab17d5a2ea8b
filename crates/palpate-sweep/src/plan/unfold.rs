//! From a plan to its jobs, in an order that depends on nothing but the plan: objects, motions, samples, touchpads, seeds; the last
//! changes fastest. Logs come in the order of the plan, those of one pattern by name.

use std::path::Path;
use std::sync::Arc;

use palpate_io::RigFile;

use crate::job::log_job::LogJob;
use crate::job::object::Object;
use crate::job::simulate_job::SimulateJob;
use crate::job::touchpad::Touchpads;
use crate::job::{Job, Source};
use crate::plan::bounded::{Positive, Share};
use crate::plan::many::Many;
use crate::plan::plan_error::{PlanError, PlanProblem};
use crate::plan::{
    EllipseLists, FourierLists, ObjectLists, OutlineLists, Plan, PlanKind, PolygonLists, ReconstructPlan, SimulatePlan,
    TouchpadLists,
};

/// A rig without errors, in place of the name of a file.
const EXACT_RIG: &str = "exact";

/// Most jobs of a sweep.
const MOST_JOBS: u64 = 1_000_000;

/// The jobs of a plan whose folder is `base`.
pub(crate) fn jobs(plan: &Plan, base: &Path) -> Result<Vec<Job>, PlanError> {
    let jobs = match &plan.kind {
        PlanKind::Simulate(plan) => simulations(plan, base),
        PlanKind::Reconstruct(plan) => logs(plan, base),
    };
    jobs.map_err(|(key, problem)| PlanError {
        file: plan.file.clone(),
        line: None,
        key: key.map(str::to_owned),
        problem,
    })
}

/// What is wrong, and the key it is about.
type Wrong = (Option<&'static str>, PlanProblem);

fn simulations(plan: &SimulatePlan, base: &Path) -> Result<Vec<Job>, Wrong> {
    let sample_counts: Vec<Option<u32>> = match &plan.samples {
        Some(samples) => samples.0.iter().map(|samples| Some(samples.0)).collect(),
        None => vec![None],
    };
    // Counted before anything is made: a short plan can ask for more than fits into memory.
    let objects = sum(object_counts(&plan.objects));
    let touchpads = sum(plan.touchpads.iter().map(touchpad_count));
    if objects == Some(0) {
        return Err((Some("objects"), PlanProblem::NoObjects));
    }
    if touchpads == Some(0) {
        return Err((Some("touchpads"), PlanProblem::NoTouchpads));
    }
    let others = product(&[plan.motions.0.len(), sample_counts.len()]);
    let count =
        [touchpads, others, Some(plan.trials.0)].into_iter().fold(objects, |count, some| count?.checked_mul(some?));
    if count.is_none_or(|count| count > MOST_JOBS) {
        return Err((None, PlanProblem::TooManyJobs(MOST_JOBS)));
    }
    let objects = self::objects(&plan.objects, base)?;
    let touchpads: Vec<Touchpads> = plan.touchpads.iter().flat_map(self::touchpads).collect();
    let rig = rig_file(plan.rig.as_deref(), base)?.map(|file| Box::new(file.rig));
    let mut jobs = Vec::new();
    for object in &objects {
        for &motion in &plan.motions.0 {
            for &samples in &sample_counts {
                for &touchpads in &touchpads {
                    for seed in plan.seed.0..plan.seed.0 + plan.trials.0 {
                        let object = object.clone();
                        let source = Source::Simulate(SimulateJob {
                            seed,
                            object,
                            motion,
                            samples,
                            touchpads,
                            rig: rig.clone(),
                        });
                        jobs.push(Job { source, reconstruct: (&plan.reconstruct).into(), score: plan.score.into() });
                    }
                }
            }
        }
    }
    Ok(jobs)
}

fn objects(lists: &ObjectLists, base: &Path) -> Result<Vec<Object>, Wrong> {
    let mut objects = Vec::new();
    if lists.mixed.is_some() {
        objects.push(Object::Mixed);
    }
    if let Some(named) = &lists.named {
        for &name in &named.name.0 {
            for radius_m in each_or_own(named.mean_radius_m.as_ref()) {
                let mean_radius_m = radius_m.map_or_else(|| name.0.usual_radius_m(), |radius| radius.0);
                objects.push(Object::Named { name, mean_radius_m });
            }
        }
    }
    if let Some(FourierLists { order, mean_radius_m, mass_offset }) = &lists.fourier {
        objects.extend(sized(order, mean_radius_m, mass_offset, |order, mean_radius_m, mass_offset| Object::Fourier {
            order: order.0,
            mean_radius_m,
            mass_offset,
        }));
    }
    if let Some(EllipseLists { axis_ratio, mean_radius_m, mass_offset }) = &lists.ellipse {
        objects.extend(sized(axis_ratio, mean_radius_m, mass_offset, |ratio, mean_radius_m, mass_offset| {
            Object::Ellipse { axis_ratio: ratio.0, mean_radius_m, mass_offset }
        }));
    }
    if let Some(PolygonLists { corners, mean_radius_m, mass_offset }) = &lists.polygon {
        objects.extend(sized(corners, mean_radius_m, mass_offset, |corners, mean_radius_m, mass_offset| {
            Object::Polygon { corners: corners.0, mean_radius_m, mass_offset }
        }));
    }
    if let Some(lists) = &lists.outline {
        objects.extend(outlines(lists, base)?);
    }
    Ok(objects)
}

/// The objects of the outlines that a plan names, by their files from the folder of the plan.
fn outlines(
    OutlineLists { file, mean_radius_m, mass_offset }: &OutlineLists,
    base: &Path,
) -> Result<Vec<Object>, Wrong> {
    let wrong = |error: String| (Some("objects.outline"), PlanProblem::Outline(error));
    let mut objects = Vec::new();
    for name in &file.0 {
        let read = palpate_io::read_outline(&base.join(name)).map_err(|error| wrong(error.to_string()))?;
        let shape = read.fit().map_err(|error| wrong(format!("{name}: {error}")))?.shape;
        for radius_m in each_or_own(mean_radius_m.as_ref()) {
            let scale = radius_m.map_or(1.0, |radius| radius.0 / shape.mean_radius_m());
            let shape = Arc::new(shape.scaled(scale));
            objects.extend(each_or_own(mass_offset.as_ref()).map(|offset| Object::Outline {
                file: name.clone(),
                shape: Arc::clone(&shape),
                mass_offset: offset.map(|offset| offset.0),
            }));
        }
    }
    Ok(objects)
}

/// Each of the values, or once that the object has its own.
fn each_or_own<T: Copy>(values: Option<&Many<T>>) -> impl Iterator<Item = Option<T>> {
    let given = values.into_iter().flat_map(|values| values.0.iter().copied().map(Some));
    given.chain(values.is_none().then_some(None))
}

/// How many objects there are of each kind; `None` for more than can be counted.
fn object_counts(lists: &ObjectLists) -> Vec<Option<u64>> {
    let ObjectLists { mixed, named, fourier, ellipse, polygon, outline } = lists;
    let mut counts = Vec::new();
    counts.extend(mixed.iter().map(|_| Some(1)));
    counts.extend(named.iter().map(|of| product(&[of.name.0.len(), or_one(of.mean_radius_m.as_ref())])));
    let sized =
        |first: usize, radii: &Many<Positive>, offsets: &Many<Share>| product(&[first, radii.0.len(), offsets.0.len()]);
    counts.extend(fourier.iter().map(|of| sized(of.order.0.len(), &of.mean_radius_m, &of.mass_offset)));
    counts.extend(ellipse.iter().map(|of| sized(of.axis_ratio.0.len(), &of.mean_radius_m, &of.mass_offset)));
    counts.extend(polygon.iter().map(|of| sized(of.corners.0.len(), &of.mean_radius_m, &of.mass_offset)));
    counts.extend(
        outline
            .iter()
            .map(|of| product(&[of.file.0.len(), or_one(of.mean_radius_m.as_ref()), or_one(of.mass_offset.as_ref())])),
    );
    counts
}

/// How many values there are, with one that is left out.
fn or_one<T>(values: Option<&Many<T>>) -> usize {
    values.map_or(1, |values| values.0.len())
}

/// Objects for each first value, each mean radius and each offset of the centre of mass.
fn sized<T>(
    first: &Many<T>,
    mean_radii_m: &Many<Positive>,
    mass_offsets: &Many<Share>,
    make: impl Fn(&T, f64, f64) -> Object,
) -> Vec<Object> {
    let mut objects = Vec::new();
    for first in &first.0 {
        let sizes = pairs(&mean_radii_m.0, &mass_offsets.0);
        objects.extend(sizes.map(|(radius, offset)| make(first, radius.0, offset.0)));
    }
    objects
}

fn product(lengths: &[usize]) -> Option<u64> {
    lengths.iter().try_fold(1_u64, |product, length| product.checked_mul(*length as u64))
}

fn sum(counts: impl IntoIterator<Item = Option<u64>>) -> Option<u64> {
    counts.into_iter().try_fold(0_u64, |sum, count| sum.checked_add(count?))
}

/// Each of one list with each of another.
fn pairs<'a, A, B>(first: &'a [A], second: &'a [B]) -> impl Iterator<Item = (&'a A, &'a B)> {
    first.iter().flat_map(move |a| second.iter().map(move |b| (a, b)))
}

fn touchpad_count(lists: &TouchpadLists) -> Option<u64> {
    let TouchpadLists { noise_sd_m, counts_per_inch, angle_noise_sd_rad, dropout, length_m } = lists;
    let optional = |list: &Option<Many<Positive>>| or_one(list.as_ref());
    product(&[
        noise_sd_m.0.len(),
        optional(counts_per_inch),
        angle_noise_sd_rad.0.len(),
        dropout.0.len(),
        optional(length_m),
    ])
}

pub(crate) fn touchpads(lists: &TouchpadLists) -> Vec<Touchpads> {
    let mut touchpads = vec![Touchpads::default()];
    touchpads = each(&touchpads, &lists.noise_sd_m.0, |pads, sd| pads.noise_sd_m = sd.0);
    if let Some(counts) = &lists.counts_per_inch {
        touchpads = each(&touchpads, &counts.0, |pads, counts| pads.counts_per_inch = Some(counts.0));
    }
    touchpads = each(&touchpads, &lists.angle_noise_sd_rad.0, |pads, sd| pads.angle_noise_sd_rad = sd.0);
    touchpads = each(&touchpads, &lists.dropout.0, |pads, share| pads.dropout = share.0);
    if let Some(lengths) = &lists.length_m {
        touchpads = each(&touchpads, &lengths.0, |pads, length| pads.length_m = Some(length.0));
    }
    touchpads
}

/// Each of the touchpads with each of the values.
fn each<T>(touchpads: &[Touchpads], values: &[T], set: impl Fn(&mut Touchpads, &T)) -> Vec<Touchpads> {
    pairs(touchpads, values)
        .map(|(pads, value)| {
            let mut pads = *pads;
            set(&mut pads, value);
            pads
        })
        .collect()
}

/// The rig that a plan names, by its file from the folder of the plan.
fn rig_file(name: Option<&str>, base: &Path) -> Result<Option<RigFile>, Wrong> {
    let read = |name: &str| match name {
        EXACT_RIG => Ok(RigFile::exact()),
        name => palpate_io::read_rig(&base.join(name)),
    };
    name.map(read).transpose().map_err(|error| (Some("rig"), PlanProblem::Rig(error.to_string())))
}

fn logs(plan: &ReconstructPlan, base: &Path) -> Result<Vec<Job>, Wrong> {
    const KEY: Option<&str> = Some("logs");
    let mut names: Vec<String> = Vec::new();
    for pattern in &plan.logs.0 {
        let wrong = |reason: String| (KEY, PlanProblem::Pattern { pattern: pattern.clone(), reason });
        let inside = Path::new(&glob::Pattern::escape(&base.to_string_lossy())).join(pattern);
        let found = glob::glob(&inside.to_string_lossy()).map_err(|error| wrong(error.msg.to_owned()))?;
        let before = names.len();
        for path in found {
            let path = path.map_err(|error| wrong(error.to_string()))?;
            // A truth is no log.
            if path.is_dir() || path.parent().is_some_and(|dir| dir.extension().is_some_and(|end| end == "truth")) {
                continue;
            }
            let path = path.strip_prefix(base).unwrap_or(&path);
            let name = path.to_str().ok_or_else(|| (KEY, PlanProblem::Name(path.display().to_string())))?;
            names.push(name.replace(std::path::MAIN_SEPARATOR, "/"));
        }
        if names.len() == before {
            return Err((KEY, PlanProblem::NoMatch(pattern.clone())));
        }
    }
    let rig = rig_file(plan.rig.as_deref(), base)?.map(|file| palpate_io::rig_comment(&file));
    let mut seen = std::collections::HashSet::new();
    names.retain(|name| seen.insert(name.clone()));
    Ok(names
        .into_iter()
        .map(|name| Job {
            source: Source::Log(LogJob::new(base, name, rig.clone())),
            reconstruct: (&plan.reconstruct).into(),
            score: plan.score.into(),
        })
        .collect())
}
