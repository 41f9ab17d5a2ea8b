//! `palpate calibrate`: one rig from any number of its logs.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use palpate::Log;
use palpate::calibrate::{Contribution, RigCalibration, calibrate, calibrate_with_disc};
use palpate::reconstruct::{ConstantEstimate, ReconstructOptions};
use palpate::sensor::{CalibrationConstant, Rig};
use palpate_io::RigFile;

use crate::terminal::{Ending, Failure, Terminal, print};
use crate::values;

const AFTER_HELP: &str = "\
Every log may hold another object, which need not be known: a log tells where the zeros of pads and angles are, one scale against the
other, one surface against the other, and the clock. Two numbers no log can tell: what both scales have in common (the size of every
object), and what both surface offsets have in common. Measure these with a calliper, or log a disc of known radius (--known-radius-mm).

The rig file holds every constant with its standard deviation, for `palpate reconstruct --rig`. A log that is not certified counts for
nothing; one that is at odds with the others is named: a pad that was mounted anew, an encoder that slipped.

Examples:
  palpate calibrate monday/*.csv -o rig.toml                        what is known before: the default tolerances
  palpate calibrate monday/*.csv --rig rig.toml -o better.toml      what is known before: rig.toml, with its signs and directions
  palpate calibrate disc.csv --known-radius-mm 20 -o rig.toml       a disc that was carried about: scale and surface offset too

Exit codes: 0 calibrated;  3 no log counts, and nothing was written, or logs are at odds;  2 bad input or usage;  1 anything else.";

/// Calibrate pads and encoders from their logs
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Palm logs of the rig, CSV files
    #[arg(value_name = "LOG.csv", required = true)]
    logs: Vec<PathBuf>,
    /// The rig file to write
    #[arg(short, long = "out", value_name = "RIG.toml")]
    out: PathBuf,
    /// What is known of the rig beforehand [default: what the logs say in a comment `# rig:`, or else the default tolerances]
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// The logs are of a disc of this radius, mm
    #[arg(long, value_name = "MM", value_parser = values::positive)]
    known_radius_mm: Option<f64>,
    /// Print what was found as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

/// Reads the logs, calibrates, writes the rig file and says what each log told.
pub fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let terminal = Terminal::new(arguments.quiet);
    if arguments.out.is_dir() {
        return Err(Failure::Input(format!(
            "{}: this is a folder; give the rig file to write",
            arguments.out.display()
        )));
    }
    let (logs, before) = read(arguments, &terminal)?;
    let found = match arguments.known_radius_mm {
        Some(radius_mm) => calibrate_with_disc(&logs, 1e-3 * radius_mm, &before.rig)
            .map_err(|error| Failure::Input(error.to_string()))?,
        None => {
            let progress = terminal.progress();
            let options = ReconstructOptions::default().with_rig(before.rig).with_sensor_sd_m(before.reading_sd_m());
            calibrate(&logs, &options, &|step| progress.update(step))?
        }
    };
    let is_drifting = found.drift().is_some();
    if found.used() > 0 {
        let now = RigFile { rig: found.rig, ..before };
        let names: Vec<String> = arguments.logs.iter().map(|path| name(path)).collect();
        let text = format!("# Calibrated by {} of {} logs: {}\n", found.used(), logs.len(), names.join(", "));
        palpate_io::write_whole(&arguments.out, (text + &palpate_io::rig_to_toml(&now)).as_bytes())?;
    }
    if arguments.json {
        let json = serde_json::to_string_pretty(&found).map_err(|error| Failure::Other(error.to_string()))?;
        print(&json)?;
    } else {
        terminal.say(&told(&found, &before.rig, &arguments.logs, &arguments.out))?;
    }
    Ok(if found.used() > 0 && !is_drifting { Ending::Success } else { Ending::NotCertified })
}

/// The logs, and what is known of their rig.
fn read(arguments: &Arguments, terminal: &Terminal) -> Result<(Vec<Log>, RigFile), Failure> {
    let mut logs = Vec::with_capacity(arguments.logs.len());
    let mut known = arguments.rig.as_deref().map(palpate_io::read_rig).transpose()?;
    for path in &arguments.logs {
        let file = match &known {
            Some(rig) if arguments.rig.is_some() => palpate_io::read_log_as(path, &rig.conventions)?,
            _ => {
                let (file, said) = palpate_io::read_log_with_rig(path)?;
                // A log without errors is one of any rig.
                known = known.or(said.filter(|said| said.rig != Rig::default()));
                file
            }
        };
        file.notes.iter().for_each(|note| terminal.note(&format!("{}: {note}", path.display())));
        logs.push(file.log);
    }
    Ok((logs, known.unwrap_or_default()))
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().chars().filter(|c| !c.is_control()).collect()
}

/// A constant is told by the logs where its standard deviation is below this share of what it was; at most this leaves it open.
const TOLD: f64 = 0.3;

fn told(found: &RigCalibration, before: &Rig, logs: &[PathBuf], out: &Path) -> String {
    let mut text = match found.used() {
        0 => "NOT calibrated: no log counts, nothing was written".to_owned(),
        used => format!("calibrated by {used} of {} logs: {}", logs.len(), out.display()),
    };
    let open: Vec<&ConstantEstimate> = found.constants.iter().filter(|constant| constant.prior_sd > 0.0).collect();
    if found.used() > 0 {
        text += "\n\n  constant                            value ± sd          before";
        for constant in &open {
            let Some(about) = CalibrationConstant::named(&constant.name) else { continue };
            let CalibrationConstant { label, unit, units_per_si, .. } = about;
            let [value, sd, stated, prior] =
                [constant.value, constant.sd, constant.stated, constant.prior_sd].map(|value| units_per_si * value);
            // Writing to a string does not fail.
            let _ = write!(text, "\n  {label:<33} {value:>8.4} ± {sd:.4} {unit:<4}  {stated:.3} ± {prior:.3} {unit}");
        }
        let (size, offset_mm) = (100.0 * found.rig.size_sd(), 1e3 * found.rig.offset_sd_m());
        let (size_before, offset_before_mm) = (100.0 * before.size_sd(), 1e3 * before.offset_sd_m());
        let _ = write!(
            text,
            "\n  {:<33} {size:.2} % and {offset_mm:.3} mm all around (before: {size_before:.2} % and {offset_before_mm:.3} mm)",
            "size of every object, sd"
        );
    }
    text += "\n\n  log                          counts  left in the contacts";
    for (path, log) in logs.iter().zip(&found.logs) {
        let counts = if log.is_used { "yes" } else { "no" };
        let _ = write!(text, "\n  {:<28} {counts:<6}  {}", name(path), residuals(log));
    }
    if let Some((place, drift, about)) =
        found.drift().and_then(|(place, drift)| Some((place, drift, CalibrationConstant::named(&drift.constant)?)))
    {
        let CalibrationConstant { label, unit, units_per_si, .. } = about;
        let _ = write!(
            text,
            "\n\n  {} is at odds with the others: {label} differs by {:.3} {unit} ({:.0} of its standard deviations). Was something mounted \
             anew? Calibrate the logs before and after apart.",
            logs.get(place).map(|path| name(path)).unwrap_or_default(),
            units_per_si * drift.difference,
            drift.sds.abs()
        );
    }
    let untold = open.iter().filter(|constant| constant.sd > TOLD * constant.prior_sd);
    let untold: Vec<&CalibrationConstant> =
        untold.filter_map(|constant| CalibrationConstant::named(&constant.name)).collect();
    if found.used() > 0 && !untold.is_empty() {
        text += "\n\n  What is not told yet:";
        for (index, about) in untold.iter().enumerate() {
            // Constants that one motion tells stand together.
            if untold[..index].iter().any(|other| other.motion == about.motion) {
                continue;
            }
            let alike: Vec<&str> =
                untold.iter().filter(|other| other.motion == about.motion).map(|other| other.label).collect();
            let _ = write!(text, "\n  - {}: {}", alike.join(", "), about.motion);
        }
    }
    text
}

/// What a log left, before and after; or why it does not count.
fn residuals(log: &Contribution) -> String {
    let mm = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{:.4}", 1e3 * value));
    if let Some(failure) = &log.failure {
        return failure.clone();
    }
    let left = format!("{} mm before, {} mm now", mm(log.residual_before_m), mm(log.residual_after_m));
    match log.verdict.doubts.first() {
        Some(doubt) if !log.is_used => format!("{left}; {doubt}"),
        _ => left,
    }
}
