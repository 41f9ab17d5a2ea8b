//! What a sweep puts into its table, and that a job is the same wherever it is run.

use std::fs;
use std::num::NonZero;
use std::path::{Path, PathBuf};

use palpate::sensor::Calibration;
use palpate_sweep::columns::column_names;
use palpate_sweep::table::results_parquet;
use palpate_sweep::{Done, Job, Source, Status, Sweep, SweepError, parse_plan, read_plan};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;

const TWO: NonZero<usize> = NonZero::new(2).expect("two");

/// A file beside the tests.
fn beside(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(path)
}

fn sweep(plan: &str, base: &Path) -> Sweep {
    let plan = parse_plan("plan.toml", plan).expect("a plan");
    Sweep::new(&plan, base).expect("jobs")
}

const SHORT: &str = r#"
kind = "simulate"
trials = 1
samples = 150
objects.named = { name = ["egg", "ellipse"] }
touchpads = [{ noise_sd_m = 0.1e-3 }, { counts_per_inch = 200 }]
score = { reference = true, bound = true }
"#;

#[test]
fn the_table_holds_the_rows() {
    let outcomes = sweep(SHORT, Path::new(".")).run(TWO, &mut |_| ()).expect("outcomes");
    let bytes = results_parquet(&outcomes).expect("a table");
    let alone = sweep(SHORT, Path::new(".")).run(NonZero::<usize>::MIN, &mut |_| ()).expect("outcomes");
    assert!(results_parquet(&alone).expect("a table") == bytes, "threads change the table");
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("results.parquet");
    fs::write(&path, bytes).expect("a file");
    let reader = SerializedFileReader::try_from(path.as_path()).expect("a Parquet file");
    let rows: Vec<_> = reader.get_row_iter(None).expect("rows").map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), 4);
    for (row, outcome) in rows.iter().zip(&outcomes) {
        // Every column against the field of its name, by way of JSON.
        let json = serde_json::to_value(&outcome.row).expect("JSON");
        let columns: Vec<_> = row.get_column_iter().collect();
        assert_eq!(columns.len(), json.as_object().expect("an object").len(), "a field has no column");
        for (name, field) in columns {
            let value = match field {
                Field::Null => serde_json::Value::Null,
                Field::Bool(value) => (*value).into(),
                Field::Long(value) => (*value).into(),
                Field::Double(value) => (*value).into(),
                Field::Str(value) => value.clone().into(),
                other => panic!("{name} holds {other:?}"),
            };
            assert_eq!(value, json[name.as_str()], "{name}");
        }
    }
    let first = &outcomes[0].row;
    assert_eq!((first.job, first.seed, first.samples), (0, Some(1), Some(150)));
    assert_eq!((first.noise_sd_m, first.counts_per_inch), (Some(0.1e-3), None));
    assert_eq!(first.status, Status::Reconstructed);
    assert!(first.solved.is_some() && first.wrong.is_some() && first.bound_r_m.is_some());
    assert!((first.mean_radius_m.expect("a radius") - 0.03).abs() < 1e-12);
}

#[test]
fn a_job_without_a_log_says_of_which_object() {
    let short = "kind = \"simulate\"\ntrials = 1\nsamples = 25\nmotions = [\"random-jump-free\"]\nobjects.named = { name = [\"egg\"] }\ntouchpads = [{ noise_sd_m = 0.1e-3 }]\n";
    let outcomes = sweep(short, Path::new(".")).run(TWO, &mut |_| ()).expect("outcomes");
    let row = &outcomes[0].row;
    assert_eq!((row.status, row.object.as_str()), (Status::NoLog, "egg"), "{}", row.reason);
    assert!(row.reason.contains("no motion out of"), "{}", row.reason);
}

#[test]
fn a_job_that_travels_gives_the_same_row() {
    let sweep = sweep(SHORT, Path::new("."));
    let here = sweep.outcome(3).expect("a job").row;
    let letter = serde_json::to_string(&sweep.jobs[3]).expect("JSON");
    let there: Job = serde_json::from_str(&letter).expect("a job");
    assert_eq!(there, sweep.jobs[3]);
    let row = there.run(3, Path::new("elsewhere")).row;
    assert_eq!(row, here);
    let answer = serde_json::to_string(&row).expect("JSON");
    assert_eq!(serde_json::from_str::<palpate_sweep::Row>(&answer).expect("a row"), here, "to the last bit");
    assert_eq!(sweep.outcome(4), None);
}

#[test]
fn logs_are_reconstructed_and_held_against_the_truths_beside_them() {
    let dir = tempfile::tempdir().expect("a folder");
    let Source::Simulate(job) = sweep(SHORT, Path::new(".")).jobs[0].source.clone() else { panic!("a simulation") };
    let simulation = job.simulate().expect("a log").simulation;
    let logs = dir.path().join("logs [1]");
    fs::create_dir(&logs).expect("a folder");
    for name in ["known.csv", "unknown.csv", "wrong.csv"] {
        palpate_io::write_log(&logs.join(name), &simulation.log, &[]).expect("a log");
    }
    palpate_io::write_truth(&logs.join("known.truth"), &simulation.truth).expect("a truth");
    let mut short = simulation.truth.clone();
    short.motion.pop();
    palpate_io::write_truth(&logs.join("wrong.truth"), &short).expect("a truth");
    fs::write(logs.join("broken.csv"), "time_s\n1\n").expect("a file");
    let plan = "kind = \"reconstruct\"\nlogs = [\"known.csv\", \"*.csv\"]\nscore.reference = true\nreconstruct.method = \"quadrature\"\n";
    let swept = sweep(plan, &logs);
    let rows: Vec<_> = swept.run(TWO, &mut |_| ()).expect("outcomes").into_iter().map(|outcome| outcome.row).collect();
    let told: Vec<_> = rows.iter().map(|row| (row.object.as_str(), row.status, row.rms_r_m.is_some())).collect();
    assert_eq!(
        told,
        [
            ("known.csv", Status::Reconstructed, true),
            ("broken.csv", Status::NoLog, false),
            ("unknown.csv", Status::Reconstructed, false),
            ("wrong.csv", Status::NoLog, false),
        ]
    );
    assert!(rows[0].solved.is_some());
    assert!(
        rows[1].reason.starts_with("broken.csv, line 1: there are no columns for phi1, phi2, s1 and s2"),
        "{}",
        rows[1].reason
    );
    assert_eq!(rows[3].reason, "the truth has 149 poses, the log 150 samples; they do not belong together");

    // A machine that sees other logs, or none, gives no row.
    assert_eq!(swept.jobs[0].run_elsewhere(0, &logs).expect("the same logs").row, rows[0]);
    assert_eq!(swept.jobs[1].run_elsewhere(1, &logs).expect("the same broken log").row, rows[1]);
    let refused = swept.jobs[0].run_elsewhere(0, Path::new("elsewhere")).expect_err("no log");
    assert!(matches!(&refused, SweepError::OtherLog { log, .. } if log == "known.csv"), "{refused}");

    // A log that has changed makes another sweep.
    let out = dir.path().join("out");
    swept.run_in(&out, TWO, &mut |_| ()).expect("outcomes");
    fs::write(logs.join("broken.csv"), "time_s\n2\n").expect("a file");
    let refused = sweep(plan, &logs).run_in(&out, TWO, &mut |_| ()).expect_err("another sweep");
    assert!(matches!(refused, SweepError::OtherPlan { jobs: 4, .. }), "{refused}");
}

/// A rig as sure of its angles as of nothing else.
const RIG: &str = "[angles]\nphi1_zero_sd_deg = 0\nphi2_zero_sd_deg = 0\n";

#[test]
fn simulated_logs_are_those_of_rigs_that_are_drawn() {
    let dir = tempfile::tempdir().expect("a folder");
    fs::write(dir.path().join("rig.toml"), RIG).expect("a file");
    let plan = |rig: &str| {
        format!(
            "kind = \"simulate\"\ntrials = 2\nsamples = 600\nmotions = \"random\"\ntouchpads = [{{ noise_sd_m = 5e-5 }}]\n\
             objects.named = {{ name = \"pebble\" }}\nscore = {{ reference = true, bound = true }}\n{rig}"
        )
    };
    let of = |rig: &str| sweep(&plan(rig), dir.path());
    let job = |sweep: &Sweep| match &sweep.jobs[1].source {
        Source::Simulate(job) => job.clone(),
        other => panic!("{other:?}"),
    };
    let drawn = of("rig = \"rig.toml\"");
    let (exact, erring) = (job(&of("")).simulate().expect("a log"), job(&drawn).simulate().expect("a log"));
    let calibration = erring.calibration;
    assert_eq!((exact.calibration, exact.simulation.truth), (Calibration::default(), erring.simulation.truth));
    assert_eq!(calibration.distorted(&exact.simulation.log), erring.simulation.log);
    assert!(calibration.zero_m != [0.0; 2] && calibration.angle_zero_rad == [0.0; 2]);
    assert!((calibration.scale[0] + calibration.scale[1] - 2.0).abs() < 1e-12, "the size is as stated");
    // Reconstructed by what the file says, and the constants held against those that were drawn.
    let rows: Vec<_> = drawn.run(TWO, &mut |_| ()).expect("outcomes").into_iter().map(|outcome| outcome.row).collect();
    for row in &rows {
        assert!(row.certified && row.wrong == Some(false), "{row:?}");
        assert!(row.constants_inside_band.is_some_and(|share| share >= 0.6), "{row:?}");
        assert!(row.worst_constant_sds.is_some_and(|sds| sds > 0.0 && sds < 4.0), "{row:?}");
    }
    // What the rig leaves open makes the bound larger.
    let known = of("rig = \"exact\"").outcome(1).expect("a job").row;
    assert_eq!((known.constants_inside_band, known.worst_constant_sds), (None, None));
    assert!(rows[1].bound_r_m > known.bound_r_m && known.bound_r_m.is_some());
    // A plan without a rig is the sweep that it was.
    assert!(!serde_json::to_string(&of("").jobs[0]).expect("JSON").contains("rig"));
    fs::write(dir.path().join("rig.toml"), "[palm1]\nzero_mm = \"far\"\n").expect("a file");
    let plan = parse_plan("plan.toml", &plan("rig = \"rig.toml\"")).expect("a plan");
    let refused = Sweep::new(&plan, dir.path()).expect_err("no rig").to_string();
    assert!(refused.starts_with("plan.toml, rig: ") && refused.contains("rig.toml, line 2"), "{refused}");
}

#[test]
fn logs_are_taken_by_the_rig_of_the_plan_or_their_own() {
    let dir = tempfile::tempdir().expect("a folder");
    let plan = SHORT.replace("samples = 150", "samples = 300");
    let Source::Simulate(job) = sweep(&plan, Path::new(".")).jobs[0].source.clone() else { panic!("a simulation") };
    let simulation = job.simulate().expect("a log").simulation;
    let exact = [("rig".to_owned(), "exact".to_owned())];
    palpate_io::write_log(&dir.path().join("said.csv"), &simulation.log, &exact).expect("a log");
    palpate_io::write_log(&dir.path().join("unsaid.csv"), &simulation.log, &[]).expect("a log");
    fs::write(dir.path().join("rig.toml"), "[palm1]\nzero_m = 0.0004\n").expect("a file");
    let samples = |rig: &str| {
        let swept = sweep(&format!("kind = \"reconstruct\"\nlogs = \"*said.csv\"\n{rig}"), dir.path());
        let rows = [0, 1].map(|job| swept.jobs[job].run(job as u64, dir.path()).row);
        rows.map(|row| (row.status, row.sensor_sd_m, row.chi2_per_dof))
    };
    let [said, unsaid] = samples("");
    assert_eq!(samples("rig = \"exact\""), [said, said]);
    assert!(said != unsaid && unsaid.0 == Status::Reconstructed, "the default tolerances");
    // Another zero, of which the tolerance is the default.
    let [shifted, also] = samples("rig = \"rig.toml\"");
    assert!(shifted == also && shifted != said && shifted != unsaid);
}

#[test]
fn outcomes_may_come_from_anywhere_in_any_order_and_twice() {
    let dir = tempfile::tempdir().expect("a folder");
    let sweep = sweep(&format!("{SHORT}reconstruct.method = \"quadrature\"\n"), Path::new("."));
    let mut folder = sweep.open(&dir.path().join("afar")).expect("a folder");
    assert_eq!(folder.todo(), [0, 1, 2, 3]);
    for number in [2, 0, 2] {
        folder.keep(sweep.outcome(number).expect("a job")).expect("kept");
    }
    assert_eq!((folder.done(), folder.todo()), (Done { finished: 2, jobs: 4 }, vec![1, 3]));
    let early = folder.finish().expect_err("two jobs are missing");
    assert!(matches!(early, SweepError::Unfinished { missing: 2, .. }), "{early}");

    let mut folder = sweep.open(&dir.path().join("afar")).expect("the same folder");
    assert_eq!(folder.todo(), [1, 3]);
    sweep.each(&[3, 1], TWO, &mut |outcome| folder.keep(outcome)).expect("the rest");
    folder.finish().expect("tables");
    let journal = fs::read_to_string(dir.path().join("afar/journal.jsonl")).expect("a journal");
    assert_eq!(journal.lines().count(), 5, "each job once");
    sweep.run_in(&dir.path().join("here"), TWO, &mut |_| ()).expect("outcomes");
    let table = |name: &str| fs::read(dir.path().join(name).join("results.parquet")).expect("a table");
    assert!(table("afar") == table("here"), "where a job was done changes the table");
}

#[test]
fn two_sweeps_do_not_share_a_folder_at_the_same_time() {
    let dir = tempfile::tempdir().expect("a folder");
    let sweep = sweep(&format!("{SHORT}reconstruct.method = \"quadrature\"\n"), Path::new("."));
    let mut refusals = Vec::new();
    sweep
        .run_in(dir.path(), TWO, &mut |_| refusals.push(sweep.run_in(dir.path(), TWO, &mut |_| ()).expect_err("busy")))
        .expect("the first one is not disturbed");
    assert_eq!(refusals.len(), 5, "one before the first job and one after each");
    assert!(refusals.iter().all(|error| matches!(error, SweepError::Busy { .. })), "{refusals:?}");
}

#[test]
fn example_plans_are_plans() {
    for (name, jobs) in [("noise.toml", 30), ("logs.toml", 6)] {
        let path = beside("examples/sweeps").join(name);
        let plan = read_plan(&path).expect("a plan");
        let sweep = Sweep::new(&plan, path.parent().expect("a folder")).expect("jobs");
        assert_eq!(sweep.jobs.len(), jobs, "{name}");
    }
}

#[test]
fn every_motion_and_object_gives_a_log() {
    let motions = r#"
kind = "simulate"
motions = ["random", "random-jump-free", "turn", "zigzag"]
objects.ellipse = { axis_ratio = 0.7 }
touchpads = [{ noise_sd_m = 0.1e-3, angle_noise_sd_rad = 1e-3, dropout = 0.1, length_m = 0.2 }]
"#;
    let objects = r#"
kind = "simulate"
objects.mixed = {}
objects.named = { name = "random:7" }
objects.fourier = { order = 4 }
objects.ellipse = { axis_ratio = 0.7 }
objects.polygon = { corners = 3 }
touchpads = [{}]
"#;
    for (plan, jobs) in [(motions, 4), (objects, 5)] {
        let sweep = sweep(&format!("samples = 600\n{plan}"), Path::new("."));
        assert_eq!(sweep.jobs.len(), jobs);
        for job in &sweep.jobs {
            let Source::Simulate(job) = &job.source else { panic!("a simulation") };
            let simulated = job.simulate().unwrap_or_else(|error| panic!("{job:?}: {error}"));
            assert_eq!(simulated.simulation.log.samples.len(), 600, "{job:?}");
        }
    }
}

#[test]
fn the_guide_names_every_column() {
    let guide = fs::read_to_string(beside("sweeps.md")).expect("the guide");
    for name in column_names() {
        assert!(guide.contains(&format!("`{name}`")), "{name} is missing in docs/sweeps.md");
    }
}

/// A job's object as JSON.
fn objects(plan: &str, base: &Path) -> Vec<serde_json::Value> {
    let jobs = sweep(plan, base).jobs;
    let object = |job: &Job| serde_json::to_value(job).expect("JSON")["source"]["simulate"]["object"].clone();
    jobs.iter().map(object).collect()
}

#[test]
fn outlines_from_files_are_objects_that_need_no_file() {
    let dir = tempfile::tempdir().expect("a folder");
    let ellipse = palpate::shape::ellipse(0.03, 0.02).expect("an ellipse");
    let rows = (0..400).map(|i| ellipse.boundary_point(std::f64::consts::TAU * f64::from(i) / 400.0));
    let rows: String = rows.map(|point| format!("{},{}\n", point.x_m, point.y_m)).collect();
    fs::write(dir.path().join("mine.csv"), format!("x_m,y_m\n{rows}")).expect("a file");
    let plan = |more: &str| {
        format!(
            "kind = \"simulate\"\nsamples = 150\ntouchpads = [{{}}]\nobjects.outline = {{ file = \"mine.csv\"{more} }}\n"
        )
    };
    let sweep = sweep(&plan(""), dir.path());
    let letter = serde_json::to_string(&sweep.jobs[0]).expect("JSON");
    let there: Job = serde_json::from_str(&letter).expect("a job");
    assert_eq!(there, sweep.jobs[0]);
    let row = there.run(0, Path::new("elsewhere")).row;
    assert_eq!((row.object.as_str(), row.status), ("mine.csv", Status::Reconstructed), "{}", row.reason);
    assert!((row.mean_radius_m.expect("a radius") - ellipse.mean_radius_m()).abs() < 1e-5);

    let many = objects(&plan(", mean_radius_m = [0.02, 0.03], mass_offset = [0, 0.1]"), dir.path());
    let radii: Vec<f64> =
        many.iter().map(|object| object["outline"]["shape"]["mean_radius_m"].as_f64().expect("one")).collect();
    assert!(
        radii.iter().zip([0.02, 0.02, 0.03, 0.03]).all(|(radius, expected)| (radius - expected).abs() < 1e-12),
        "{radii:?}"
    );
    assert_eq!(many[1]["outline"]["mass_offset"], 0.1);

    let refusal = |text: &str| {
        let plan = parse_plan("plan.toml", text).expect("a plan");
        Sweep::new(&plan, dir.path()).map_or_else(|error| error.to_string(), |_| "accepted".to_owned())
    };
    let missing = dir.path().join("other.csv").display().to_string();
    assert_eq!(
        refusal(&plan("").replace("mine", "other")),
        format!("plan.toml, objects.outline: {missing}: no such file; check the path")
    );
    fs::write(dir.path().join("other.csv"), "x_m,y_m\n0,0\n1,1\n2,2\n").expect("a file");
    assert!(
        refusal(&plan("").replace("mine", "other"))
            .starts_with("plan.toml, objects.outline: other.csv: the points do not")
    );
}

#[test]
fn named_objects_have_the_size_in_their_name() {
    let plan = |more: &str| {
        format!(
            "kind = \"simulate\"\ntouchpads = [{{}}]\nobjects.named = {{ name = [\"egg\", \"stadium:60x40\"]{more} }}\n"
        )
    };
    let radii = |more: &str| {
        let all = objects(&plan(more), Path::new("."));
        all.iter().map(|object| object["named"]["mean_radius_m"].as_f64().expect("one")).collect::<Vec<_>>()
    };
    let stadium = (0.02 + 0.02 * std::f64::consts::PI) / std::f64::consts::PI;
    let own = radii("");
    assert!(own[0] == 0.03 && (own[1] - stadium).abs() < 1e-15, "{own:?}");
    assert_eq!(radii(", mean_radius_m = 0.025"), [0.025, 0.025]);
}

#[test]
fn a_touchpad_is_read_from_a_file() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("pad.toml");
    let read = |text: &str| {
        fs::write(&path, text).expect("a file");
        palpate_sweep::read_touchpad(&path)
            .map_err(|error| error.to_string().replace(&path.display().to_string(), "pad.toml"))
    };
    let pads = read("noise_sd_m = 2e-4\ncounts_per_inch = 200\n").expect("a touchpad");
    assert_eq!((pads.noise_sd_m, pads.counts_per_inch, pads.dropout, pads.length_m), (2e-4, Some(200.0), 0.0, None));
    assert_eq!(
        read("noise_sd_m = [1e-4, 2e-4]\n").expect_err("two"),
        "pad.toml: there is a list of values where a touchpad has one; give one value for each key"
    );
    assert!(
        read("dropout = 1\n").expect_err("too many").starts_with("pad.toml, line 1, dropout: it must be at least 0")
    );
}
