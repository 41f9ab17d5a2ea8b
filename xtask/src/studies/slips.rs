//! `cargo xtask slips`: the usual mistakes in how a log is written, each made in right logs, and whether it is named. As by the program: a reader that
//! refuses a log names the mistake too.

use std::f64::consts::FRAC_PI_2;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Instant;

use anyhow::Context;
use palpate::compare::compare;
use palpate::palms::PalmPair;
use palpate::plan::{PalmLimits, plan_turn};
use palpate::reconstruct::{Doubt, Mistake, Reconstructor};
use palpate::sensor::{Rig, Touchpad};
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, Simulation, simulate};
use palpate::{Log, Sample, Truth};

use crate::studies::tables::{self, Write};
use crate::workspace;

/// The logs of `examples/logs` that the mistakes are made in: those without friction and of slow palms. A fifth is simulated.
const LOGS: [(&str, &str); 4] = [
    ("egg", "egg_full_turn_oracle_n0.1mm"),
    ("ellipse", "ellipse_full_turn_pymunk"),
    ("pebble", "pebble_full_turn_mujoco_sensor"),
    ("stone", "stone_zigzag_oracle"),
];

/// Pads read from their far ends are so long, metres.
const PAD_M: f64 = 0.12;
/// Steps that positions are rounded to, metres.
const COARSE_M: f64 = 1e-3;
/// Contact is lost three times, each for so many samples of a hundred.
const LOST: usize = 5;
/// An object is right that is within this share of its mean radius of the true one.
const RIGHT: f64 = 0.01;

const COMMAND: &str = "cargo xtask slips";

/// Options of `cargo xtask slips`.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    write: Write,
}

/// A usual mistake.
struct Slip {
    name: &'static str,
    /// Makes it in a log.
    make: fn(&Log) -> Log,
    /// Whether this is it.
    is_named: fn(Mistake) -> bool,
    /// What the reader says that refuses the log; empty where none does.
    refused: &'static str,
}

const SLIPS: [Slip; 14] = [
    Slip {
        name: "`s1` and `s2` swapped",
        make: |log| positions(log, |s1, s2| (s2, s1)),
        is_named: |mistake| mistake == Mistake::PadsSwapped,
        refused: "",
    },
    Slip {
        name: "`phi1` and `phi2` swapped",
        make: |log| angles(log, |phi1, phi2| (phi2, phi1)),
        is_named: |mistake| mistake == Mistake::AnglesSwapped,
        refused: "",
    },
    Slip {
        name: "palms swapped",
        make: |log| positions(&angles(log, |phi1, phi2| (phi1 + phi2, -phi2)), |s1, s2| (s2, s1)),
        is_named: |mistake| mistake == Mistake::PalmsSwapped,
        refused: "the palms are swapped",
    },
    Slip {
        name: "`phi2` from the horizontal",
        make: |log| angles(log, |phi1, phi2| (phi1, phi1 + phi2)),
        is_named: |mistake| mistake == Mistake::Phi2FromHorizontal,
        refused: "",
    },
    Slip {
        name: "sign of `phi1`",
        make: |log| angles(log, |phi1, phi2| (-phi1, phi2)),
        is_named: |mistake| mistake == Mistake::Phi1Clockwise,
        refused: "",
    },
    Slip {
        name: "sign of `phi2`",
        make: |log| angles(log, |phi1, phi2| (phi1, -phi2)),
        is_named: |mistake| mistake == Mistake::Phi2Clockwise,
        refused: "phi2 is counted clockwise",
    },
    Slip {
        name: "both signs",
        make: |log| angles(log, |phi1, phi2| (-phi1, -phi2)),
        is_named: |mistake| mistake == Mistake::BothClockwise,
        refused: "phi1 and phi2 are counted clockwise",
    },
    Slip {
        name: "`phi1` from the vertical",
        make: |log| angles(log, |phi1, phi2| (phi1 - FRAC_PI_2, phi2)),
        is_named: |mistake| mistake == Mistake::Phi1FromVertical,
        refused: "",
    },
    Slip {
        name: "the same, clockwise",
        make: |log| angles(log, |phi1, phi2| (FRAC_PI_2 - phi1, phi2)),
        is_named: |mistake| mistake == Mistake::Phi1FromVerticalClockwise,
        refused: "",
    },
    Slip {
        name: "positions from the far ends",
        make: |log| positions(log, |s1, s2| (PAD_M - s1, PAD_M - s2)),
        is_named: |mistake| {
            let Mistake::ReadFromTip { length1_m, length2_m } = mistake else { return false };
            [length1_m, length2_m].iter().all(|length_m| length_m.is_some_and(|m| (m - PAD_M).abs() < 2.5e-3))
        },
        refused: "",
    },
    Slip {
        name: "degrees under `_rad`",
        make: |log| angles(log, |phi1, phi2| (phi1.to_degrees(), phi2.to_degrees())),
        is_named: |_| false,
        refused: "looks like degrees",
    },
    Slip {
        name: "millimetres under `_m`",
        make: |log| positions(log, |s1, s2| (1e3 * s1, 1e3 * s2)),
        is_named: |mistake| mistake == Mistake::MillimetersAsMeters,
        refused: "s1_mm",
    },
    Slip {
        name: "zeros for no contact",
        make: |log| {
            let third = (log.samples.len() / 3).max(1);
            let lost = |index: usize| 100 * (index % third) < LOST * log.samples.len();
            let written = |(index, sample): (usize, &Sample)| {
                if lost(index) { Sample { s1_m: Some(0.0), ..*sample } } else { *sample }
            };
            Log { samples: log.samples.iter().enumerate().map(written).collect() }
        },
        is_named: |mistake| matches!(mistake, Mistake::ZerosForNoContact { .. }),
        refused: "",
    },
    Slip {
        name: "whole millimetres",
        make: |log| positions(log, |s1, s2| (rounded(s1), rounded(s2))),
        is_named: |mistake| matches!(mistake, Mistake::CoarsePositions { .. }),
        refused: "",
    },
];

fn angles(log: &Log, change: fn(f64, f64) -> (f64, f64)) -> Log {
    let changed = |sample: &Sample| {
        let (phi1_rad, phi2_rad) = change(sample.palms.phi1_rad, sample.palms.phi2_rad);
        Sample { palms: PalmPair { phi1_rad, phi2_rad, ..sample.palms }, ..*sample }
    };
    Log { samples: log.samples.iter().map(changed).collect() }
}

/// Both positions of each sample changed, where both are there.
fn positions(log: &Log, change: fn(f64, f64) -> (f64, f64)) -> Log {
    let changed = |sample: &Sample| match sample.s1_m.zip(sample.s2_m).map(|(s1, s2)| change(s1, s2)) {
        Some((s1, s2)) => Sample { s1_m: Some(s1), s2_m: Some(s2), ..*sample },
        None => *sample,
    };
    Log { samples: log.samples.iter().map(changed).collect() }
}

fn rounded(s_m: f64) -> f64 {
    (s_m / COARSE_M).round() * COARSE_M
}

/// What became of a log with a mistake.
enum Outcome {
    /// It is named.
    Named,
    /// The object is certified all the same, and right.
    Harmless,
    /// This is said instead.
    Missed(String),
}

impl Slip {
    /// What the program makes of a log with this mistake: read from its text, and reconstructed by an ordinary rig.
    fn outcome(&self, log: &Log, truth: &Truth) -> anyhow::Result<Outcome> {
        let text = palpate_io::log_csv(&(self.make)(log));
        let file = match palpate_io::parse_log("log.csv", text.as_bytes()) {
            Ok(file) => file,
            Err(error) if !self.refused.is_empty() && error.to_string().contains(self.refused) => {
                return Ok(Outcome::Named);
            }
            Err(error) => return Ok(Outcome::Missed(error.to_string())),
        };
        let found = match Reconstructor::new().rig(Rig::uncalibrated()).run_or_name_mistake(&file.log) {
            Ok(found) => found,
            Err(error) => return Ok(Outcome::Missed(error.to_string())),
        };
        if let Some(Doubt::Mistaken { mistake }) = found.verdict.doubts.first() {
            let is_named = (self.is_named)(*mistake);
            return Ok(if is_named { Outcome::Named } else { Outcome::Missed(mistake.to_string()) });
        }
        let is_right = found.is_certified() && compare(&found, truth)?.rms_r_m < RIGHT * found.shape.mean_radius_m();
        Ok(if is_right { Outcome::Harmless } else { Outcome::Missed(found.verdict.reason()) })
    }
}

/// A simulated log, with the errors of an ordinary rig.
fn simulated() -> anyhow::Result<(Log, Truth)> {
    let shape = NamedShape::Random(77).shape(0.03)?;
    let plan = plan_turn(&shape, &PalmLimits::default(), 40.0)?;
    let touchpad = Touchpad { noise_sd_m: 5e-5, ..Touchpad::ideal() };
    let options =
        SimulateOptions { touchpad, seed: 954, start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
    let Simulation { log, truth, .. } = simulate(&shape, &plan.motion.sample(20.0)?, &options)?;
    Ok((Rig::uncalibrated().drawn(954).distorted(&log), truth))
}

/// Seconds of a processor that this process has taken, which other processes do not make longer; where the system does not tell them,
/// seconds since the first call.
fn processor_s() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    /// Clock ticks that Linux counts per second.
    const TICKS_PER_S: f64 = 100.0;
    let since = START.get_or_init(Instant::now).elapsed().as_secs_f64();
    let ticks = |stat: String| {
        // The name of the program, in brackets, may hold blanks.
        let fields: Vec<f64> = stat
            .rsplit(')')
            .next()?
            .split_whitespace()
            .skip(11)
            .take(2)
            .map_while(|field| field.parse().ok())
            .collect();
        <[f64; 2]>::try_from(fields).ok()
    };
    let told = std::fs::read_to_string("/proc/self/stat").ok().and_then(ticks);
    told.map_or(since, |[user, system]| (user + system) / TICKS_PER_S)
}

/// Makes every mistake in every log and prints the table.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    arguments.write.check(&[tables::SLIPS])?;
    let dir = workspace::root().join("examples/logs");
    let mut logs = Vec::new();
    for (name, file) in LOGS {
        logs.push((name, log_of(&dir.join(format!("{file}.csv"))).context(name)?));
    }
    logs.push(("simulated", simulated()?));
    let names: Vec<&str> = logs.iter().map(|(name, _)| *name).collect();
    let mut lines =
        vec![format!("| mistake | {} |", names.join(" | ")), format!("|---|{}", "---:|".repeat(logs.len()))];
    let mut right = vec![0; logs.len()];
    for slip in &SLIPS {
        let mut cells = Vec::new();
        for ((name, (log, truth)), right) in logs.iter().zip(&mut right) {
            let before_s = processor_s();
            let outcome = slip.outcome(log, truth)?;
            let seconds = processor_s() - before_s;
            let said = match outcome {
                Outcome::Named => "named",
                Outcome::Harmless => "harmless",
                Outcome::Missed(said) => {
                    eprintln!("{name}, {}: {said}", slip.name);
                    "missed"
                }
            };
            *right += usize::from(said != "missed");
            cells.push(format!("{said}, {seconds:.1} s"));
        }
        lines.push(format!("| {} | {} |", slip.name, cells.join(" | ")));
        eprintln!("{}", lines.last().map_or("", String::as_str));
    }
    let counts: Vec<String> = right.iter().map(|right| format!("{right} of {}", SLIPS.len())).collect();
    lines.push(format!("| named, or harmless | {} |", counts.join(" | ")));
    let text = format!("    {COMMAND}\n\n{}", lines.join("\n"));
    println!("{text}");
    arguments.write.tables(&[(tables::SLIPS, text)], COMMAND)
}

fn log_of(path: &Path) -> anyhow::Result<(Log, Truth)> {
    Ok((palpate_io::read_log(path)?.log, palpate_io::read_truth(&palpate_io::truth_dir_of(path))?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documented_mistakes_are_named_today() {
        let page = std::fs::read_to_string(workspace::root().join("docs/verdict.md")).expect("the page is there");
        let row = |name: &str| -> Vec<&str> {
            let begin = format!("| {name} | ");
            let line = page.lines().find_map(|line| line.strip_prefix(&begin)).unwrap_or_else(|| panic!("{name}"));
            line.trim_end_matches(" |").split(" | ").collect()
        };
        for count in row("named, or harmless") {
            let named: usize = count.split(' ').next().and_then(|named| named.parse().ok()).expect("a number");
            assert!(named >= 10, "{count}");
        }
        // The rest takes long; the tests of the estimator name each mistake once.
        let (log, truth) =
            log_of(&workspace::root().join("examples/logs/egg_full_turn_oracle_n0.1mm.csv")).expect("a log");
        for (number, slip) in SLIPS.iter().enumerate() {
            let cells = row(slip.name);
            assert_eq!(cells.len(), LOGS.len() + 1, "{}", slip.name);
            if number == 0 || !slip.refused.is_empty() {
                let outcome = slip.outcome(&log, &truth).expect("an outcome");
                assert!(matches!(outcome, Outcome::Named) && cells[0].starts_with("named"), "{}", slip.name);
            }
        }
    }
}
