//! Strokes of a pivoting grasp, each where it feels most of what those before it did not.

use palpate::pivot::{
    CenterOfMassEstimate, HeldObject, PadPose, PivotOptions, PivotPosterior, PivotReconstruction, PivotRig,
    PivotSimulateError, PivotSimulateOptions, PlannedStrokes, StrokeLimits, plan_next_strokes, plan_strokes,
    reconstruct_with_posterior,
};
use palpate::sensor::Touchpad;
use palpate::shape::SupportFunction;

use super::Arguments;
use crate::log_source::LogSource;
use crate::strokes;
use crate::terminal::{Ending, Failure, Terminal};

/// By what a log of strokes leaves open of the shape.
pub fn of_log(arguments: &Arguments, log: LogSource, terminal: &Terminal) -> Result<Ending, Failure> {
    let file = log.read_strokes(None)?;
    file.notes.iter().for_each(|note| terminal.note(note));
    // `--rig pivot` says no more than the columns of the log.
    let rig_file = arguments.rig.as_deref().filter(|path| *path != std::path::Path::new(super::PIVOT));
    let rig = strokes::rig(rig_file, arguments.calibrated, file.rig)?;
    let progress = terminal.progress();
    progress.say("reconstructing the strokes so far");
    let (found, posterior) = reconstruct_with_posterior(&file.log, &PivotOptions::new(rig))?;
    drop(progress);
    let samples = &file.log.samples;
    let feet_m: Vec<f64> =
        samples.iter().map(|sample| rig.pad.along_and_above(sample.pivot_x_m, sample.pivot_y_m)[0]).collect();
    let farthest_m = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NEG_INFINITY, f64::max);
    let along_m = [-farthest_m(&mut feet_m.iter().map(|foot_m| -foot_m)), farthest_m(&mut feet_m.iter().copied())];
    let felt_m = farthest_m(&mut samples.iter().filter_map(|sample| sample.s_m));
    let options = PivotSimulateOptions {
        rig: PivotRig::exact(PadPose { tilt_rad: rig.pad.tilt_rad + found.calibration.tilt_rad, ..rig.pad }),
        touchpad: Touchpad { length_m: arguments.palm_length_m().unwrap_or(felt_m), ..Touchpad::ideal() },
        center_of_mass_m: center_of_mass_m(&found, terminal)?,
        friction: arguments.friction.map_or(HeldObject::USUAL_FRICTION, |[friction, _]| friction),
        ..PivotSimulateOptions::default()
    };
    planned(arguments, along_m, terminal, |limits| plan_next_strokes(&found, &posterior, &options, limits))?;
    if found.is_certified() {
        return Ok(Ending::Success);
    }
    let doubts: Vec<String> = found.doubts.iter().map(ToString::to_string).collect();
    terminal.note(&format!("the shape of the log is not certified ({}): the plan is a best guess", doubts.join("; ")));
    Ok(Ending::NotCertified)
}

/// For a known shape about its centre of mass.
pub fn of_shape(arguments: &Arguments, shape: &SupportFunction, terminal: &Terminal) -> Result<Ending, Failure> {
    let length_m = arguments.palm_length_m().unwrap_or(f64::INFINITY);
    let pivot_m = arguments.pivot_mm.map(|pivot| pivot.map(|mm| 1e-3 * mm));
    let touchpad = Touchpad { length_m, ..Touchpad::ideal() };
    let held = HeldObject::new(shape, pivot_m, touchpad, arguments.friction.map(|[friction, _]| friction));
    let posterior = PivotPosterior::known(&held.about_pivot);
    planned(arguments, held.usual_along_m(), terminal, |limits| plan_strokes(&posterior, &held.options, limits))?;
    Ok(Ending::Success)
}

/// Centre of mass from the pivot in the frame of a result: how a lifted object comes to rest depends on it.
fn center_of_mass_m(found: &PivotReconstruction, terminal: &Terminal) -> Result<[f64; 2], Failure> {
    let Some(CenterOfMassEstimate { direction_rad, distance_m, .. }) = found.center_of_mass else {
        let message = "the log does not tell where the centre of mass is, and so not at which angle the next stroke will begin; let the \
                       object hang at rest before each stroke";
        return Err(Failure::Input(message.to_owned()));
    };
    let distance_m = distance_m.unwrap_or_else(|| {
        let usual_m = HeldObject::PIVOT_SHARE * found.shape.mean_radius_m();
        terminal.note(&format!(
            "the centre of mass is taken to be {:.1} mm from the pivot; a period of swinging in the log (swing_period_s) tells",
            1e3 * usual_m
        ));
        usual_m
    });
    let (sin, cos) = direction_rad.sin_cos();
    Ok([distance_m * cos, distance_m * sin])
}

fn planned(
    arguments: &Arguments,
    usual_along_m: [f64; 2],
    terminal: &Terminal,
    plan: impl FnOnce(&StrokeLimits) -> Result<PlannedStrokes, PivotSimulateError>,
) -> Result<(), Failure> {
    let along_m = arguments.along_mm.map_or(usual_along_m, |along| along.map(|mm| 1e-3 * mm));
    let limits = StrokeLimits {
        along_m,
        longest_m: arguments.longest_mm.map_or(2.0 * (along_m[1] - along_m[0]), |mm| 1e-3 * mm),
        press: arguments.press.unwrap_or(HeldObject::PRESS),
        most_strokes: arguments.most_strokes.map_or(StrokeLimits::default().most_strokes, usize::from),
    };
    let progress = terminal.progress();
    progress.say("trying strokes");
    let planned = plan(&limits)?;
    drop(progress);
    let Some(coverage) = planned.coverage.last() else {
        let message = "no stroke within these limits feels anything; let the pivot go further (--along-mm, --longest-mm), or give the length of the pad \
                       (--palm-length-mm)";
        return Err(Failure::Input(message.to_owned()));
    };
    palpate_io::write_planned_strokes(&arguments.out, &planned, &arguments.metadata())?;
    let count = planned.strokes.len();
    let mut lines = vec![format!(
        "{}: {count} stroke{}, to feel {:.0} % of the boundary",
        arguments.out.display(),
        if count == 1 { "" } else { "s" },
        100.0 * coverage
    )];
    let mut before = 0.0;
    for (index, (stroke, after)) in planned.strokes.iter().zip(&planned.coverage).enumerate() {
        let places: Vec<String> = stroke.along_m.iter().map(|along_m| format!("{:.1}", 1e3 * along_m)).collect();
        lines.push(format!(
            "  {:<3} {} mm along the pad: {:.0} %{}, {:.0} % in all",
            index + 1,
            places.join(" to "),
            100.0 * (after - before),
            if index == 0 { "" } else { " more" },
            100.0 * after
        ));
        before = *after;
    }
    terminal.say(&lines.join("\n"))
}
