//! `palpate reconstruct`: a palm log in, a result folder out.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use palpate::compare::{compare, true_support};
use palpate::mechanics::STANDARD_GRAVITY_M_PER_S2;
use palpate::pivot::PivotRig;
use palpate::reconstruct::{FoundSymmetry, Method, Reconstructor, diagnostics, measured_forces};
use palpate::sensor::CalibrationConstant;
use palpate::{Reconstruction, Truth};
use palpate_io::{ConstantSummary, FrictionSummary, LogFile, Summary, TruthSummary};
use palpate_report::{ReportInput, TruthOverlay};

use crate::log_source::LogSource;
use crate::strokes;
use crate::terminal::{Ending, Failure, Terminal, print};
use crate::values;

const AFTER_HELP: &str = "\
A log is a CSV file, or one compressed by gzip, with the columns time_s, phi1_rad, phi2_rad, s1_m and s2_m, in any order and in other
units if the names say so (s1_mm, \"phi1 (deg)\", time_ms); what spreadsheets write, with semicolons and decimal commas, is read as well.
An empty cell in s1 or s2 means no contact. Optional: s1_sd_m and s2_sd_m
(standard deviations), base1_x_m, base1_y_m, base2_x_m and base2_y_m (base points of the palms; default: both in the origin),
force1_n and force2_n.

DIR receives report.html (open it first), shape.csv, motion.csv and summary.json. Where several objects explain the log equally well,
DIR/alternatives holds the others. An earlier result in DIR is replaced; a folder that holds anything else is left alone. Of several logs,
a.csv goes to DIR/a, b.csv to DIR/b; one that cannot be used does not stop the others, and the exit code is the worst.

A log with the columns time_s, pivot_x_m, pivot_y_m and s_m is one of the other rig of the paper: an arm holds the object at a pivot and drags
it over one pad. DIR then receives shape.csv (about the pivot), motion.csv and summary.json, and --rig takes a file with the tables pad,
calibration and tolerances (docs/formats.md).

The object may jump from one resting pose to another; the segments of the motion between the jumps are arranged.

Examples:
  palpate reconstruct trial.csv                          writes trial.palpate/
  palpate reconstruct trial.csv -o out/trial
  palpate reconstruct monday/*.csv -o out                writes out/NAME for each of them
  logger | palpate reconstruct - -o trial                a log from standard input
  palpate reconstruct trial.csv --json | jq .certified
  palpate reconstruct trial.csv --animation trial.gif    the motion, for slides
  palpate reconstruct trial.mcap                         a recording of `palpate record`
  palpate reconstruct bag.mcap --map topics.toml         a ROS 2 bag
  palpate reconstruct trial.csv --rig rig.toml           what you know of pads and encoders; the rest is estimated with the shape
  palpate reconstruct trial.csv --calibrated             a rig without errors: readings are taken as they are
  palpate reconstruct egg.csv --truth egg.truth          compares with what is known, after the fact
  palpate reconstruct egg.csv --method ode               as Moll & Erdmann (2001) did it, to compare; never certified

Exit codes: 0 certified;  3 a result that is not certified (reasons in summary.json and in the report);  2 bad input or usage, nothing
written;  1 anything else.";

/// Find shape, motion and centre of mass from palm logs
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP, allow_negative_numbers = true)]
pub struct Arguments {
    /// Palm logs, CSV files (.csv or .csv.gz), or MCAP files, recorded by `palpate record` or, with --map, by ROS 2; - for standard input
    #[arg(value_name = "LOG.csv", required = true)]
    logs: Vec<PathBuf>,
    /// Which topics and fields of an MCAP file hold what, a TOML file (docs/formats.md)
    #[arg(long, value_name = "TOPICS.toml")]
    map: Option<PathBuf>,
    /// Folder for the result, made if missing; of several logs, for a folder with the result of each [default: the log's name with .palpate
    /// instead of .csv]
    #[arg(short, long = "out", value_name = "DIR")]
    out: Option<PathBuf>,
    /// Folder with the true shape.csv and motion.csv, to measure the errors of the result. The reconstruction does not see it
    #[arg(long, value_name = "DIR")]
    truth: Option<PathBuf>,
    /// Number of harmonics of the support function, 2 to 64 [default: chosen by the evidence]
    #[arg(long, value_name = "K", value_parser = values::harmonics)]
    harmonics: Option<usize>,
    /// Standard deviation of the contact positions, mm [default: as the log states, or else estimated from it]
    #[arg(long, value_name = "MM", value_parser = values::positive)]
    sensor_sd_mm: Option<f64>,
    /// What is known of the rig, a file as `palpate rig --template` prints it: constants that are not exact are estimated with the shape
    /// [default: what the log says in a comment `# rig:`, or else what that template says: an ordinary rig that nobody calibrated]
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// Take readings as they are: the rig is exact
    #[arg(long, conflicts_with = "rig")]
    calibrated: bool,
    /// How to reconstruct; only likelihood has error bars and a certificate
    #[arg(long, value_parser = method(), default_value_t)]
    method: Method,
    /// Leave out boundary that was felt fewer than this many times: it counts as never felt
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..))]
    min_touches: u32,
    /// Write DIR/diagnostics.csv too: generalised contact support functions and curvature at the contacts, for each sample
    #[arg(long)]
    diagnostics: bool,
    /// Write the motion as an animated GIF too; of several logs in one call, none
    #[arg(long, value_name = "FILE.gif")]
    animation: Option<PathBuf>,
    /// Threads to work with [default: as many as there are processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print summary.json on standard output instead of a few lines of text
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

/// Takes the name of a method, and says what each of them is.
fn method() -> impl TypedValueParser<Value = Method> {
    let known = Method::ALL.map(|method| {
        PossibleValue::new(method.name()).help(match method {
            Method::Likelihood => "Maximum likelihood over all samples",
            Method::Ode => {
                "The differential equations 19 to 21 of Moll & Erdmann (2001), by an Adams-Bashforth-Moulton method"
            }
            Method::Quadrature => "The same motion from closed forms, by quadrature",
        })
    });
    PossibleValuesParser::new(known).try_map(|name| name.parse::<Method>())
}

/// Reads, reconstructs, writes, and says how it went: for one log, or for several in turn.
pub fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let terminal = Terminal::new(arguments.quiet);
    let sources: Vec<LogSource> = arguments.logs.iter().map(|path| LogSource(path)).collect();
    let several = sources.len() > 1;
    let result_dirs = result_dirs(&sources, arguments.out.as_deref())?;
    if several && arguments.truth.is_some() {
        return Err(Failure::Input("--truth belongs to one log; reconstruct that one by itself".to_owned()));
    }
    if let Some(file) = &arguments.animation {
        check_animation(file, several)?;
    }
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.into())
            .build_global()
            .map_err(|error| Failure::Other(format!("{threads} threads cannot be started: {error}")))?;
    }
    if !several {
        return one(arguments, sources[0], &result_dirs[0], &terminal);
    }
    let mut worst = Ending::Success;
    for (source, out) in sources.into_iter().zip(&result_dirs) {
        if !arguments.json {
            terminal.say(&format!("{}:", source.0.display()))?;
        }
        worst = worst.max(one(arguments, source, out, &terminal).unwrap_or_else(|failure| Terminal::tell(&failure)));
    }
    Ok(worst)
}

/// The folder for the result of each log, no two the same.
fn result_dirs(sources: &[LogSource], out: Option<&Path>) -> Result<Vec<PathBuf>, Failure> {
    if out.is_none() && sources.iter().any(|source| source.is_standard_input()) {
        return Err(Failure::Input("standard input has no name for its result; give a folder with -o DIR".to_owned()));
    }
    let dirs: Vec<PathBuf> = match (out, sources) {
        (Some(out), [_]) => vec![out.to_owned()],
        (Some(out), _) => sources.iter().map(|source| out.join(source.stem())).collect(),
        (None, _) => sources.iter().map(|source| source.result_dir()).collect(),
    };
    for (index, dir) in dirs.iter().enumerate() {
        if let Some(earlier) = dirs[..index].iter().position(|other| other == dir) {
            let [first, second] = [earlier, index].map(|index| sources[index].0.display());
            let message = format!(
                "{first} and {second} would both be written to {}; reconstruct them in two calls",
                dir.display()
            );
            return Err(Failure::Input(message));
        }
    }
    Ok(dirs)
}

/// A log of strokes of the other rig; what is asked of palms alone is refused.
fn of_strokes(arguments: &Arguments, source: LogSource, out: &Path, terminal: &Terminal) -> Result<Ending, Failure> {
    let of_palms = [
        (arguments.method != Method::default(), "--method"),
        (arguments.min_touches > 1, "--min-touches"),
        (arguments.diagnostics, "--diagnostics"),
        (arguments.animation.is_some(), "--animation"),
    ];
    if let Some((_, option)) = of_palms.iter().find(|(given, _)| *given) {
        let log = source.0.display();
        return Err(Failure::Input(format!(
            "{log} is a log of a pivoting grasp, for which there is no {option}; leave it out"
        )));
    }
    let file = source.read_strokes(arguments.map.as_deref())?;
    file.notes.iter().for_each(|note| terminal.note(note));
    let rig = strokes::rig(arguments.rig.as_deref(), arguments.calibrated, file.rig)?;
    let reading_sd_m = arguments.sensor_sd_mm.map(|sd| 1e-3 * sd).or(rig.reading_sd_m);
    let truth = arguments.truth.as_deref().map(palpate_io::read_truth).transpose()?;
    palpate_io::check_strokes_target(out)?;
    let asked = strokes::Reconstruct {
        log: &file.log,
        title: &source.file_name(),
        out: Some(out),
        rig: PivotRig { reading_sd_m, ..rig },
        truth: truth.as_ref(),
        harmonics: arguments.harmonics,
    };
    let summary = asked.run()?;
    if arguments.json {
        let json = summary.to_json().map_err(|error| Failure::Other(format!("summary.json: {error}")))?;
        print(json.trim_end())?;
    } else {
        terminal.say(&strokes::told(&summary, Some(out)))?;
    }
    Ok(if summary.certified { Ending::Success } else { Ending::NotCertified })
}

/// The same for one log.
fn one(arguments: &Arguments, source: LogSource, out: &Path, terminal: &Terminal) -> Result<Ending, Failure> {
    if source.is_strokes(arguments.map.as_deref()) {
        return of_strokes(arguments, source, out, terminal);
    }
    let (file, rig) = source.read(arguments.rig.as_deref(), arguments.calibrated, arguments.map.as_deref())?;
    let truth = arguments.truth.as_deref().map(|dir| read_truth(dir, &file)).transpose()?;
    file.notes.iter().for_each(|note| terminal.note(note));
    let name = source.file_name();
    let job = Job {
        file: &file,
        name: Some(&name),
        title: &name,
        truth: truth.as_ref(),
        reconstructor: Reconstructor::new()
            .harmonics(arguments.harmonics)
            .sensor_sd_m(arguments.sensor_sd_mm.map(|sd| 1e-3 * sd).or(rig.reading_sd_m()))
            .method(arguments.method)
            .rig(rig.rig),
        min_touches: arguments.min_touches,
        diagnostics: arguments.diagnostics,
        animation: arguments.animation.as_deref(),
        out,
    };
    let summary = solve(&job, terminal)?;
    if arguments.json {
        let json = summary.to_json().map_err(|error| Failure::Other(format!("summary.json: {error}")))?;
        print(json.trim_end())?;
    } else {
        terminal.say(&told(&summary, out))?;
    }
    Ok(if summary.certified { Ending::Success } else { Ending::NotCertified })
}

/// A truth with as many poses as the log has samples.
fn read_truth(dir: &Path, file: &LogFile) -> Result<Truth, Failure> {
    let truth = palpate_io::read_truth(dir)?;
    let (poses, samples) = (truth.motion.len(), file.log.samples.len());
    if poses != samples {
        return Err(Failure::Input(format!(
            "{}: motion.csv and the log differ in length ({poses} against {samples} rows); give the truth of this log",
            dir.display()
        )));
    }
    true_support(&truth).map_err(|error| Failure::Input(format!("{}: {error}", dir.join("shape.csv").display())))?;
    Ok(truth)
}

/// A log to be reconstructed, and where to.
pub struct Job<'a> {
    /// The log as it was read.
    pub file: &'a LogFile,
    /// File name of the log, where it has one.
    pub name: Option<&'a str>,
    /// Heading of the report.
    pub title: &'a str,
    /// What is known of the object, to compare with when all is done.
    pub truth: Option<&'a Truth>,
    /// How to reconstruct.
    pub reconstructor: Reconstructor<'static>,
    /// Boundary felt fewer times counts as never felt.
    pub min_touches: u32,
    /// Whether to write the diagnostics of the contacts too.
    pub diagnostics: bool,
    /// Where to write the motion as an animation.
    pub animation: Option<&'a Path>,
    /// The result folder.
    pub out: &'a Path,
}

/// Reconstructs and writes the result folder.
pub fn solve(job: &Job, terminal: &Terminal) -> Result<Summary, Failure> {
    palpate_io::check_result_target(job.out)?;
    let started = Instant::now();
    let progress = terminal.progress();
    let tell = |step| progress.update(step);
    let mut reconstruction = job.reconstructor.clone().progress(&tell).run_or_name_mistake(&job.file.log)?;
    drop(progress);
    let log = job.reconstructor.log_as_read(&job.file.log, &reconstruction);
    reconstruction.prune(job.min_touches);
    let mut summary = Summary::new(&reconstruction, started.elapsed().as_secs_f64());
    summary.log = job.name.map(str::to_owned);
    summary.notes.iter().for_each(|note| terminal.note(note));
    summary.notes = job.file.notes.iter().chain(&summary.notes).cloned().collect();
    let forces = measured_forces(&log, &reconstruction);
    summary = summary.with_forces(forces.as_ref());
    summary.truth = job.truth.and_then(|truth| errors(&reconstruction, truth, terminal));
    let overlay = job.truth.zip(summary.truth).map(|(truth, errors)| TruthOverlay { truth, errors: errors.into() });
    let command = command_line();
    let input = ReportInput {
        title: job.title,
        log: &log,
        reconstruction: &reconstruction,
        truth: overlay,
        seconds: summary.seconds,
        command: Some(&command),
        version: &summary.version,
    };
    let report = palpate_report::page(&input);
    if job.diagnostics {
        let diagnostics = diagnostics(&log, &reconstruction);
        palpate_io::write_result_with_diagnostics(job.out, &reconstruction, &summary, &report, &diagnostics)?;
    } else {
        palpate_io::write_result(job.out, &reconstruction, &summary, &report)?;
    }
    if let Some(file) = job.animation {
        write_animation(file, &input, terminal)?;
    }
    Ok(summary)
}

/// Whether an animation can be written to a file.
#[cfg(feature = "paper")]
fn check_animation(file: &Path, several_logs: bool) -> Result<(), Failure> {
    if several_logs {
        return Err(Failure::Input("--animation shows one log; reconstruct that one by itself".to_owned()));
    }
    if !file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gif")) {
        let message = format!("{}: an animation is a GIF file; let its name end in .gif", file.display());
        return Err(Failure::Input(message));
    }
    Ok(())
}

/// Writes the motion as a GIF.
#[cfg(feature = "paper")]
fn write_animation(file: &Path, input: &ReportInput, terminal: &Terminal) -> Result<(), Failure> {
    match palpate_report::animation(input) {
        Ok(gif) => palpate_io::write_whole(file, &gif)?,
        Err(error) => terminal.note(&format!("no animation: {error}")),
    }
    Ok(())
}

#[cfg(not(feature = "paper"))]
fn write_animation(_: &Path, _: &ReportInput, _: &Terminal) -> Result<(), Failure> {
    Err(crate::absent::failure("animations"))
}

#[cfg(not(feature = "paper"))]
fn check_animation(_: &Path, _: bool) -> Result<(), Failure> {
    Err(crate::absent::failure("animations"))
}

/// The summary in a few lines.
pub fn told(summary: &Summary, out: &Path) -> String {
    let verdict = match (summary.certified, summary.com_certified) {
        (true, true) => "certified: shape, motion and centre of mass",
        (true, false) => "certified: shape and motion, but not the centre of mass",
        _ => "NOT certified",
    };
    let mut lines = vec![verdict.to_string()];
    for doubt in summary.verdict().doubts {
        lines.push(format!("  - {doubt}"));
        let next = doubt.next_step();
        if !next.is_empty() {
            lines.push(format!("    {next} ({})", doubt.docs()));
        }
    }
    let jumps = match summary.jumps.len() {
        0 => "no jump".to_string(),
        1 => "1 jump".to_string(),
        count => format!("{count} jumps"),
    };
    lines.push(format!(
        "  felt    {:.0} % of the boundary in {} samples, {jumps}; sensor noise {} mm",
        100.0 * summary.coverage,
        summary.samples,
        three_digits(1e3 * summary.sensor_sd_m)
    ));
    if summary.symmetry.order > 1 || summary.symmetry.mirror {
        lines.push(format!("  is      {}", FoundSymmetry::from(summary.symmetry)));
    }
    if summary.size_sd > 0.0 || summary.offset_sd_m > 0.0 {
        lines.push(format!(
            "  size    is known to {:.1} % and {} mm all around, as the rig is: no log tells more (lengths above are for the rig as stated)",
            100.0 * summary.size_sd,
            three_digits(1e3 * summary.offset_sd_m)
        ));
    }
    if let Some(FrictionSummary { mu1, mu2 }) = summary.friction {
        let [first, second] = [mu1, mu2].map(|mu| with_sd(mu.value, mu.sd));
        lines.push(format!("  slides  with friction {first} on palm 1 and {second} on palm 2"));
    }
    if let Some((weight, force_sd_n)) = summary.weight_n.zip(summary.force_sd_n) {
        lines.push(format!(
            "  weighs  {} N ({} g) by forces that are measured to {} N",
            with_sd(weight.value, weight.sd),
            three_digits(1e3 * weight.value / STANDARD_GRAVITY_M_PER_S2),
            three_digits(force_sd_n)
        ));
    }
    lines.extend(summary.oddities.iter().map(|oddity| format!("          {oddity}")));
    if let Some((radius, damping)) = summary.gyration_radius_m.zip(summary.damping_per_s) {
        lines.push(format!(
            "  turns   with a radius of gyration of {} mm and a damping of {} per second",
            with_sd(1e3 * radius.value, 1e3 * radius.sd),
            with_sd(damping.value, damping.sd)
        ));
    }
    for (index, told) in rig_told(summary).into_iter().enumerate() {
        lines.push(format!("  {:<7} {told}", if index == 0 { "rig" } else { "" }));
    }
    if let Some(truth) = &summary.truth {
        lines.push(format!(
            "  errors  shape {} mm (form alone {} mm), orientation {} deg, centre of mass {} mm (root mean square)",
            three_digits(1e3 * truth.rms_r_m),
            three_digits(1e3 * truth.rms_form_m),
            three_digits(truth.rms_psi_rad.to_degrees()),
            three_digits(1e3 * truth.rms_com_m)
        ));
    }
    if summary.alternatives > 1 {
        lines.push(format!("  others  that fit equally well: {}", palpate_io::alternatives_dir_of(out).display()));
    }
    lines.push(format!("  report  {}", out.join("report.html").display()));
    lines.join("\n")
}

/// What the log told of the rig, a line for each constant.
fn rig_told(summary: &Summary) -> Vec<String> {
    let constant = |(name, constant): (&String, &ConstantSummary)| {
        let CalibrationConstant { label, unit, units_per_si, .. } = CalibrationConstant::named(name)?;
        let (value, sd) = (units_per_si * constant.value, units_per_si * constant.sd);
        Some(format!("{label:<33} {value:>8.3} ± {sd:.3} {unit}"))
    };
    let of = |about: &CalibrationConstant| summary.calibration.get_key_value(about.name);
    let open = CalibrationConstant::ALL.iter().filter_map(of).filter(|(_, constant)| constant.prior_sd > 0.0);
    open.filter_map(constant).collect()
}

/// A number with three significant digits, but no more than six decimals.
fn three_digits(value: f64) -> String {
    let magnitude = value.abs().log10().floor();
    let decimals = if magnitude.is_finite() { (2.0 - magnitude).clamp(0.0, 6.0) } else { 0.0 };
    format!("{value:.0$}", decimals as usize)
}

/// A number with its standard deviation, to two digits of the latter.
fn with_sd(value: f64, sd: f64) -> String {
    let magnitude = sd.abs().log10().floor();
    let decimals = if magnitude.is_finite() { (1.0 - magnitude).clamp(0.0, 6.0) as usize } else { 3 };
    format!("{value:.decimals$} ± {sd:.decimals$}")
}

/// How far the result is from the truth; a note when that cannot be said.
fn errors(reconstruction: &Reconstruction, truth: &Truth, terminal: &Terminal) -> Option<TruthSummary> {
    match compare(reconstruction, truth) {
        Ok(errors) => Some(errors.into()),
        Err(error) => {
            terminal.note(&error.to_string());
            None
        }
    }
}

/// What was typed, with the program's plain name.
pub(crate) fn command_line() -> String {
    let quoted = |argument: std::ffi::OsString| {
        let text = argument.to_string_lossy().into_owned();
        let plain = |c: char| c.is_alphanumeric() || "-_./=,:+".contains(c);
        if !text.is_empty() && text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
    };
    std::env::args_os().skip(1).fold("palpate".to_string(), |line, argument| line + " " + &quoted(argument))
}

#[cfg(test)]
mod tests {
    use super::{three_digits, told, with_sd};
    use palpate_io::Summary;
    use std::path::Path;

    #[test]
    fn several_answers_are_told_with_where_they_are() {
        let summary: Summary = serde_json::from_str(
            r#"{"certified": false, "com_certified": false, "reason": "3 different objects; and so on",
            "doubts": [{"kind": "not-convex", "text": ""}, {"kind": "new", "text": "3 different objects; and so on"}],
            "chi2_per_dof": 1, "jumps": [1.5], "coverage": 0.5, "alternatives": 3, "sensor_sd_m": 0.0001, "balance_sd_m": null,
            "samples": 100, "harmonics": 8, "seconds": 1, "version": "0.1.0",
            "symmetry": {"order": 2, "mirror": false, "probability": 0.96}}"#,
        )
        .expect("a summary");
        let expected = "NOT certified\n  - the shape is not convex\n    look for a second touch: only convex objects are reconstructed \
            (docs/verdict.md#not-convex)\n  - 3 different objects; and so on\n  \
            felt    50 % of the boundary in 100 samples, 1 jump; sensor noise 0.100 mm\n  \
            is      the same after half a turn (probability 0.96); after a jump ψ is known up to turns of 180°\n  \
            others  that fit equally well: out/alternatives\n  report  out/report.html";
        assert_eq!(told(&summary, Path::new("out")), expected);
    }

    #[test]
    fn a_number_has_the_digits_that_its_standard_deviation_knows() {
        let shown =
            [(21.437_812, 0.004_2), (0.404, 0.001_63), (3.2, 12.0), (1.0, 0.0)].map(|(value, sd)| with_sd(value, sd));
        assert_eq!(shown, ["21.4378 ± 0.0042", "0.4040 ± 0.0016", "3 ± 12", "1.000 ± 0.000"]);
    }

    #[test]
    fn three_digits_tell_enough() {
        let shown = [123.456, 1.0, 0.002_345, 1.234e-7, 0.0, f64::NAN].map(three_digits);
        assert_eq!(shown, ["123", "1.00", "0.00234", "0.000000", "0", "NaN"]);
    }
}
