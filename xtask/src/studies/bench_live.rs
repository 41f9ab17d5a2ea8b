//! `cargo xtask bench-live`: how long the online estimator takes for a sample, how much memory it has, when its first certified answer is there, and how far
//! its estimates are from those of the batch estimator.
//!
//! A stream is replayed as fast as it is taken. Times are those of the processor, which hardly depend on what else the machine does: of a sample, what the thread spends that takes it
//! in (a search is on another); all together, what the program spends, as on one core.

use std::hash::{DefaultHasher, Hash, Hasher};

use anyhow::Context;
use palpate::live::{Estimate, Live};
use palpate::palms::PalmMotion;
use palpate::sensor::Touchpad;
use palpate::shape::{RandomShape, random_shape};
use palpate::simulate::{SimulateOptions, Simulation, simulate};
use palpate::{Log, Sample};

use super::tables::{LIVE_DISTANCE, LIVE_SPEED, Table, Write};

/// Standard deviation of the contact positions, metres.
const NOISE_SD_M: f64 = 1e-4;
/// Time of a random motion, which has up to six swings of each palm, seconds.
const PERIOD_S: f64 = 60.0;
/// Prefixes of a log that the batch estimator is tried on grow by this.
const GROWTH: f64 = 1.1;
/// The shortest of them, samples.
const SHORTEST: usize = 100;
/// Distances are measured at these multiples of the first certified sample, as far as the log goes: half of them at a young answer.
const LATER: [f64; 6] = [1.25, 1.75, 2.5, 4.0, 8.0, 16.0];
/// Up to so many times an answer is young: with few samples each changes noise and harmonics.
const SOON: f64 = 2.0;

/// An orientation is wrong beyond so many of its own error bars and beyond two degrees.
const WRONG_SDS: f64 = 5.0;
const WRONG_RAD: f64 = 0.035;

/// Options of `cargo xtask bench-live`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Length of the streams, minutes
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// Length of one more stream at 100 Hz, minutes
    #[arg(long)]
    long_minutes: Option<f64>,
    /// Logs of which the first certified answer is looked for, 100 Hz
    #[arg(long, default_value_t = 20)]
    logs: u64,
    /// Seed of the first of them
    #[arg(long, default_value_t = 5_600_001)]
    seed: u64,
    /// Only print a digest of all estimates of so many samples at 100 Hz: it must not depend on `RAYON_NUM_THREADS`
    #[arg(long, value_name = "SAMPLES")]
    digest: Option<u32>,
    #[command(flatten)]
    write: Write,
}

/// Measures and prints.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if let Some(count) = arguments.digest {
        println!("{:016x}", digest(count, arguments.seed)?);
        return Ok(());
    }
    arguments.write.check(&[LIVE_SPEED, LIVE_DISTANCE])?;
    let mut speed = String::from(
        "| stream | p50 | p99 | p99.9 | max | searches | all together | times real time | memory after a minute, at the end |\n\
         |---|---:|---:|---:|---:|---:|---:|---:|---:|\n",
    );
    let long = arguments.long_minutes.map(|minutes| (100.0, minutes));
    for (rate_hz, minutes) in [(100.0, arguments.minutes), (1000.0, arguments.minutes)].into_iter().chain(long) {
        let row = stream(rate_hz, 60.0 * minutes, arguments.seed)?;
        println!("{row}");
        speed.push_str(&row);
    }
    let mut firsts = Vec::new();
    for seed in arguments.seed..arguments.seed + arguments.logs {
        if let Some(first) = first_certified(seed)? {
            println!("seed {seed}: {first:?}");
            firsts.push(first);
        }
    }
    let distance = table_of(&firsts, arguments.logs);
    println!("\n{speed}\n{distance}");
    let long = arguments.long_minutes.map_or_else(String::new, |minutes| format!(" --long-minutes {minutes}"));
    let command = format!(
        "cargo xtask bench-live --minutes {}{long} --logs {} --seed {}",
        arguments.minutes, arguments.logs, arguments.seed
    );
    let tables: [Table; 2] = [(LIVE_SPEED, speed), (LIVE_DISTANCE, distance)];
    arguments.write.tables(&tables, &command)
}

/// A random object while palms repeat a random motion, which ends as it begins.
fn samples(seed: u64, rate_hz: f64, duration_s: f64) -> anyhow::Result<Vec<Sample>> {
    Ok(simulation(seed, rate_hz, duration_s)?.log.samples)
}

/// The same with the truth.
fn simulation(seed: u64, rate_hz: f64, duration_s: f64) -> anyhow::Result<Simulation> {
    let shape = random_shape(&RandomShape::default(), seed)?;
    let once = PalmMotion::random(seed, PERIOD_S, 1.0)?.sample(rate_hz)?;
    let palms = once[..once.len() - 1].iter().cycle().map(|(_, palms)| *palms);
    let motion: Vec<_> =
        (0..(duration_s * rate_hz) as u32).map(|index| f64::from(index) / rate_hz).zip(palms).collect();
    let touchpad = Touchpad { noise_sd_m: NOISE_SD_M, ..Touchpad::ideal() };
    Ok(simulate(&shape, &motion, &SimulateOptions { touchpad, seed, ..SimulateOptions::default() })?)
}

/// Of every estimate of a stream, to the bit.
fn digest(count: u32, seed: u64) -> anyhow::Result<u64> {
    const RATE_HZ: f64 = 100.0;
    let samples = samples(seed, RATE_HZ, f64::from(count) / RATE_HZ)?;
    let mut live = Live::default();
    let mut hasher = DefaultHasher::new();
    for sample in &samples {
        let estimate = live.push(sample);
        let pose = estimate.pose.iter().flat_map(|pose| [pose.psi_rad, pose.psi_sd_rad, pose.com_x_m, pose.com_y_m]);
        let outline = estimate.outline.iter().flat_map(|point| [point.r_m, point.r_sd_m]);
        pose.chain(outline).chain([estimate.coverage]).for_each(|value| value.to_bits().hash(&mut hasher));
        (estimate.hypotheses, estimate.searched, estimate.is_certified(), estimate.reason()).hash(&mut hasher);
    }
    Ok(hasher.finish())
}

/// A row of the first table.
fn stream(rate_hz: f64, duration_s: f64, seed: u64) -> anyhow::Result<String> {
    let samples = samples(seed, rate_hz, duration_s)?;
    let mut live = Live::default();
    let (mut pushes_ms, mut searches, mut searched) = (Vec::with_capacity(samples.len()), 0, 0);
    let mut after_a_minute = None;
    let begun_s = processor_s(Of::Program);
    for sample in &samples {
        let from_s = processor_s(Of::Thread);
        let estimate = live.push(sample);
        pushes_ms.push(1e3 * (processor_s(Of::Thread) - from_s));
        searches += usize::from(estimate.searched != searched);
        searched = estimate.searched;
        if after_a_minute.is_none() && sample.time_s >= 60.0 {
            after_a_minute = resident_mb();
        }
    }
    let all_s = processor_s(Of::Program) - begun_s;
    let at_end = resident_mb();
    pushes_ms.sort_by(f64::total_cmp);
    let at = |share: f64| pushes_ms.get(((pushes_ms.len() - 1) as f64 * share) as usize).copied().unwrap_or(f64::NAN);
    let megabytes = |value: Option<f64>| value.map_or_else(|| "?".to_owned(), |value| format!("{value:.0} MB"));
    Ok(format!(
        "| {} min at {rate_hz} Hz | {:.3} ms | {:.3} ms | {:.2} ms | {:.1} ms | {searches} | {all_s:.0} s | {:.0} | {}, {} |\n",
        duration_s / 60.0,
        at(0.5),
        at(0.99),
        at(0.999),
        at(1.0),
        duration_s / all_s,
        megabytes(after_a_minute),
        megabytes(at_end),
    ))
}

/// Whose time is meant.
#[derive(Clone, Copy)]
enum Of {
    Thread,
    Program,
}

/// Time of the processor so far, seconds.
#[cfg(unix)]
fn processor_s(of: Of) -> f64 {
    use rustix::time::{ClockId, clock_gettime};
    let time = clock_gettime(match of {
        Of::Thread => ClockId::ThreadCPUTime,
        Of::Program => ClockId::ProcessCPUTime,
    });
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Where the system does not tell it, the time by the clock.
#[cfg(not(unix))]
fn processor_s(_: Of) -> f64 {
    static BEGUN: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    BEGUN.get_or_init(std::time::Instant::now).elapsed().as_secs_f64()
}

/// Resident memory of this process, where the system tells it.
fn resident_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.split_whitespace().next()?.parse::<f64>().ok().map(|kilobytes| kilobytes / 1024.0)
}

/// When a log has its first certified answer, and how far the estimates behind it are from the batch estimator.
#[derive(Debug)]
struct First {
    live: usize,
    batch: usize,
    /// How many times the samples of the first certified estimate there were, and standard deviations.
    distances: Vec<(f64, f64)>,
    /// Share of the estimates from the first certified one on that are certified.
    certified: f64,
    /// Certified estimates, and those of which the orientation is wrong.
    estimates: usize,
    wrong: usize,
}

/// `None` where the live estimator certifies nothing.
fn first_certified(seed: u64) -> anyhow::Result<Option<First>> {
    let (shape, Simulation { log: Log { samples }, truth, .. }) =
        (random_shape(&RandomShape::default(), seed)?, simulation(seed, 100.0, 60.0)?);
    let mut live = Live::default();
    let (mut first, mut certified, mut wrong) = (None, 0_usize, 0);
    let mut behind: Vec<(usize, Estimate)> = Vec::new();
    for (index, sample) in samples.iter().enumerate() {
        let (count, estimate) = (index + 1, live.push(sample));
        if estimate.is_certified() {
            first = first.or(Some(count));
            certified += 1;
            let psi = [truth.motion[0].psi_rad, truth.motion[index].psi_rad];
            let limit = estimate.pose.map_or(f64::INFINITY, |pose| WRONG_RAD.max(WRONG_SDS * pose.psi_sd_rad));
            wrong += usize::from(estimate.psi_error_rad(&shape, psi).is_some_and(|off| off > limit));
        }
        let due = first.is_some_and(|first| LATER.iter().any(|times| (times * first as f64) as usize == count));
        if due && estimate.is_certified() {
            behind.push((count, estimate.clone()));
        }
    }
    let Some(first) = first else { return Ok(None) };
    let prefix = |count: usize| palpate::reconstruct(&Log { samples: samples[..count].to_vec() });
    let mut count = SHORTEST;
    while count < first && !prefix(count).is_ok_and(|found| found.is_certified()) {
        count = (GROWTH * count as f64).ceil() as usize;
    }
    let mut distances = Vec::new();
    for (count, estimate) in behind {
        let found = prefix(count).context("a prefix that was certified live")?;
        distances.extend(estimate.distance_sds(&found).map(|sds| (count as f64 / first as f64, sds)));
    }
    let share = certified as f64 / (samples.len() - first + 1) as f64;
    Ok(Some(First { live: first, batch: count.min(first), distances, certified: share, estimates: certified, wrong }))
}

/// The second table.
fn table_of(firsts: &[First], logs: u64) -> String {
    let quantiles = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        [0.1, 0.5, 0.9].map(|share| {
            values.get((share * (values.len().saturating_sub(1)) as f64).round() as usize).copied().unwrap_or(f64::NAN)
        })
    };
    let row = |name: &str, [low, middle, high]: [f64; 3], digits: usize| {
        format!("| {name} | {low:.digits$} | {middle:.digits$} | {high:.digits$} |\n")
    };
    let mut table = format!(
        "| of {logs} logs, {} with a certified answer | 10 % | median | 90 % |\n|---|---:|---:|---:|\n",
        firsts.len()
    );
    let live = firsts.iter().map(|first| first.live as f64).collect();
    table.push_str(&row("samples at the first certified estimate", quantiles(live), 0));
    let ratios = firsts.iter().map(|first| first.live as f64 / first.batch as f64).collect();
    table.push_str(&row("the same over the first prefix that the batch estimator certifies", quantiles(ratios), 2));
    let distances = |is_meant: fn(f64) -> bool| {
        let all = firsts.iter().flat_map(|first| first.distances.iter().copied());
        quantiles(all.filter(|(times, _)| is_meant(*times)).map(|(_, sds)| sds).collect())
    };
    let soon = distances(|times| times < SOON);
    table.push_str(&row("distance from the batch estimator, standard deviations, soon after the first", soon, 2));
    let later = distances(|times| times >= SOON);
    table.push_str(&row("the same from twice as many samples on", later, 2));
    let certified = firsts.iter().map(|first| first.certified).collect();
    table.push_str(&row("share of the estimates after that which are certified", quantiles(certified), 2));
    let (all, wrong) = firsts.iter().fold((0, 0), |(all, wrong), first| (all + first.estimates, wrong + first.wrong));
    table + &format!("| certified estimates with a wrong orientation: {wrong} of {all} | | | |\n")
}
