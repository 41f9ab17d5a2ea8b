//! `cargo xtask fuzz`: inputs made at random, towards code not yet reached, for the reader of logs and the estimator.
//!
//! The targets of `fuzz/` are built with libFuzzer (by the C++ compiler) and with the coverage counters that LLVM has in any compiler, so
//! that neither a nightly one nor cargo-fuzz is needed. A panic, a wrapped sum, a run that takes too long or too much memory is a finding:
//! its input is kept under `fuzz/artifacts/`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};

use crate::workspace;

/// What the compiler adds for libFuzzer, as cargo-fuzz has it: counters at every edge, and what is compared with what.
const INSTRUMENTED: [&str; 7] = [
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
    "-Ccodegen-units=1",
    "--cfg=fuzzing",
];

/// A program that is given random inputs.
struct Target {
    name: &'static str,
    /// Folder of the inputs to begin with, in `fuzz/`.
    seeds: &'static str,
    /// Share of the time.
    share: f64,
    /// Seconds after which a run counts as one that does not end: instrumented and checked, the estimator takes several times as long as
    /// it does for users.
    timeout_s: u32,
}

const TARGETS: [Target; 6] = [
    Target { name: "parse_log", seeds: "seeds", share: 0.1, timeout_s: 10 },
    Target { name: "protocol", seeds: "lines", share: 0.05, timeout_s: 10 },
    Target { name: "messages", seeds: "messages", share: 0.05, timeout_s: 10 },
    Target { name: "mcap", seeds: "mcap", share: 0.1, timeout_s: 10 },
    Target { name: "reconstruct", seeds: "seeds", share: 0.25, timeout_s: 60 },
    Target { name: "mutated_log", seeds: "mutations", share: 0.45, timeout_s: 60 },
];

/// Memory of one program at most, megabytes.
const MEMORY_MB: u32 = 1024;

/// Options of `cargo xtask fuzz`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Minutes in all, over all targets
    #[arg(long, default_value = "10")]
    minutes: f64,
    /// Only this target
    #[arg(long, value_name = "TARGET", value_parser = clap::builder::PossibleValuesParser::new(TARGETS.map(|target| target.name)))]
    only: Option<String>,
    /// Programs at a time [default: one for each processor]
    #[arg(long)]
    jobs: Option<u32>,
    /// Seed of the random numbers, for one program; several differ from run to run
    #[arg(long, default_value = "1")]
    seed: u32,
    /// Make the corpus small: keep of the inputs only those that reach something
    #[arg(long)]
    minimise: bool,
}

/// What the programs of one target did.
struct Tally {
    executions: u64,
    findings: usize,
}

/// Builds the targets and runs them one after the other; fails where there is a finding.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if !(arguments.minutes > 0.0 && arguments.minutes.is_finite()) {
        bail!("--minutes must be a positive number, not {}", arguments.minutes);
    }
    let host = host()?;
    let built = workspace::target().join("fuzz");
    let mut build = workspace::cargo();
    build.args([
        "build",
        "--release",
        "--locked",
        "--manifest-path",
        "fuzz/Cargo.toml",
        "--target",
        &host,
        "--target-dir",
    ]);
    // For a named target, build scripts and procedural macros are left as they are.
    workspace::run(build.arg(&built).env("CARGO_ENCODED_RUSTFLAGS", INSTRUMENTED.join("\u{1f}")))?;
    let chosen: Vec<&Target> =
        TARGETS.iter().filter(|target| arguments.only.as_deref().is_none_or(|only| only == target.name)).collect();
    let shares: f64 = chosen.iter().map(|target| target.share).sum();
    println!("\n| target | executions | seconds | findings |\n|---|---:|---:|---:|");
    let mut findings = 0;
    for target in chosen {
        let program = built.join(&host).join("release").join(target.name);
        let seconds = (60.0 * arguments.minutes * target.share / shares).max(1.0) as u64;
        let clock = Instant::now();
        let tally = fuzz(target, &program, seconds, arguments)?;
        if arguments.minimise {
            minimise(target, &program)?;
        }
        println!(
            "| `{}` | {} | {:.0} | {} |",
            target.name,
            tally.executions,
            clock.elapsed().as_secs_f64(),
            tally.findings
        );
        findings += tally.findings;
    }
    if findings > 0 {
        bail!(
            "{findings} findings: their inputs are in fuzz/artifacts; run one again by giving its file to the program in {}",
            built.display()
        );
    }
    Ok(())
}

/// The triple of this machine, as rustc names it.
fn host() -> anyhow::Result<String> {
    let output = Command::new("rustc").arg("-vV").output().context("could not start rustc")?;
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    said.lines()
        .find_map(|line| line.strip_prefix("host: "))
        .map(str::to_owned)
        .with_context(|| format!("rustc -vV does not say its host:\n{said}"))
}

/// The folder of the inputs found so far.
fn corpus(target: &Target) -> PathBuf {
    workspace::root().join("fuzz/corpus").join(target.name)
}

/// The inputs to begin with that are kept in the repository: logs, or what the target makes logs of.
fn seeds(target: &Target) -> PathBuf {
    workspace::root().join("fuzz").join(target.seeds)
}

/// Runs so many seconds on all processors.
fn fuzz(target: &Target, program: &Path, seconds: u64, arguments: &Arguments) -> anyhow::Result<Tally> {
    let (corpus, artifacts) = (corpus(target), workspace::root().join("fuzz/artifacts").join(target.name));
    for folder in [&corpus, &artifacts] {
        fs::create_dir_all(folder).with_context(|| format!("could not make {}", folder.display()))?;
    }
    let logs = workspace::target().join("fuzz").join("logs");
    fs::create_dir_all(&logs)?;
    let processors = std::thread::available_parallelism().map_or(1, |count| count.get() as u32);
    let jobs = arguments.jobs.unwrap_or(processors).max(1);
    let until = Instant::now() + Duration::from_secs(seconds);
    let before = failures(&artifacts)?;
    let mut executions = 0;
    let mut round = 0;
    // A program ends at its first finding; another goes on from where it was.
    loop {
        let left = until.saturating_duration_since(Instant::now()).as_secs();
        if left == 0 {
            break;
        }
        let mut programs = Vec::new();
        for job in 0..jobs {
            let log = logs.join(format!("{}-{job}.log", target.name));
            let mut command = Command::new(program);
            command
                .current_dir(workspace::root())
                .args([&corpus, &seeds(target)])
                .arg(format!("-max_total_time={left}"))
                .arg(format!("-timeout={}", target.timeout_s))
                .arg(format!("-rss_limit_mb={MEMORY_MB}"))
                .arg(format!("-artifact_prefix={}/", artifacts.display()))
                .arg(format!("-seed={}", arguments.seed + job + jobs * round))
                .args(["-print_final_stats=1", "-reload=30", "-max_len=8192"])
                .env("RAYON_NUM_THREADS", "1")
                .stdout(Stdio::null())
                .stderr(fs::File::create(&log)?);
            let child = command.spawn().with_context(|| format!("could not start {}", program.display()))?;
            programs.push((child, log));
        }
        for (mut child, log) in programs {
            child.wait()?;
            executions += executed(&fs::read_to_string(&log).unwrap_or_default());
        }
        round += 1;
    }
    Ok(Tally { executions, findings: failures(&artifacts)?.saturating_sub(before) })
}

/// The executions that libFuzzer says it made, or the last that it told of.
fn executed(said: &str) -> u64 {
    let number = |text: &str| text.trim().parse::<u64>().ok();
    let in_the_end =
        said.lines().rev().find_map(|line| line.strip_prefix("stat::number_of_executed_units:").and_then(number));
    let last_told = || {
        let mut told = said.lines().rev().filter_map(|line| line.strip_prefix('#'));
        told.find_map(|line| line.split_ascii_whitespace().next().and_then(number))
    };
    in_the_end.or_else(last_told).unwrap_or(0)
}

/// Inputs kept in a folder on which a program failed; those on which it was only slow do not count.
fn failures(folder: &Path) -> anyhow::Result<usize> {
    let slow = |entry: &fs::DirEntry| entry.file_name().to_string_lossy().starts_with("slow-unit-");
    Ok(fs::read_dir(folder)?.filter_map(Result::ok).filter(|entry| !slow(entry)).count())
}

/// Keeps of the inputs found only those that reach what the others do not.
fn minimise(target: &Target, program: &Path) -> anyhow::Result<()> {
    let (corpus, small) = (corpus(target), corpus(target).with_extension("small"));
    fs::create_dir_all(&small)?;
    let merged = Command::new(program)
        .args([&small, &corpus])
        .args(["-merge=1", "-max_len=4096"])
        .env("RAYON_NUM_THREADS", "1")
        .stderr(Stdio::null())
        .status()?;
    if !merged.success() {
        bail!("the corpus of {} could not be made small ({merged})", target.name);
    }
    fs::remove_dir_all(&corpus)?;
    fs::rename(&small, &corpus).context("could not replace the corpus")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn executions_are_those_of_the_end_or_the_last_told() {
        assert_eq!(executed("#8\tpulse\n#16 NEW\nstat::number_of_executed_units: 31\nstat::x: 4\n"), 31);
        assert_eq!(executed("INFO: x\n#8\tpulse\n#16\tNEW cov: 5\n== ERROR\n"), 16);
        assert_eq!(executed(""), 0);
    }

    #[test]
    fn every_target_is_one_of_the_fuzz_workspace() {
        let manifest = fs::read_to_string(workspace::root().join("fuzz/Cargo.toml")).expect("the manifest");
        for target in TARGETS {
            assert!(manifest.contains(&format!("name = \"{}\"", target.name)), "{}", target.name);
        }
        assert_eq!(manifest.matches("[[bin]]").count(), TARGETS.len());
    }
}
