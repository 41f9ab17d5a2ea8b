//! Truth and result folders: what they hold, and that nothing of the user's is ever lost.

use std::fs;
use std::path::Path;

use palpate::mechanics::ContactMode;
use palpate::reconstruct::{Cause, Doubt, FoundSymmetry, Jump, Method, Mistake, OutlinePoint, Pose, Verdict};
use palpate::shape::{SupportFunction, Symmetry};
use palpate::simulate::{SimulateOptions, simulate};
use palpate::truth::TruePose;
use palpate::{Reconstruction, Truth};
use palpate_io::{
    Summary, TruthSummary, WriteProblem, alternative_dir_of, check_result_target, read_motion_csv, read_shape_csv,
    read_summary, read_truth, truth_dir_of, write_result, write_truth,
};

fn reconstruction() -> Reconstruction {
    let outline = (0..720).map(|index| OutlinePoint {
        theta_rad: std::f64::consts::TAU * index as f64 / 720.0,
        r_m: 0.03 + 1e-5 * index as f64,
        r_sd_m: 1e-4 / 3.0,
        x_m: 0.01 / 7.0,
        y_m: -1e-9,
        curvature_radius_m: 0.02,
        touches: index % 3,
    });
    let motion = (0..5).map(|index| Pose {
        time_s: 0.05 * index as f64,
        psi_rad: -0.1 * index as f64,
        psi_sd_rad: 0.001,
        com_x_m: 0.01,
        com_y_m: 0.05,
        com_sd_m: 1e-4,
        theta1_rad: 1.0,
        theta2_rad: -1.0,
        piece: index / 3,
        residual1_m: None,
        residual2_m: None,
        modes: (index < 3).then_some([ContactMode::Stick, ContactMode::SlideMinus]),
    });
    Reconstruction {
        shape: SupportFunction::new(0.03, vec![[0.0, 0.0], [0.001, 0.002]]),
        outline: outline.collect(),
        motion: motion.collect(),
        findings: None,
        verdict: Verdict::new(vec![Doubt::Unbalanced { balance_sd_m: 2e-5 }]),
        chi2_per_dof: 1.02,
        jumps: vec![Jump {
            time_s: 0.15,
            psi_before_rad: -0.2,
            psi_after_rad: 1.5,
            height_before_m: 0.0625,
            height_after_m: 0.0600,
            physical: true,
        }],
        coverage: 0.98,
        symmetry: FoundSymmetry {
            symmetry: Symmetry { order: 3, mirror: true },
            probability: Some(0.9),
            deviation_sd_m: Some(1e-5),
        },
        alternatives: 1,
        others: Vec::new(),
        sensor_sd_m: 1e-4,
        balance_sd_m: 2e-5,
        calibration: None,
        friction: None,
        inertia: None,
    }
}

fn write(dir: &Path) -> Result<(), palpate_io::WriteError> {
    let reconstruction = reconstruction();
    write_result(dir, &reconstruction, &Summary::new(&reconstruction, 1.5), "<!doctype html>")
}

/// Names in a folder, in order.
fn names(dir: &Path) -> Vec<String> {
    let entries = fs::read_dir(dir).unwrap_or_else(|error| panic!("{}: {error}", dir.display()));
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

const RESULT: [&str; 4] = ["motion.csv", "report.html", "shape.csv", "summary.json"];

#[test]
fn a_result_reads_back_the_same() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let dir = folder.path().join("new").join("out");
    let reconstruction = reconstruction();
    let mut summary = Summary::new(&reconstruction, 1.5);
    summary.log = Some("trial.csv".to_string());
    summary.notes = vec!["columns ignored: foo".to_string()];
    summary.truth =
        Some(TruthSummary { rms_r_m: 1e-5, rms_form_m: 9e-6, hausdorff_m: 2e-5, rms_psi_rad: 0.001, rms_com_m: 3e-5 });
    write_result(&dir, &reconstruction, &summary, "<!doctype html>").unwrap_or_else(|error| panic!("{error}"));

    assert_eq!(names(&dir), RESULT);
    assert_eq!(names(dir.parent().expect("it has one")), ["out"]);
    assert_eq!(read_shape_csv(&dir), Ok(reconstruction.outline));
    assert_eq!(read_motion_csv(&dir), Ok(reconstruction.motion));
    assert_eq!(read_summary(&dir), Ok(summary));
    let first_lines =
        |name| fs::read_to_string(dir.join(name)).expect("it is there").lines().take(2).collect::<Vec<_>>().join("\n");
    assert_eq!(
        first_lines("shape.csv"),
        "theta_rad,r_m,r_sd_m,x_m,y_m,curvature_radius_m,touches\n0,0.03,0.000033333333333333335,0.0014285714285714286,-1e-9,0.02,0"
    );
    assert_eq!(
        first_lines("motion.csv"),
        "time_s,psi_rad,psi_sd_rad,com_x_m,com_y_m,com_sd_m,theta1_rad,theta2_rad,piece,mode1,mode2\n0,-0,0.001,0.01,0.05,0.0001,1,-1,0,stick,slide-"
    );
}

/// A result beside which two others fit equally well.
fn ambiguous() -> Reconstruction {
    let mut result = reconstruction();
    let mut other = reconstruction();
    other.verdict = Verdict::default();
    other.outline.iter_mut().for_each(|point| point.r_m += 0.001);
    let mut third = other.clone();
    third.verdict = Verdict::new(vec![Doubt::NotConvex]);
    third.motion.iter_mut().for_each(|pose| pose.psi_rad += 1.0);
    result.verdict = Verdict::new(vec![Doubt::Alternatives { objects: 3 }]);
    (result.alternatives, result.others) = (3, vec![other, third]);
    result.jumps.clear();
    result
}

#[test]
fn alternatives_read_back_the_same_and_are_never_certified() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let dir = folder.path().join("out");
    let result = ambiguous();
    let mut summary = Summary::new(&result, 1.5);
    summary.log = Some("trial.csv".to_string());
    let write = || write_result(&dir, &result, &summary, "<!doctype html>").unwrap_or_else(|error| panic!("{error}"));
    write();
    assert_eq!(names(&dir), ["alternatives", "motion.csv", "report.html", "shape.csv", "summary.json"]);
    assert_eq!(names(&dir.join("alternatives")), ["1", "2"]);
    for (index, other) in result.others.iter().enumerate() {
        let place = alternative_dir_of(&dir, index + 1);
        assert_eq!(names(&place), ["motion.csv", "shape.csv", "summary.json"]);
        assert_eq!(read_shape_csv(&place), Ok(other.outline.clone()));
        assert_eq!(read_motion_csv(&place), Ok(other.motion.clone()));
        let read = read_summary(&place).unwrap_or_else(|error| panic!("{error}"));
        assert!(!read.certified && !read.com_certified);
        let expected = [Doubt::Alternatives { objects: 3 }, Doubt::NotConvex][index].clone();
        assert_eq!(read.reason, expected.to_string());
        assert_eq!(read.verdict().doubts, [expected]);
        assert_eq!((read.alternatives, read.jumps.len()), (3, 1));
        assert_eq!(read.log.as_deref(), Some("trial.csv"));
    }

    // It is replaced as a whole, by one of its kind or by one without alternatives.
    write();
    fs::write(dir.join("alternatives/2/.DS_Store"), "").expect("a file for the test");
    crate::write(&dir).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(names(&dir), RESULT);
    assert_eq!(names(folder.path()), ["out"]);
}

#[test]
fn alternatives_with_anything_else_are_left_alone() {
    let result = ambiguous();
    let summary = Summary::new(&result, 1.5);
    for foreign in ["alternatives/notes.txt", "alternatives/1/notes.txt", "alternatives/01", "alternatives/best"] {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let dir = folder.path().join("out");
        write_result(&dir, &result, &summary, "").unwrap_or_else(|error| panic!("{error}"));
        fs::write(dir.join(foreign), "").expect("a file for the test");
        for outcome in [check_result_target(&dir), write(&dir)] {
            let problem = outcome.expect_err("it must be refused").problem;
            assert_eq!(problem, WriteProblem::Foreign { kind: "result", found: foreign.to_string() });
        }
        assert_eq!(names(folder.path()), ["out"]);
        assert!(dir.join(foreign).exists() && dir.join("alternatives/2/shape.csv").exists());
    }
}

#[test]
fn the_summary_has_the_promised_keys_and_no_number_that_json_lacks() {
    let mut reconstruction = reconstruction();
    reconstruction.chi2_per_dof = f64::INFINITY;
    reconstruction.sensor_sd_m = f64::NAN;
    reconstruction.jumps[0].psi_after_rad = f64::NAN;
    let json = Summary::new(&reconstruction, 1.5).to_json().expect("it has a JSON form");
    let expected = r#"{
  "certified": true,
  "com_certified": false,
  "reason": "shape and motion are certified, the centre of mass is not: force/torque balance is missed by 0.02 mm (friction, or fast palms)",
  "doubts": [
    {
      "kind": "unbalanced",
      "balance_sd_m": 0.00002,
      "text": "shape and motion are certified, the centre of mass is not: force/torque balance is missed by 0.02 mm (friction, or fast palms)",
      "cause": "forces",
      "next": "reduce friction, or move the palms more slowly",
      "docs": "docs/verdict.md#unbalanced"
    }
  ],
  "chi2_per_dof": null,
  "jumps": [
    0.15
  ],
  "jump_details": [
    {
      "time_s": 0.15,
      "psi_before_rad": -0.2,
      "psi_after_rad": null,
      "height_drop_m": 0.0025000000000000022,
      "physical": true
    }
  ],
  "coverage": 0.98,
  "alternatives": 1,
  "symmetry": {
    "order": 3,
    "mirror": true,
    "probability": 0.9,
    "deviation_sd_m": 0.00001
  },
  "sensor_sd_m": null,
  "balance_sd_m": 0.00002,
  "size_sd": 0.0,
  "offset_sd_m": 0.0,
  "calibration": {},
  "forces": "frictionless",
  "friction": null,
  "gyration_radius_m": null,
  "damping_per_s": null,
  "weight_n": null,
  "force_sd_n": null,
  "samples": 5,
  "harmonics": 2,
  "seconds": 1.5,
  "version": "VERSION",
  "notes": []
}
"#;
    assert_eq!(json, expected.replace("VERSION", env!("CARGO_PKG_VERSION")));
    let back: Summary = serde_json::from_str(&json).expect("it reads back");
    assert!(back.chi2_per_dof.is_nan() && back.sensor_sd_m.is_nan());
}

/// What comes back of a summary without its doubts, as older versions wrote it.
fn without_doubts(verdict: Verdict) -> (Summary, Summary) {
    let summary = Summary::new(&Reconstruction { verdict, ..reconstruction() }, 1.5);
    let mut json: serde_json::Value = serde_json::to_value(&summary).expect("it has a JSON form");
    json.as_object_mut().expect("an object").remove("doubts").expect("it was there");
    (summary, serde_json::from_value(json).expect("it reads back"))
}

#[test]
fn every_doubt_reads_back_with_its_numbers_and_its_sentence() {
    let text = "in words".to_string();
    let doubts = vec![
        Doubt::NegativeRadius,
        Doubt::UnphysicalJumps { time_s: 0.5, turn_rad: -1.25, jumps: 2 },
        Doubt::Misfit { left_m: 0.25, expected_m: 0.125, stated: true },
        Doubt::NotConvex,
        Doubt::UnstablePoses { samples: 3, of: 5 },
        Doubt::LittleFelt { coverage: 0.25 },
        Doubt::AmbiguousPoses { samples: 1, ambiguity_rad: 0.5 },
        Doubt::JumpReversals { reversals: 7 },
        Doubt::UncertainOrientation { sd_rad: 0.5, largest_sd_rad: 1.5 },
        Doubt::UncertainBoundary { sd_m: 0.5 },
        Doubt::Alternatives { objects: 4 },
        Doubt::Unbalanced { balance_sd_m: 0.5 },
        Doubt::UncertifiedMethod { method: Method::Ode },
        Doubt::Outliers { outliers: 3, readings: 90 },
        Doubt::StrayReadings { typical_m: 0.125, all_m: 0.5 },
        Doubt::UncertainSymmetry { probability: 0.5, deviation_sd_m: 0.25 },
        Doubt::UnlikelyRig { constant: "s1_zero_m".to_owned(), off_sds: 4.0 },
        Doubt::UnsettledRig { sds: 2.0 },
        Doubt::Friction { coefficients: [0.25, 0.5], sds: [0.125, 0.125] },
        Doubt::UncertainCenter { sd_m: 0.5 },
        Doubt::Mistaken { mistake: Mistake::PadsSwapped },
        Doubt::Mistaken { mistake: Mistake::ReadFromTip { length1_m: None, length2_m: Some(0.125) } },
        Doubt::Mistaken { mistake: Mistake::ZerosForNoContact { readings: 5 } },
        Doubt::Reported { text: text.clone() },
        Doubt::ReportedOfCenterOfMass { text },
    ];
    let verdict = Verdict::new(doubts);
    let summary = Summary::new(&Reconstruction { verdict: verdict.clone(), ..reconstruction() }, 1.5);
    let json = summary.to_json().expect("it has a JSON form");
    let read: Summary = serde_json::from_str(&json).expect("it reads back");
    assert_eq!(read.verdict(), verdict);
    let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/verdict.md");
    let page = std::fs::read_to_string(page).expect("the page on verdicts");
    for (written, doubt) in value["doubts"].as_array().expect("a list").iter().zip(&verdict.doubts) {
        assert_eq!(written["text"], doubt.to_string());
        assert_eq!(written["kind"], doubt.kind());
        // What the page calls it, and what files and messages say to do.
        assert!(page.contains(&format!("\n### {}\n", doubt.kind())), "{}", doubt.kind());
        assert_eq!(written["docs"], format!("docs/verdict.md#{}", doubt.kind()));
        let is_in_words = doubt.kind().starts_with("reported");
        assert_eq!(written["next"].as_str().unwrap_or_default(), doubt.next_step());
        assert_eq!(doubt.next_step().is_empty(), is_in_words, "{doubt}");
    }
    let causes: Vec<_> = verdict.doubts.iter().map(Doubt::cause).collect();
    assert!(causes.is_sorted() && causes.first() == Some(&Cause::Input) && causes.last() == Some(&Cause::Unknown));
    assert!(
        json.contains("\"mistake\": \"read-from-tip\",\n      \"length1_m\": null,\n      \"length2_m\": 0.125"),
        "{json}"
    );
    assert_eq!(json.matches("\"text\"").count(), verdict.doubts.len());
}

#[test]
fn a_doubt_may_have_numbers_that_json_lacks() {
    let verdict = Verdict::new(vec![Doubt::UncertainBoundary { sd_m: f64::INFINITY }]);
    let json = Summary::new(&Reconstruction { verdict, ..reconstruction() }, 1.5).to_json().expect("a JSON form");
    assert!(json.contains("\"sd_m\": null"));
    let read: Summary = serde_json::from_str(&json).expect("it reads back");
    assert!(matches!(read.verdict().doubts[..], [Doubt::UncertainBoundary { sd_m }] if sd_m.is_nan()));
}

#[test]
fn a_summary_of_an_older_version_gives_its_reason_in_words() {
    let (_, read) = without_doubts(Verdict::default());
    assert_eq!(read.verdict(), Verdict::default());

    let (summary, read) = without_doubts(Verdict::new(vec![Doubt::NotConvex, Doubt::LittleFelt { coverage: 0.1 }]));
    assert_eq!(read.verdict().doubts, [Doubt::Reported { text: summary.reason }]);
    assert!(!read.verdict().is_certified() && !read.verdict().is_com_certified());

    let (summary, read) = without_doubts(Verdict::new(vec![Doubt::Unbalanced { balance_sd_m: 1e-3 }]));
    assert_eq!(read.verdict().doubts, [Doubt::ReportedOfCenterOfMass { text: summary.reason }]);
    assert!(read.verdict().is_certified() && !read.verdict().is_com_certified());
}

#[test]
fn a_doubt_of_a_newer_version_is_read_as_its_sentence() {
    let json = Summary::new(&reconstruction(), 1.5).to_json().expect("it has a JSON form");
    let (certified, newer) = (json.replace("\"unbalanced\"", "\"slippery\""), "\"certified\": false");
    let read: Summary = serde_json::from_str(&certified).expect("it reads");
    assert_eq!(read.verdict().doubts, [Doubt::ReportedOfCenterOfMass { text: read.reason.clone() }]);
    let read: Summary = serde_json::from_str(&certified.replace("\"certified\": true", newer)).expect("it reads");
    assert_eq!(read.verdict().doubts, [Doubt::Reported { text: read.reason.clone() }]);
    assert!(serde_json::from_str::<Summary>(&certified.replace("\"text\"", "\"words\"")).is_err());
}

#[test]
fn an_earlier_result_or_an_empty_folder_is_replaced() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let dir = folder.path().join("out");
    fs::create_dir(&dir).expect("a folder for the test");
    for _ in 0..3 {
        check_result_target(&dir).unwrap_or_else(|error| panic!("{error}"));
        write(&dir).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(names(&dir), RESULT);
        assert_eq!(names(folder.path()), ["out"]);
        fs::write(dir.join(".DS_Store"), "").expect("a file for the test");
        fs::remove_file(dir.join("report.html")).expect("it was there");
    }
}

#[cfg(unix)]
#[test]
fn a_link_to_a_folder_is_followed() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let (dir, link) = (folder.path().join("out"), folder.path().join("link"));
    fs::create_dir(&dir).expect("a folder for the test");
    std::os::unix::fs::symlink(&dir, &link).expect("a link for the test");
    write(&link).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(names(&dir), RESULT);
    assert_eq!(names(folder.path()), ["link", "out"]);
}

#[test]
fn a_folder_with_anything_else_is_left_alone() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let refused = |dir: &Path, found: &str| {
        let before = names(dir);
        for outcome in [check_result_target(dir), write(dir)] {
            let message = outcome.expect_err("it must be refused").to_string();
            let expected = format!(
                "{}: the folder holds {found}, which is not part of an earlier result and would be lost; choose another folder, or a new one inside it",
                dir.display()
            );
            assert_eq!(message, expected);
        }
        assert_eq!(names(dir), before);
        assert!(names(folder.path()).iter().all(|name| !name.starts_with('.')));
    };

    let thesis = folder.path().join("thesis");
    fs::create_dir(&thesis).expect("a folder for the test");
    fs::write(thesis.join("thesis.tex"), "years of work").expect("a file for the test");
    refused(&thesis, "thesis.tex");

    // A result that someone added notes to.
    let noted = folder.path().join("noted");
    write(&noted).unwrap_or_else(|error| panic!("{error}"));
    fs::write(noted.join("notes.txt"), "").expect("a file for the test");
    refused(&noted, "notes.txt");

    // A folder by the name of a file of ours.
    let nested = folder.path().join("nested");
    write(&nested).unwrap_or_else(|error| panic!("{error}"));
    fs::remove_file(nested.join("report.html")).expect("it was there");
    fs::create_dir(nested.join("report.html")).expect("a folder for the test");
    refused(&nested, "report.html");

    // Files of our names, but the summary is another program's.
    let other = folder.path().join("other");
    fs::create_dir(&other).expect("a folder for the test");
    fs::write(other.join("summary.json"), "{\"total\": 3}").expect("a file for the test");
    refused(&other, "summary.json");

    // The truth of a log has files of the same names.
    let truth_dir = folder.path().join("log.truth");
    write_truth(&truth_dir, &truth()).unwrap_or_else(|error| panic!("{error}"));
    refused(&truth_dir, "motion.csv");

    // And the other way round: a result is not replaced by a truth.
    let result = folder.path().join("out");
    write(&result).unwrap_or_else(|error| panic!("{error}"));
    let problem = write_truth(&result, &truth()).expect_err("it must be refused").problem;
    assert_eq!(problem, WriteProblem::Foreign { kind: "truth", found: "report.html".to_string() });
}

#[test]
fn a_file_in_the_way_and_the_current_folder_are_refused() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let file = folder.path().join("file");
    fs::write(&file, "").expect("a file for the test");
    for dir in [file.clone(), file.join("out"), file.join("new").join("out")] {
        for outcome in [check_result_target(&dir), write(&dir)] {
            let message = outcome.expect_err("it must be refused").to_string();
            let expected =
                format!("{}: a file of that name exists; choose another name for the folder", file.display());
            assert_eq!(message, expected);
        }
    }
    let message = check_result_target(Path::new(".")).expect_err("it must be refused").to_string();
    assert_eq!(message, ".: this is the current folder; choose a folder of its own for the result");
    let message = check_result_target(Path::new("")).expect_err("it must be refused").to_string();
    assert_eq!(message, "(no name): this is not a folder name; choose one such as out/");
}

#[test]
fn a_check_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    check_result_target(&folder.path().join("new").join("out")).unwrap_or_else(|error| panic!("{error}"));
    assert!(names(folder.path()).is_empty());
}

#[test]
fn a_broken_summary_is_told() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let path = folder.path().join("summary.json");
    let message = || read_summary(folder.path()).expect_err("there is none").to_string();
    assert_eq!(message(), format!("{}: no such file; check the path", path.display()));
    fs::write(&path, "{").expect("a file for the test");
    assert_eq!(
        message(),
        format!(
            "{}: not the summary of a palpate result: EOF while parsing an object at line 1 column 1; reconstruct again",
            path.display()
        )
    );
}

fn truth() -> Truth {
    let support = (0..12).map(|index| (0.5 * index as f64, 0.03 + 1.0 / (300.0 + index as f64))).collect();
    let pose =
        |index: i32| TruePose { time_s: 0.1 * f64::from(index), psi_rad: -1.0 / 3.0, com_x_m: -1e-7, com_y_m: 0.05 };
    Truth { support, motion: (0..3).map(pose).collect() }
}

#[test]
fn a_truth_reads_back_the_same() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let dir = folder.path().join("new").join("log.truth");
    for _ in 0..2 {
        write_truth(&dir, &truth()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(read_truth(&dir), Ok(truth()));
        assert_eq!(names(&dir), ["motion.csv", "shape.csv"]);
    }
}

#[test]
fn the_truth_is_beside_its_log() {
    assert_eq!(truth_dir_of(Path::new("dir/egg_n0.1mm.csv")), Path::new("dir/egg_n0.1mm.truth"));
    assert_eq!(truth_dir_of(Path::new("egg_n0.1mm")), Path::new("egg_n0.1mm.truth"));
}

#[test]
fn a_truth_in_other_units_and_closed_is_understood() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let rows: String = (0..=8).map(|row| format!("3{row},{}\n", 45 * row)).collect();
    fs::write(folder.path().join("shape.csv"), format!("r_mm,theta_deg\n{rows}")).expect("a file for the test");
    fs::write(folder.path().join("motion.csv"), "time_ms,psi_deg,com_x_cm,com_y_mm,note\n0,180,1,50,a\n")
        .expect("a file");
    let truth = read_truth(folder.path()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(truth.support.len(), 8);
    assert_eq!(truth.support[2], (std::f64::consts::FRAC_PI_2, 0.032));
    assert_eq!(truth.motion, [TruePose { time_s: 0.0, psi_rad: std::f64::consts::PI, com_x_m: 0.01, com_y_m: 0.05 }]);
}

#[test]
fn a_wrong_truth_is_told() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let (shape, motion) = (folder.path().join("shape.csv"), folder.path().join("motion.csv"));
    let good_shape = || -> String {
        "theta_rad,r_m\n".to_string() + &(0..9).map(|row| format!("0.{row},0.03\n")).collect::<String>()
    };
    let good_motion = "time_s,psi_rad,com_x_m,com_y_m\n0,0,0,0\n1,0,0,0\n";
    let expect = |shape_text: &str, motion_text: &str, expected: String| {
        fs::write(&shape, shape_text).expect("a file for the test");
        fs::write(&motion, motion_text).expect("a file for the test");
        assert_eq!(read_truth(folder.path()).expect_err("it is wrong").to_string(), expected);
    };
    let (in_shape, in_motion) = (shape.display(), motion.display());
    expect(
        &good_shape().replace("r_m", "x_m"),
        good_motion,
        format!(
            "{in_shape}, line 1: there is no column for r; it must be named r_m, r_cm, r_mm or r_um (the header has: theta_rad, x_m)"
        ),
    );
    expect(
        &good_shape().replace("0.8,", "45,"),
        good_motion,
        format!(
            "{in_shape}, line 10, column theta_rad: 45 rad looks like degrees; if it is, name the column theta_deg"
        ),
    );
    expect(
        &good_shape().replace("0.5,", "0.3,"),
        good_motion,
        format!(
            "{in_shape}, line 7, column theta_rad: 0.3 comes after 0.4 (line 6), theta decreases; sort the rows, or split the file where it starts again"
        ),
    );
    expect(
        &good_shape().replace("0.5,", "-0.5,"),
        good_motion,
        format!(
            "{in_shape}, line 7, column theta_rad: -0.5 rad is out of range; a direction must lie between 0 and 2 pi (360 deg), the end left out"
        ),
    );
    expect(
        &good_shape().replace("0.5,", "0.5,-"),
        good_motion,
        format!(
            "{in_shape}, line 7, column r_m: -0.03 m is negative; the support function about the centre of mass cannot be negative; use a point inside the object"
        ),
    );
    expect(
        "theta_rad,r_m\n0,1\n",
        good_motion,
        format!("{in_shape}: there are 1 rows, and at least 8 are needed; write it again"),
    );
    expect(
        &good_shape(),
        &good_motion.replace("1,0,0,0", "1,0,,0"),
        format!(
            "{in_motion}, line 3, column com_x_m: the cell is empty where a number must be; fill it in, or delete the row"
        ),
    );
    expect(
        &good_shape(),
        &good_motion.replace("1,0,0,0", "0,0,0,0"),
        format!(
            "{in_motion}, line 3, column time_s: 0 occurs twice, first in line 2; delete one of the two rows, or write time with more digits"
        ),
    );
    let message = |dir: &Path| read_truth(dir).expect_err("there is none").to_string();
    let missing = folder.path().join("none");
    assert_eq!(message(&missing), format!("{}: no such folder; check the path", missing.display()));
    assert_eq!(
        message(&shape),
        format!("{}: this is a file; give the folder that holds shape.csv and motion.csv", shape.display())
    );
}

#[test]
fn a_motion_without_contact_modes_or_with_wrong_ones() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let header = "time_s,psi_rad,psi_sd_rad,com_x_m,com_y_m,com_sd_m,theta1_rad,theta2_rad,piece";
    let read = |text: &str| {
        fs::write(folder.path().join("motion.csv"), text).expect("a file for the test");
        read_motion_csv(folder.path())
    };
    // Folders of older versions have none.
    let poses = read(&format!("{header}\n0,0,0,0,0,0,0,0,0\n")).expect("readable");
    assert_eq!(poses[0].modes, None);
    let wrong = read(&format!("{header},mode1,mode2\n0,0,0,0,0,0,0,0,0,stick,slip\n")).expect_err("no mode");
    let message = wrong.to_string();
    assert!(message.contains("line 2, column mode2") && message.contains("slide+ or slide-"), "{message}");
}

#[test]
fn a_summary_notes_how_many_poses_are_open_where_that_is_no_doubt() {
    let egg = palpate::shape::NamedShape::Egg.shape(0.03).expect("a valid size");
    let plan = palpate::plan::plan_turn(&egg, &palpate::plan::PalmLimits::default(), 40.0).expect("possible");
    let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
    let motion = plan.motion.sample(5.0).expect("possible");
    let log = simulate(&egg, &motion, &options).expect("possible").log;
    let mut found = palpate::reconstruct::reconstruct(&log).expect("an answer");
    let mut notes = |ambiguous: usize, doubts: Vec<Doubt>| {
        found.findings.as_mut().expect("of a likelihood").ambiguous = ambiguous;
        found.verdict.doubts = doubts;
        Summary::new(&found, 1.0).notes
    };
    assert_eq!(notes(0, Vec::new()), Vec::<String>::new());
    assert_eq!(notes(1, Vec::new()), ["the pose of 1 sample is open: its psi_sd_rad and com_sd_m say so"]);
    assert_eq!(notes(3, Vec::new()), ["the pose of 3 samples is open: their psi_sd_rad and com_sd_m say so"]);
    let doubt = Doubt::AmbiguousPoses { samples: 30, ambiguity_rad: 0.5 };
    assert_eq!(notes(30, vec![doubt]), Vec::<String>::new());
}
