//! `palpate paper`: the figures are there, and say what they should.

mod common;

use std::fs;

use common::{folder, names, palpate};
use palpate_report::paper::FIGURE_NAMES;

#[test]
fn every_figure_is_made_from_nothing_and_both_methods_are_as_good_as_they_should_be() {
    let dir = folder();
    let ran = palpate(dir.path(), &["paper", "-o", "out"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains("out/index.html"), "{}", ran.stdout);
    let out = dir.path().join("out");
    let mut expected: Vec<String> =
        FIGURE_NAMES.iter().flat_map(|name| [format!("{name}.svg"), format!("{name}.png")]).collect();
    const LOGS: [&str; 4] = ["exact", "experiment", "fingers", "palms"];
    expected.extend(LOGS.iter().chain([&"strokes"]).flat_map(|log| [format!("{log}.csv"), format!("{log}.truth")]));
    expected.extend(["errors.csv", "index.html"].map(str::to_owned));
    expected.sort();
    assert_eq!(names(&out), expected);

    let page = fs::read_to_string(out.join("index.html")).expect("there is a page");
    for name in FIGURE_NAMES {
        assert!(page.contains(&format!("<img src=\"{name}.svg\"")), "{name}");
        let picture = fs::read(out.join(format!("{name}.png"))).expect("there is a picture");
        assert!(picture.starts_with(b"\x89PNG") && picture.len() > 20_000, "{name}: {} bytes", picture.len());
        let drawing = fs::read_to_string(out.join(format!("{name}.svg"))).expect("there is a drawing");
        assert!(!drawing.contains("NaN") && !drawing.contains("inf"), "{name}");
    }
    assert!(!page.contains("http://") && !page.contains("https://"), "nothing comes from the network");

    // Rows of the table: shape, Hausdorff distance, orientation, centre of mass, contact vector.
    let rows: Vec<Vec<f64>> = page
        .split("<tr><td>")
        .skip(1)
        .map(|row| row.split("<td>").filter_map(|cell| cell.split('<').next()?.parse().ok()).collect())
        .collect();
    assert_eq!(rows.len(), 8);
    for pair in rows.chunks(2) {
        let [ode, likelihood] = pair else { panic!("{rows:?}") };
        assert_eq!((ode.len(), likelihood.len()), (5, 5), "{rows:?}");
        assert!(ode[0] < 1.0 && ode[2] < 10.0, "the paper's method comes near: {ode:?}");
        assert!(likelihood[0] < 0.1 * ode[0] && likelihood[2] < 0.5 * ode[2], "{likelihood:?} against {ode:?}");
    }

    assert_eq!(page.matches("<td>yes</td>").count(), 4, "maximum likelihood is certified on all logs");

    // The same as CSV.
    let errors = fs::read_to_string(out.join("errors.csv")).expect("there is a table");
    assert!(
        errors.starts_with("log,method,rms_r_m,hausdorff_m,rms_psi_rad,rms_com_m,rms_contact_vector_m,certified\n")
    );
    assert_eq!(errors.lines().count(), 9);

    // The truth lies where the program looks for it.
    for log in LOGS {
        let read = palpate_io::read_log(&out.join(log).with_extension("csv")).expect("there is a log");
        let truth = palpate_io::read_truth(&out.join(log).with_extension("truth")).expect("there is its truth");
        assert_eq!(read.log.samples.len(), truth.motion.len(), "{log}");
    }

    let strokes = palpate_io::read_strokes(&out.join("strokes.csv")).expect("there is a log");
    let found = palpate::pivot::reconstruct_strokes(&strokes.log, &palpate::pivot::PivotOptions::default());
    let truth = palpate_io::read_truth(&out.join("strokes.truth")).expect("there is its truth");
    let found = found.expect("a result");
    let errors = palpate::pivot::compare_strokes(&found, &truth).expect("they belong together");
    assert!(found.is_certified() && errors.rms_r_m < 1e-4 && errors.rms_psi_rad < 0.02, "{errors:?}");

    // Nothing foreign is lost.
    fs::write(out.join("thesis.tex"), "years of work").expect("a file");
    let ran = palpate(dir.path(), &["paper", "-o", "out"]);
    assert_eq!(ran.code, Some(2));
    assert!(ran.stderr.contains("thesis.tex"), "{}", ran.stderr);
}
