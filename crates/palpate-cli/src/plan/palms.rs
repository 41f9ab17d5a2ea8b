//! Motions of two palms: once around without a jump, or as far as can be.

use palpate::palms::PalmPair;
use palpate::plan::{PalmFriction, PlanError, plan_turn_with_friction};
use palpate::reconstruct::Reconstructor;
use palpate::sensor::Touchpad;
use palpate::shape::SupportFunction;
use palpate_io::{PalmCourse, RigFile};

use super::Arguments;
use crate::log_source::LogSource;
use crate::simulate::{USUAL_DURATION_S, USUAL_RATE_HZ, limits, palm_length_m};
use crate::terminal::{Ending, Failure, Terminal};

/// For the shape of a palm log, and the friction that the log tells.
pub fn of_log(arguments: &Arguments, log: LogSource, terminal: &Terminal) -> Result<Ending, Failure> {
    let (file, rig) = log.read(arguments.rig.as_deref(), arguments.calibrated, None)?;
    file.notes.iter().for_each(|note| terminal.note(note));
    let progress = terminal.progress();
    let tell = |step| progress.update(step);
    let reconstructor = Reconstructor::new().sensor_sd_m(rig.reading_sd_m()).rig(rig.rig);
    let found = reconstructor.progress(&tell).run_or_name_mistake(&file.log)?;
    drop(progress);
    let told = found.friction.as_ref().map(|friction| PalmFriction {
        coefficients: friction.coefficients,
        coefficient_sds: friction.coefficient_sds,
    });
    let palms = file.log.samples.first().map_or(PalmPair::hinged(0.0, 0.0), |sample| sample.palms);
    planned(arguments, &found.shape, told, [palms.base1_m, palms.base2_m], &rig, terminal)?;
    if found.is_certified() {
        return Ok(Ending::Success);
    }
    terminal.note(&format!("the shape of the log is not certified ({}): the plan holds for it alone", found.verdict));
    Ok(Ending::NotCertified)
}

/// For a known shape.
pub fn of_shape(arguments: &Arguments, shape: &SupportFunction, terminal: &Terminal) -> Result<Ending, Failure> {
    let rig = arguments.rig.as_deref().map(palpate_io::read_rig).transpose()?.unwrap_or_else(RigFile::exact);
    let bases_m = rig.conventions.palms.map(|palm| palm.base_m.map(Option::unwrap_or_default));
    planned(arguments, shape, None, bases_m, &rig, terminal)?;
    Ok(Ending::Success)
}

fn planned(
    arguments: &Arguments,
    shape: &SupportFunction,
    told: Option<PalmFriction>,
    [base1_m, base2_m]: [[f64; 2]; 2],
    rig: &RigFile,
    terminal: &Terminal,
) -> Result<(), Failure> {
    let stated = rig.pads.map(|pad| pad.friction);
    let of_rig = stated.iter().any(Option::is_some).then(|| PalmFriction::known(stated.map(Option::unwrap_or_default)));
    let friction = arguments.friction.map(PalmFriction::known).or(told).or(of_rig);
    let friction = friction.unwrap_or(PalmFriction::known([0.0; 2]));
    let length_m = arguments.palm_length_m().or(palm_length_m(rig)).unwrap_or(f64::INFINITY);
    let limits = limits(&Touchpad { length_m, ..Touchpad::ideal() });
    let duration_s = arguments.duration_s.unwrap_or(USUAL_DURATION_S);
    let progress = terminal.progress();
    progress.say("planning palms that carry the object round");
    let planned = plan_turn_with_friction(shape, &limits, duration_s, &friction).map_err(refused)?;
    drop(progress);
    // Where an object rests depends on the angles of the palms alone.
    let motion = planned.motion.with_bases(base1_m, base2_m);
    let palms = motion.sample(arguments.rate_hz.unwrap_or(USUAL_RATE_HZ))?;
    let rows = palms.len();
    let course = PalmCourse { palms, start_psi_rad: Some(planned.start_psi_rad) };
    palpate_io::write_palm_course(&arguments.out, &course, &arguments.metadata())?;
    let turn =
        if planned.full_turn { "turns the object all the way around" } else { "turns the object there and back" };
    terminal.say(&format!(
        "{}: {rows} rows in {duration_s} s; it {turn} without a jump\n  feels   {:.0} % of the boundary\n  start   let the object go at psi = {:.4} rad",
        arguments.out.display(),
        100.0 * planned.coverage,
        planned.start_psi_rad
    ))
}

fn refused(error: PlanError) -> Failure {
    Failure::Input(format!("{error}; try another --palm-length-mm, --com-mm or --friction"))
}
