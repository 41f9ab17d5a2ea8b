//! Sweeps as a user runs them: on one thread and on two, killed and taken up again, on bad plans.

mod common;

use std::fs;
use std::path::Path;
use std::process::Stdio;

use common::{Ran, command, folder, names, palpate};

/// Short logs, by a method that does not take long.
const PLAN: &str = r#"
kind = "simulate"
trials = 4
samples = 60
objects.ellipse = { axis_ratio = [0.6, 0.8] }
touchpads = [{ noise_sd_m = 0.1e-3 }]
reconstruct.method = "ode"
"#;
const JOBS: usize = 8;

fn sweep(dir: &Path, out: &str, more: &[&str]) -> Ran {
    palpate(dir, &[&["sweep", "plan.toml", "-o", out], more].concat())
}

fn write_plan(dir: &Path, plan: &str) {
    fs::write(dir.join("plan.toml"), plan).expect("the plan is written");
}

fn results(dir: &Path, out: &str) -> Vec<u8> {
    fs::read(dir.join(out).join("results.parquet")).expect("there is a table")
}

/// Whole lines of a journal, if there is one.
fn journal(dir: &Path, out: &str) -> Vec<String> {
    let text = fs::read_to_string(dir.join(out).join("journal.jsonl")).unwrap_or_default();
    text.split_inclusive('\n').filter(|line| line.ends_with('\n')).map(str::to_owned).collect()
}

/// The number of the job that a line of a journal is about.
fn job(line: &str) -> u64 {
    let entry: serde_json::Value = serde_json::from_str(&line[17..]).expect("JSON after the digest");
    entry["row"]["job"].as_u64().expect("a number")
}

/// Starts a sweep and kills it as soon as two jobs are finished; whether there was anything left to do. If not, all is as before.
fn killed_after_two_jobs(dir: &Path, out: &str) -> bool {
    let mut running = command(dir, &["sweep", "plan.toml", "-o", out, "--threads", "1"])
        .stdout(Stdio::null())
        .spawn()
        .expect("the program starts");
    while journal(dir, out).len() < 3 && running.try_wait().expect("it can be asked").is_none() {
        std::thread::yield_now();
    }
    // It may have ended by now.
    let _ = running.kill();
    running.wait().expect("it is dead");
    let in_time = journal(dir, out).len() <= JOBS;
    if !in_time {
        fs::remove_dir_all(dir.join(out)).expect("there is a folder");
    }
    in_time
}

#[test]
fn the_table_is_the_same_on_any_number_of_threads_and_after_a_kill() {
    let dir = folder();
    write_plan(dir.path(), PLAN);
    let ran = sweep(dir.path(), "one", &["--threads", "1"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.starts_with("8 jobs: 8 reconstructed"), "{}", ran.stdout);
    assert_eq!(names(&dir.path().join("one")), ["journal.jsonl", "results.parquet", "seconds.csv"]);
    assert_eq!(sweep(dir.path(), "two", &["--threads", "2"]).code, Some(0));
    assert!(results(dir.path(), "one") == results(dir.path(), "two"), "threads change the table");

    let killed_in_time = (0..100).any(|_| killed_after_two_jobs(dir.path(), "killed"));
    assert!(killed_in_time, "it always ended before it could be killed");
    let before = journal(dir.path(), "killed");
    assert!(!dir.path().join("killed/results.parquet").exists());

    let ran = sweep(dir.path(), "killed", &["--threads", "2"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let said = format!("8 jobs, {} of them finished before: ", before.len() - 1);
    assert!(ran.stdout.starts_with(&said), "{}", ran.stdout);
    let after = journal(dir.path(), "killed");
    assert_eq!(after[..before.len()], before, "what was finished is kept");
    let mut jobs: Vec<u64> = after[1..].iter().map(|line| job(line)).collect();
    jobs.sort_unstable();
    assert_eq!(jobs, (0..JOBS as u64).collect::<Vec<_>>(), "each job is done once");
    assert!(results(dir.path(), "one") == results(dir.path(), "killed"), "a kill changes the table");
}

#[test]
fn what_is_damaged_is_done_again() {
    let dir = folder();
    write_plan(dir.path(), PLAN);
    assert_eq!(sweep(dir.path(), "out", &[]).code, Some(0));
    let (whole, lines) = (results(dir.path(), "out"), journal(dir.path(), "out"));
    let number = job(&lines[3]);
    // One line changed where it still is JSON, the last one cut off, and the table lost.
    let mut damaged = lines.clone();
    damaged[3] = damaged[3].replacen(r#""status":"reconstructed""#, r#""status":"no-result""#, 1);
    assert_ne!(damaged[3], lines[3]);
    let last = damaged.last_mut().expect("a line");
    last.truncate(last.len() / 2);
    fs::write(dir.path().join("out/journal.jsonl"), damaged.concat()).expect("the journal is written");
    fs::write(dir.path().join("out/results.parquet"), &whole[..whole.len() / 2]).expect("the table is written");

    let ran = sweep(dir.path(), "out", &[]);
    assert!(ran.stdout.starts_with("8 jobs, 6 of them finished before: 8 reconstructed"), "{}", ran.stdout);
    assert!(results(dir.path(), "out") == whole, "the table is whole again");
    let mut again: Vec<u64> = journal(dir.path(), "out")[lines.len() - 1..].iter().map(|line| job(line)).collect();
    again.sort_unstable();
    let mut expected = [number, job(&lines[lines.len() - 1])];
    expected.sort_unstable();
    assert_eq!(again, expected, "these two are done again, and no other");

    // A journal that ends within its first line is begun again; one that begins with anything else is not touched.
    fs::write(dir.path().join("out/journal.jsonl"), &lines[0][..20]).expect("the journal is written");
    assert!(sweep(dir.path(), "out", &[]).stdout.starts_with("8 jobs: 8 reconstructed"));
    assert!(results(dir.path(), "out") == whole);
    fs::write(dir.path().join("out/journal.jsonl"), "my diary\n").expect("the diary is written");
    let ran = sweep(dir.path(), "out", &[]);
    assert_eq!(ran.code, Some(2));
    assert_eq!(
        ran.stderr,
        "error: out/journal.jsonl: this is not the journal of a sweep, or its first line is damaged; choose another folder, or delete the file to start again\n"
    );
    assert_eq!(journal(dir.path(), "out"), ["my diary\n"]);
}

#[test]
fn another_plan_in_the_same_folder_is_refused() {
    let dir = folder();
    let short = PLAN.replace("trials = 4", "trials = 1");
    write_plan(dir.path(), &short);
    assert_eq!(sweep(dir.path(), "out", &["--quiet"]).stdout, "");
    let before = results(dir.path(), "out");
    write_plan(dir.path(), &short.replace("0.1e-3", "0.2e-3"));
    let ran = sweep(dir.path(), "out", &[]);
    assert_eq!((ran.code, ran.stdout.as_str()), (Some(2), ""));
    assert_eq!(
        ran.stderr,
        "error: out: the folder holds another sweep of 2 jobs: the plan, or a log that it names, has changed since; choose another folder, or delete this one to start again\n"
    );
    assert!(results(dir.path(), "out") == before, "nothing is written");
    // What a plan says counts, not how it says it.
    write_plan(dir.path(), &(short.replace("0.1e-3", "[0.000_1]") + "# a comment\n"));
    assert_eq!(sweep(dir.path(), "out", &[]).code, Some(0));
}

#[test]
fn a_table_of_someone_else_is_left_alone() {
    let dir = folder();
    write_plan(dir.path(), PLAN);
    fs::create_dir(dir.path().join("out")).expect("a folder");
    fs::write(dir.path().join("out/results.parquet"), "precious").expect("a file");
    let ran = sweep(dir.path(), "out", &[]);
    assert_eq!(ran.code, Some(2));
    assert_eq!(
        ran.stderr,
        "error: out/results.parquet: a file of that name exists, but no sweep that it could be a result of; choose another folder\n"
    );
    assert_eq!(results(dir.path(), "out"), b"precious");
    assert_eq!(names(&dir.path().join("out")), ["results.parquet"]);
}

#[test]
fn bad_plans_are_refused_with_their_place() {
    let good = "kind = \"simulate\"\nobjects.named = { name = \"egg\" }\ntouchpads = [{ noise_sd_m = 0.1e-3 }]\n";
    let huge = format!(
        "kind = \"simulate\"\nobjects.fourier = {{ order = [{0}], mean_radius_m = [{0}] }}\ntouchpads = [{{}}]\n",
        "3, ".repeat(2000)
    );
    let cases: &[(&str, &str)] = &[
        ("", ": missing field `kind`"),
        ("kind = \"simulate", ", line 1: "),
        ("kind = \"guess\"", ", line 1, kind: unknown variant `guess`, expected `simulate` or `reconstruct`"),
        ("kind = \"simulate\"", ", objects: there is no object; add one, such as objects.named = { name = \"egg\" }"),
        (
            "kind = \"simulate\"\nobjects.mixed = {}",
            ", touchpads: there is no touchpad; add one, such as touchpads = [{ noise_sd_m = 0.1e-3 }]",
        ),
        (&good.replace("objects", "trails = 3\nobjects"), ", line 2, trails: unknown field `trails`, expected one of "),
        (&good.replace("objects", "trials = 0\nobjects"), ", line 2, trials: at least one is needed"),
        (
            &good.replace("objects", "samples = [100, 3]\nobjects"),
            ", line 2, samples[1]: a whole number from 12 to 1000000",
        ),
        (
            &good.replace("objects", "motions = [\"turn\", \"spin\"]\nobjects"),
            ", line 2, motions[1]: unknown variant `spin`",
        ),
        (&good.replace("objects", "motions = []\nobjects"), ", line 2, motions: the list is empty"),
        (&good.replace("egg", "eggs"), ", line 2, objects.named.name: no shape is named \"eggs\"; known are circle, "),
        (&good.replace("0.1e-3", "-1"), ", line 3, touchpads[0].noise_sd_m: it must not be below 0"),
        (&good.replace("0.1e-3", "nan"), ", line 3, touchpads[0].noise_sd_m: it must not be below 0"),
        (&good.replace("0.1e-3", "[0, \"much\"]"), ", line 3, touchpads[0].noise_sd_m[1]: invalid type: string"),
        (
            &(good.to_owned() + "reconstruct.harmonics = 1"),
            ", line 4, reconstruct.harmonics: a whole number from 2 to 64",
        ),
        (
            &good.replace("objects", "seed = 18446744073709551615\nobjects"),
            ", line 2, seed: a whole number up to 9007199254740992 is needed",
        ),
        (&good.replace("objects", "trials = 1_000_001\nobjects"), ": more than 1000000 jobs; split the plan"),
        (&huge, ": more than 1000000 jobs; split the plan into several"),
        (
            "kind = \"reconstruct\"\nlogs = [\"plan.toml\", \"*.csv\"]",
            ", logs: no log is named \"*.csv\"; paths are relative to the folder of the plan",
        ),
        ("kind = \"reconstruct\"\nlogs = \"a***\"", ", logs: \"a***\" is not a pattern for file names: "),
        (
            "kind = \"reconstruct\"\nlogs = \"plan.toml\"\nscore.bound = true",
            ", line 3, score.bound: unknown field `bound`",
        ),
    ];
    for (plan, expected) in cases {
        let dir = folder();
        write_plan(dir.path(), plan);
        let ran = sweep(dir.path(), "out", &[]);
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(2), ""), "{plan}");
        let expected = format!("error: plan.toml{expected}");
        assert!(ran.stderr.starts_with(&expected), "{plan}\n{}\n{expected}", ran.stderr);
        assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
        assert_eq!(names(dir.path()), ["plan.toml"], "something was written");
    }
    let dir = folder();
    let ran = sweep(dir.path(), "out", &[]);
    assert_eq!(ran.code, Some(2));
    assert!(ran.stderr.starts_with("error: plan.toml: the plan cannot be read: "), "{}", ran.stderr);
    fs::write(dir.path().join("plan.toml"), [0xff, 0xfe, 0, 1]).expect("bytes");
    assert!(sweep(dir.path(), "out", &[]).stderr.starts_with("error: plan.toml: the plan cannot be read: "));
}
