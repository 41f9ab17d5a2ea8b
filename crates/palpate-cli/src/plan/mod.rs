//! `palpate plan`: how to move a robot so that it feels as much of an object as it can, for a shape that is known or a log of it.

mod palms;
mod strokes;

use std::path::{Path, PathBuf};

use palpate::shape::{NamedShape, SupportFunction};

use crate::log_source::LogSource;
use crate::source::{self, Center, ShapeSource};
use crate::terminal::{Ending, Failure, Terminal};
use crate::values;

const AFTER_HELP: &str = "\
A shape is named, or a file, as for `palpate simulate --shape`. A log is reconstructed first, as by `palpate reconstruct`: of a palm log the motion
is planned for the shape that comes out, of a log of strokes so that it holds for nearly all shapes that the log allows.

FILE.csv, for two palms: time_s, phi1_rad and phi2_rad (and base points), a row for each instant, in angles as a palm log has them; a comment says at
which orientation the object is to be let go. `palpate simulate --motion FILE.csv` runs through it.
FILE.csv, for a pivoting grasp (--rig pivot, or a log of strokes): stroke, along_m, press and coverage, a row for each place along the pad that the foot
of the pivot goes to: down at the first place of a stroke, dragged to each of the others with `press` weights of the object, and lifted.
`palpate simulate --rig pivot --motion FILE.csv` runs through it. No stroke is planned that adds less than a hundredth of the boundary.

Examples:
  palpate plan stone -o motion.csv                                a whole turn between two palms, without a jump
  palpate plan stone --friction 0.2 -o motion.csv                 the same where the palms stick
  palpate plan trial.csv --rig rig.toml -o motion.csv             for the object of a palm log
  palpate plan --rig pivot egg --along-mm 200,400 -o plan.csv     strokes over one pad
  palpate plan strokes.csv -o next.csv                            the strokes to come, by what was felt so far

Exit codes: 0 planned;  3 planned, for the shape of a log that is not certified;  2 bad input or usage, or nothing that can be felt;  1 anything else.";

/// Plan a motion that feels as much of an object as it can
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// The object, by name or from a file, or a log of it
    #[arg(value_name = "SHAPE|LOG")]
    object: PathBuf,
    /// The motion to write
    #[arg(short, long = "out", value_name = "FILE.csv")]
    out: PathBuf,
    /// What is known of the rig, a file as for `palpate reconstruct`: lengths of the pads, base points and friction are used. Or `pivot`: an arm that drags
    /// the object over one pad
    #[arg(long, value_name = "RIG.toml|pivot")]
    rig: Option<PathBuf>,
    /// Take the readings of a log as they are: the rig is exact
    #[arg(long, conflicts_with = "rig")]
    calibrated: bool,
    /// Mean radius of a named shape, mm [default: 30, or the size in the name]
    #[arg(long, value_name = "MM", value_parser = values::positive)]
    radius_mm: Option<f64>,
    /// Centre of mass of a shape, as an offset from its centroid, in its frame, mm [default: as the shape has it]
    #[arg(long, value_name = "X,Y", value_parser = values::pair, allow_hyphen_values = true)]
    com_mm: Option<[f64; 2]>,
    /// Coefficient of friction, or those of palm 1 and palm 2 [default: of a palm log or rig file what it says, else none; of a pivoting grasp 0.4]
    #[arg(long, value_name = "MU[,MU2]", value_parser = values::friction)]
    friction: Option<[f64; 2]>,
    /// Length of the palms, or of the pad, mm [default: of palms what the rig file says, else unlimited; of a pad as far as the log felt it, else twenty mean
    /// radii]
    #[arg(long, value_name = "MM", value_parser = values::positive)]
    palm_length_mm: Option<f64>,
    /// Palms: duration of the motion, s [default: 100]
    #[arg(long, value_name = "S", value_parser = values::positive)]
    duration_s: Option<f64>,
    /// Palms: rows per second, Hz [default: 20]
    #[arg(long, value_name = "HZ", value_parser = values::positive)]
    rate_hz: Option<f64>,
    /// Pivot: where the arm holds a shape, from its centre of mass, in its frame, mm [default: 0 and three tenths of the mean radius]
    #[arg(long, value_name = "X,Y", value_parser = values::pair, allow_hyphen_values = true)]
    pivot_mm: Option<[f64; 2]>,
    /// Pivot: part of the pad over which the foot of the pivot may go, from the base of the pad, mm [default: where it went in the log, else nine mean
    /// radii about the middle]
    #[arg(long, value_name = "LOW,HIGH", value_parser = values::pair, allow_hyphen_values = true)]
    along_mm: Option<[f64; 2]>,
    /// Pivot: longest way of one stroke along the pad, mm [default: there and back over that part]
    #[arg(long, value_name = "MM", value_parser = values::positive)]
    longest_mm: Option<f64>,
    /// Pivot: force with which the arm presses, in weights of the object [default: 3]
    #[arg(long, value_name = "WEIGHTS", value_parser = values::not_negative)]
    press: Option<f64>,
    /// Pivot: most strokes [default: 12]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    most_strokes: Option<u16>,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// The other rig, in place of a file.
const PIVOT: &str = "pivot";

/// Plans and writes the motion.
pub fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let terminal = Terminal::new(arguments.quiet);
    if arguments.out.is_dir() {
        return Err(Failure::Input(format!("{}: this is a folder; give the file to write", arguments.out.display())));
    }
    let log = LogSource(&arguments.object);
    let is_pivot = arguments.rig.as_deref() == Some(Path::new(PIVOT));
    let is_named = arguments.object.to_str().is_some_and(|text| text.parse::<NamedShape>().is_ok());
    if !is_named && log.is_strokes(None) {
        arguments.refuse("a log of strokes", &[arguments.of_shape(), arguments.of_palms()])?;
        return strokes::of_log(arguments, log, &terminal);
    }
    if !is_named && log.is_of_palms() {
        if is_pivot {
            let message = "this is a palm log, and --rig pivot is the other rig; leave that out, or give a shape";
            return Err(Failure::Input(format!("{}: {message}", arguments.object.display())));
        }
        arguments.refuse("a palm log", &[arguments.of_shape(), arguments.of_pivot()])?;
        return palms::of_log(arguments, log, &terminal);
    }
    if arguments.calibrated {
        return Err(Failure::Input("--calibrated is for a log; leave it out, a shape has no readings".to_owned()));
    }
    let name = arguments.object.to_string_lossy();
    let source =
        source::shape(&name).map_err(|error| Failure::Input(format!("{name}: {error}, or a log is needed")))?;
    if is_pivot {
        arguments.refuse("a pivoting grasp", &[arguments.of_palms()])?;
        return strokes::of_shape(arguments, &arguments.shape(&source, &terminal)?, &terminal);
    }
    arguments.refuse("a motion of palms", &[arguments.of_pivot()])?;
    palms::of_shape(arguments, &arguments.shape(&source, &terminal)?, &terminal)
}

/// Options with their names, and whether they were given.
type Given = Vec<(bool, &'static str)>;

impl Arguments {
    fn of_palms(&self) -> Given {
        vec![(self.duration_s.is_some(), "--duration-s"), (self.rate_hz.is_some(), "--rate-hz")]
    }

    fn of_pivot(&self) -> Given {
        vec![
            (self.pivot_mm.is_some(), "--pivot-mm"),
            (self.along_mm.is_some(), "--along-mm"),
            (self.longest_mm.is_some(), "--longest-mm"),
            (self.press.is_some(), "--press"),
            (self.most_strokes.is_some(), "--most-strokes"),
        ]
    }

    fn of_shape(&self) -> Given {
        vec![
            (self.radius_mm.is_some(), "--radius-mm"),
            (self.com_mm.is_some(), "--com-mm"),
            (self.pivot_mm.is_some(), "--pivot-mm"),
        ]
    }

    /// Refuses options that mean nothing for what is planned.
    fn refuse(&self, what: &str, options: &[Given]) -> Result<(), Failure> {
        match options.iter().flatten().find(|(given, _)| *given) {
            Some((_, option)) => Err(Failure::Input(format!("{what} has no {option}; leave it out"))),
            None => Ok(()),
        }
    }

    /// The object about its centre of mass.
    fn shape(&self, source: &ShapeSource, terminal: &Terminal) -> Result<SupportFunction, Failure> {
        let center = self.com_mm.map_or(Center::Moved([0.0; 2]), Center::FromCentroid);
        source.about_center(self.radius_mm, center, terminal)
    }

    fn palm_length_m(&self) -> Option<f64> {
        self.palm_length_mm.map(|mm| 1e-3 * mm)
    }

    /// What stands above the header of the file.
    fn metadata(&self) -> [(&'static str, String); 2] {
        let version = format!("palpate plan {}", env!("CARGO_PKG_VERSION"));
        [("made by", version), ("planned for", self.object.display().to_string())]
    }
}
