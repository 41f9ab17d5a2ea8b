//! `palpate simulate`: a palm log of a known object and motion, with its truth.

use std::path::{Path, PathBuf};

use palpate::palms::{MotionError, PalmMotion, PalmPair};
use palpate::plan::{PalmLimits, PlanError, plan_turn};
use palpate::sensor::{Rig, Tolerances, Touchpad};
use palpate::shape::{ShapeError, SupportFunction};
use palpate::simulate::{ObjectInertia, SimulateError, SimulateOptions, Simulation};

use palpate_io::{PalmCourse, RigFile};

use crate::source::{self, Center, MotionSource, PadSource, ShapeSource};
use crate::strokes;
use crate::terminal::{Ending, Failure, Terminal};
use crate::values;

const AFTER_HELP: &str = "\
Shapes: circle, disc, ellipse, egg, triangle and square (with rounded corners), pebble, stone, random:SEED for any number SEED, and with
sizes in millimetres rectangle:60x40 (or rectangle:60x40x5 with a corner radius) and stadium:60x40. Or a file: OUTLINE.csv with the columns
x_m and y_m (points in order round the object, other units as in logs), a shape.csv of a result or a truth, or a drawing OUTLINE.svg, of
which the path with the largest area is taken, with user units as millimetres unless the document says otherwise. A shape has smooth
corners and no flat sides: a note says how far it is from the outline, and the convex hull takes the place of a concave one. Its centre
of mass is the centroid of the outline, or what --com-mm says.

Motions: turn, zigzag, random, or a file with the columns time_s, phi1_rad and phi2_rad (and base points), such as any palm log, or what
`palpate plan` writes, where a comment says at which orientation the object is let go.

A touchpad file is TOML with any of noise_sd_m, counts_per_inch, angle_noise_sd_rad, dropout and length_m, as in the plan of a sweep.

LOG.csv is the log; LOG.truth/ beside it holds the true shape and motion (shape.csv, motion.csv), and with --rig
LOG.rig.toml the errors that the rig had. A comment in the log says what is known of its rig, which `palpate reconstruct` takes it by.

Examples:
  palpate simulate -o pebble.csv
  palpate simulate --shape random:5 --noise-mm 0.3 --angle-noise-deg 0.1 -o five.csv
  palpate simulate --pad interlink --radius-mm 20 -o pad.csv       as in the experiment of Moll & Erdmann (2001)
  palpate simulate --motion random --shape stone -o jumps.csv      a motion that knows nothing of the object: it jumps
  palpate simulate --motion random --friction 0.2 -o sticky.csv    palms with friction: the object rolls, slides and jumps
  palpate simulate --speed 10 --rate-hz 100 -o fast.csv            the same motion in a tenth of the time: the object swings
  palpate plan stone -o motion.csv && palpate simulate --shape stone --motion motion.csv -o stone.csv
  palpate simulate --shape soap.svg --com-mm 2,0 -o soap.csv       your own object, its centre of mass 2 mm off the centroid
  palpate simulate --motion trial.csv -o again.csv                 another object between palms that move as in your log
  palpate simulate --rig pivot --shape egg -o strokes.csv          an arm drags the object over one pad, in six strokes
  palpate simulate --rig rig.toml -o off.csv                       as a rig with the errors and conventions of this file writes it
  palpate reconstruct pebble.csv -o pebble --truth pebble.truth";

/// Simulate a palm log of a known object
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP, allow_negative_numbers = true)]
pub struct Arguments {
    /// The log to write; the truth goes into LOG.truth beside it
    #[arg(short, long = "out", value_name = "LOG.csv")]
    out: PathBuf,
    /// The object, by name or from a file, see below
    #[arg(long, value_name = "NAME|FILE", default_value = "pebble", value_parser = source::shape)]
    shape: ShapeSource,
    /// Mean radius of the object (perimeter / 2 pi), mm [default: 30, or the size in the name or file]
    #[arg(long, value_name = "MM", value_parser = values::positive)]
    radius_mm: Option<f64>,
    /// Centre of mass, as an offset from the centroid of the object, in its frame, mm [default: as the name has it; of an outline, the
    /// centroid; of a shape.csv, its origin]
    #[arg(long, value_name = "X,Y", value_parser = values::pair, allow_hyphen_values = true, conflicts_with = "com_offset_mm")]
    com_mm: Option<[f64; 2]>,
    /// Offset of the centre of mass from its place in the shape, in the frame of the object, mm
    #[arg(long, value_name = "X,Y", default_value = "0,0", value_parser = values::pair, allow_hyphen_values = true)]
    com_offset_mm: [f64; 2],
    /// How the palms move, by name or from a file: turn (planned for the object: a full turn without a jump, or back and forth over as much
    /// as can be felt), zigzag (squeezes, rotations and openings of one palm, there and back, as in the paper), random (smooth), or as in FILE. With --rig pivot, a
    /// FILE of strokes as `palpate plan` writes it
    #[arg(long, value_name = "NAME|FILE", default_value = "turn", value_parser = source::motion)]
    motion: MotionSource,
    /// Where the arm holds the object, from its centre of mass, in the frame of the object, mm; with --rig pivot [default: 0 and three tenths of the
    /// mean radius]
    #[arg(long, value_name = "X,Y", value_parser = values::pair, allow_hyphen_values = true)]
    pivot_mm: Option<[f64; 2]>,
    /// Duration of the motion, s [default: 100, or that of the file]
    #[arg(long, value_name = "S", value_parser = values::positive)]
    duration_s: Option<f64>,
    /// Samples per second, Hz [default: 20, or as the file has them]
    #[arg(long, value_name = "HZ", value_parser = values::positive)]
    rate_hz: Option<f64>,
    /// Distance between the base points of the palms, mm; 0 for a common hinge
    #[arg(long, value_name = "MM", default_value = "0", value_parser = values::not_negative)]
    finger_gap_mm: f64,
    /// Properties of the touch sensors: ideal (unlimited length, no rounding), interlink (the pad of the paper: 55.5 mm long, 200 counts per
    /// inch, 128 levels of pressure), or a touchpad file, see below; the options below override them
    #[arg(long, value_name = "NAME|FILE", default_value = "ideal", value_parser = source::pad)]
    pad: PadSource,
    /// Length of the palms, mm [default: as the pad has it]
    #[arg(long, value_name = "MM", value_parser = values::positive)]
    palm_length_mm: Option<f64>,
    /// The rig that writes the log, a file as `palpate rig --template` prints it: its constants are the errors of the readings, its
    /// signs, directions and base points are those of the log [default: a rig without errors]. Or `pivot`: the other rig of the paper, an arm that
    /// drags the object over one pad
    #[arg(long, value_name = "RIG.toml|pivot")]
    rig: Option<PathBuf>,
    /// Draw the errors of the rig: its constants, and random errors of its standard deviations on top of them
    #[arg(long, requires = "rig")]
    draw_rig: bool,
    /// Standard deviation of Gaussian noise on the contact positions, mm [default: 0.1, or as the rig or touchpad file says]
    #[arg(long, value_name = "MM", value_parser = values::not_negative)]
    noise_mm: Option<f64>,
    /// Steps per inch that contact positions are rounded to [default: as the pad has it]
    #[arg(long, value_name = "N", value_parser = values::positive)]
    counts_per_inch: Option<f64>,
    /// Standard deviation of Gaussian noise on the two palm angles, degrees [default: 0, or as the rig or touchpad file says]
    #[arg(long, value_name = "DEG", value_parser = values::not_negative)]
    angle_noise_deg: Option<f64>,
    /// Share of the readings of each pad that are missing, 0 to 1 [default: 0, or as the touchpad file says]
    #[arg(long, value_name = "SHARE", value_parser = values::share)]
    dropout: Option<f64>,
    /// Coefficient of friction between palms and object, or those of palm 1 and palm 2 [default: none, or as the rig file says]
    #[arg(long, value_name = "MU[,MU2]", value_parser = values::friction)]
    friction: Option<[f64; 2]>,
    /// The palms run through the motion so many times faster, and the inertia of the object counts; --rate-hz and all times of the log are
    /// those of the fast palms [default: palms so slow that the object is at rest at all times]
    #[arg(long, value_name = "FACTOR", value_parser = values::positive, conflicts_with = "friction")]
    speed: Option<f64>,
    /// Drag on the rotation of the object, over its moment of inertia, 1/s
    #[arg(long, value_name = "PER_S", default_value = "0.4", value_parser = values::not_negative, requires = "speed")]
    damping_per_s: f64,
    /// Radius of gyration of the object about its centre of mass, mm [default: that of an even mass]
    #[arg(long, value_name = "MM", value_parser = values::positive, requires = "speed")]
    gyration_radius_mm: Option<f64>,
    /// Write the normal forces too (columns force1_n, force2_n), for an object of this mass, grams
    #[arg(long, value_name = "GRAMS", value_parser = values::positive)]
    mass_g: Option<f64>,
    /// Write the standard deviation of the contact positions too (columns s1_sd_m, s2_sd_m)
    #[arg(long)]
    state_noise: bool,
    /// Seed of the noise, of --motion random and of --draw-rig
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// The other rig of the paper, in place of a file.
const PIVOT: &str = "pivot";

/// Noise of the contact positions if nothing is said of it, metres.
const USUAL_NOISE_M: f64 = 1e-4;

/// Duration and rate of a motion by name if nothing is said of it, seconds and hertz.
pub const USUAL_DURATION_S: f64 = 100.0;
pub const USUAL_RATE_HZ: f64 = 20.0;

/// Simulates and writes the log and the truth.
pub fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let terminal = Terminal::new(arguments.quiet);
    if arguments.out.is_dir() {
        return Err(Failure::Input(format!("{}: this is a folder; give the file to write", arguments.out.display())));
    }
    let center = match arguments.com_mm {
        Some(com_mm) => Center::FromCentroid(com_mm),
        None => Center::Moved(arguments.com_offset_mm),
    };
    let shape = arguments.shape.about_center(arguments.radius_mm, center, &terminal)?;
    if arguments.rig.as_deref() == Some(Path::new(PIVOT)) {
        return of_strokes(arguments, &shape, &terminal);
    }
    if arguments.pivot_mm.is_some() {
        return Err(Failure::Input("--pivot-mm is for --rig pivot; leave it out, or add that".to_owned()));
    }
    let rig = arguments.rig.as_deref().map(palpate_io::read_rig).transpose()?.unwrap_or_else(RigFile::exact);
    let calibration = if arguments.draw_rig { rig.rig.drawn(arguments.seed) } else { rig.rig.calibration };
    let touchpad = touchpad(arguments, &rig)?;
    let progress = terminal.progress();
    progress.say("planning palms that carry the object round");
    let course = course(arguments, &shape, &touchpad, &rig)?;
    drop(progress);
    let options = SimulateOptions {
        touchpad,
        start_psi_rad: course.start_psi_rad,
        friction: friction(arguments, &rig),
        inertia: arguments.speed.map(|_| ObjectInertia {
            gyration_radius_m: arguments.gyration_radius_mm.map(|radius| 1e-3 * radius),
            damping_per_s: arguments.damping_per_s,
        }),
        seed: arguments.seed,
        mass_kg: arguments.mass_g.map_or(0.1, |grams| 1e-3 * grams),
        with_forces: arguments.mass_g.is_some(),
        with_stated_noise: arguments.state_noise,
    };
    let mut simulation = palpate::simulate::simulate(&shape, &course.palms, &options)?;
    simulation.log = rig.conventions.apply(&calibration.distorted(&simulation.log));
    let metadata = [
        ("made by".to_string(), format!("palpate simulate {}", env!("CARGO_PKG_VERSION"))),
        ("shape".to_string(), arguments.shape.to_string()),
        ("rig".to_string(), palpate_io::rig_comment(&rig)),
    ];
    let truth_dir = palpate_io::truth_dir_of(&arguments.out);
    palpate_io::write_truth(&truth_dir, &simulation.truth)?;
    if arguments.rig.is_some() {
        let used = RigFile { rig: Rig::new(calibration, Tolerances::NONE), ..rig };
        palpate_io::write_whole(&used_rig_of(&arguments.out), palpate_io::rig_to_toml(&used).as_bytes())?;
    }
    palpate_io::write_log(&arguments.out, &simulation.log, &metadata)?;
    terminal.say(&told(arguments, &simulation))?;
    Ok(Ending::Success)
}

/// Strokes of a pivoting grasp; what is asked of palms alone is refused.
fn of_strokes(arguments: &Arguments, shape: &SupportFunction, terminal: &Terminal) -> Result<Ending, Failure> {
    let of_palms = [
        (arguments.draw_rig, "--draw-rig"),
        (arguments.speed.is_some(), "--speed"),
        (arguments.mass_g.is_some(), "--mass-g"),
        (arguments.duration_s.is_some(), "--duration-s"),
        (arguments.state_noise, "--state-noise"),
    ];
    if let Some((_, option)) = of_palms.iter().find(|(given, _)| *given) {
        return Err(Failure::Input(format!("a pivoting grasp has no {option}; leave it out")));
    }
    let strokes = match &arguments.motion {
        MotionSource::Turn => None,
        MotionSource::File(path) => Some(path.as_path()),
        MotionSource::Zigzag | MotionSource::Random => {
            let message = "a pivoting grasp has no such --motion; give a file of strokes as `palpate plan` writes it, or leave it out";
            return Err(Failure::Input(message.to_owned()));
        }
    };
    let asked = strokes::Simulate {
        out: &arguments.out,
        shape,
        pivot_m: arguments.pivot_mm.map(|pivot| pivot.map(|mm| 1e-3 * mm)),
        touchpad: touchpad(arguments, &RigFile::exact())?,
        friction: arguments.friction.map(|[friction, _]| friction),
        strokes,
        rate_hz: arguments.rate_hz.unwrap_or(USUAL_RATE_HZ),
        seed: arguments.seed,
        name: arguments.shape.to_string(),
    };
    asked.run(terminal)
}

/// Coefficients of friction of both palms: as asked for, else as the rig file says, where the object moves slowly.
fn friction(arguments: &Arguments, rig: &RigFile) -> [f64; 2] {
    match (arguments.friction, arguments.speed) {
        (Some(friction), _) => friction,
        (None, None) => rig.pads.map(|pad| pad.friction.unwrap_or(0.0)),
        (None, Some(_)) => [0.0; 2],
    }
}

/// The file beside a log that says what errors its rig had.
fn used_rig_of(log: &Path) -> PathBuf {
    log.with_extension("rig.toml")
}

/// Length of the shorter pad, where the rig file has it.
pub fn palm_length_m(rig: &RigFile) -> Option<f64> {
    rig.conventions.palms.iter().filter_map(|palm| palm.direction.length_m()).reduce(f64::min)
}

/// Where the palms may go, with a little room left at the ends of the pads.
pub fn limits(touchpad: &Touchpad) -> PalmLimits {
    PalmLimits { palm_length_m: 0.97 * touchpad.length_m, ..PalmLimits::default() }
}

fn touchpad(arguments: &Arguments, rig: &RigFile) -> Result<Touchpad, Failure> {
    let (pad, of_file) = match &arguments.pad {
        PadSource::Ideal => (Touchpad::ideal(), None),
        PadSource::Interlink => (Touchpad::interlink(), None),
        PadSource::File(path) => {
            let pad = read_touchpad(path)?;
            (pad, Some(pad.noise_sd_m))
        }
    };
    // The pads are alike: what the file says of either.
    let of_pads = |value: fn(&palpate_io::Pad) -> Option<f64>| rig.pads.iter().find_map(value);
    let length_m = arguments.palm_length_mm.map(|length| 1e-3 * length).or(palm_length_m(rig));
    let noise_sd_m = arguments.noise_mm.map(|noise| 1e-3 * noise).or(of_pads(|pad| pad.reading_sd_m));
    let angle_noise_sd_rad = arguments.angle_noise_deg.map(f64::to_radians).or(rig.angle_reading_sd_rad);
    Ok(Touchpad {
        length_m: length_m.unwrap_or(pad.length_m),
        counts_per_inch: arguments.counts_per_inch.or(of_pads(|pad| pad.counts_per_inch)).or(pad.counts_per_inch),
        noise_sd_m: noise_sd_m.or(of_file).unwrap_or(USUAL_NOISE_M),
        angle_noise_sd_rad: angle_noise_sd_rad.unwrap_or(pad.angle_noise_sd_rad),
        dropout: arguments.dropout.unwrap_or(pad.dropout),
        rate_hz: arguments.rate_hz.unwrap_or(USUAL_RATE_HZ),
        ..pad
    })
}

#[cfg(feature = "sweep")]
fn read_touchpad(path: &Path) -> Result<Touchpad, Failure> {
    Ok(Touchpad::from(palpate_sweep::read_touchpad(path)?))
}

#[cfg(not(feature = "sweep"))]
fn read_touchpad(_: &Path) -> Result<Touchpad, Failure> {
    Err(crate::absent::failure("touchpad files"))
}

fn told(arguments: &Arguments, simulation: &Simulation) -> String {
    let jumps = match simulation.jumps.len() {
        _ if arguments.speed.is_some() => "on its way at all times".to_string(),
        0 => "no jump".to_string(),
        1 => "1 jump".to_string(),
        count => format!("{count} jumps"),
    };
    let rig = match &arguments.rig {
        Some(_) => format!("\n{}: the errors of its rig", used_rig_of(&arguments.out).display()),
        None => String::new(),
    };
    format!(
        "{}: {} samples, {jumps}\n{}: its truth{rig}",
        arguments.out.display(),
        simulation.log.samples.len(),
        palpate_io::truth_dir_of(&arguments.out).display()
    )
}

impl From<ShapeError> for Failure {
    fn from(error: ShapeError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<MotionError> for Failure {
    fn from(error: MotionError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<SimulateError> for Failure {
    fn from(error: SimulateError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Self {
        Self::Input(format!("{error}; try --motion zigzag, or another --palm-length-mm or --com-offset-mm"))
    }
}

/// The palms over time, and the orientation at which the object is let go.
struct Course {
    /// Time in seconds, and the palms.
    palms: Vec<(f64, PalmPair)>,
    /// Radians.
    start_psi_rad: f64,
}

fn course(
    arguments: &Arguments,
    shape: &SupportFunction,
    touchpad: &Touchpad,
    rig: &RigFile,
) -> Result<Course, Failure> {
    let duration_s = arguments.duration_s.unwrap_or(USUAL_DURATION_S);
    let rate_hz = arguments.rate_hz.unwrap_or(USUAL_RATE_HZ);
    let half = 0.5e-3 * arguments.finger_gap_mm;
    let speed = arguments.speed.unwrap_or(1.0);
    // Where an object rests depends on the angles of the palms alone, so that a plan for hinged palms holds for fingers too.
    let of = |palm: usize, x_m: f64| {
        let [x, y] = rig.conventions.palms[palm].base_m;
        [x.unwrap_or(x_m), y.unwrap_or(0.0)]
    };
    let (base1_m, base2_m) = (of(0, half), of(1, -half));
    let (motion, start_psi_rad) = match &arguments.motion {
        MotionSource::File(path) => {
            if arguments.duration_s.is_some() || arguments.rate_hz.is_some() {
                let file = path.display();
                return Err(Failure::Input(format!("{file} has its own times; leave --duration-s and --rate-hz out")));
            }
            let PalmCourse { mut palms, start_psi_rad } = palpate_io::read_palm_course(path)?;
            let are_hinged = palms.iter().all(|(_, pair)| pair.base1_m == [0.0; 2] && pair.base2_m == [0.0; 2]);
            for (time_s, pair) in &mut palms {
                *time_s /= speed;
                if are_hinged {
                    (pair.base1_m, pair.base2_m) = (base1_m, base2_m);
                }
            }
            return Ok(Course { palms, start_psi_rad: start_psi_rad.unwrap_or(0.0) });
        }
        MotionSource::Turn => {
            let planned = plan_turn(shape, &limits(touchpad), duration_s)?;
            (planned.motion, planned.start_psi_rad)
        }
        MotionSource::Zigzag => (PalmMotion::squeeze_and_rotate(duration_s, 2)?, 0.0),
        MotionSource::Random => (PalmMotion::random(arguments.seed, duration_s, 1.0)?, 0.0),
    };
    let mut palms = motion.with_bases(base1_m, base2_m).sample(rate_hz / speed)?;
    palms.iter_mut().for_each(|(time_s, _)| *time_s /= speed);
    Ok(Course { palms, start_psi_rad })
}
