//! What must hold for every page, without a browser.

mod fixture;

use fixture::{Fixture, calibration, fixture};
use palpate::compare::TruthError;
use palpate::mechanics::ContactMode;
use palpate::reconstruct::{Doubt, FrictionEstimate, Jump, Verdict};
use palpate::{Log, Reconstruction};
use palpate_report::{ReportInput, TruthOverlay, page};
use proptest::prelude::*;

fn input<'a>(log: &'a Log, reconstruction: &'a Reconstruction) -> ReportInput<'a> {
    ReportInput { title: "a log", log, reconstruction, truth: None, seconds: 1.0, command: None, version: "0.1.0" }
}

fn with_truth(egg: &Fixture) -> String {
    let overlay = TruthOverlay {
        truth: &egg.truth,
        errors: TruthError { rms_r_m: 1e-5, rms_form_m: 1e-5, hausdorff_m: 1e-5, rms_psi_rad: 1e-3, rms_com_m: 1e-5 },
    };
    page(&ReportInput { truth: Some(overlay), ..input(&egg.log, &egg.reconstruction) })
}

fn data(html: &str) -> serde_json::Value {
    let (_, rest) = html.split_once("id=\"data\">").expect("data in the page");
    let (json, _) = rest.split_once("</script>").expect("an end of the data");
    serde_json::from_str(json).expect("valid JSON")
}

fn first(html: &str) -> serde_json::Value {
    data(html)["arrangements"][0].clone()
}

#[test]
fn the_size_of_the_page_is_bounded() {
    let usual = with_truth(&fixture(2000, 60.0, 1.0)).len();
    assert!(usual < 1_500_000, "2000 samples give {usual} bytes");
    let huge = with_truth(&fixture(100_000, 3000.0, 1.0)).len();
    assert!(huge < 5_000_000, "100000 samples give {huge} bytes");
}

#[test]
fn friction_is_told_with_what_the_contacts_do() {
    let mut egg = fixture(50, 1.0, 1.0);
    let without = page(&input(&egg.log, &egg.reconstruction));
    assert!(
        first(&without)["strips"].is_null()
            && first(&without)["modes"].is_null()
            && !without.contains("<dt>Friction</dt>")
    );
    let found = FrictionEstimate {
        coefficients: [0.1, 0.25],
        coefficient_sds: [0.002, 0.003],
        center_m: [0.0; 2],
        center_sd_m: [1e-5; 2],
        misfit: 1.0,
        slides: 10,
        rolls: [1, 2],
    };
    egg.reconstruction.friction = Some(found);
    egg.reconstruction.motion[0].modes = Some([ContactMode::Stick, ContactMode::SlideMinus]);
    let html = page(&input(&egg.log, &egg.reconstruction));
    assert!(html.contains("0.100, 0.250"));
    // What is not told is no number.
    let with_sds = |first: f64, second: f64| {
        let mut egg = fixture(50, 1.0, 1.0);
        let friction = FrictionEstimate { coefficient_sds: [first, second], ..found };
        egg.reconstruction.friction = Some(friction);
        page(&input(&egg.log, &egg.reconstruction))
    };
    assert!(with_sds(0.049, 0.126).contains("0.100, ?"));
    assert!(with_sds(0.051, 0.126).contains("<dt>Friction</dt><dd>–</dd>"));
    // Nor is an offset of a centre of mass that may be anywhere.
    let with_center = |sd_m: f64| {
        let mut egg = fixture(50, 1.0, 1.0);
        egg.reconstruction.verdict = Verdict::new(vec![Doubt::UncertainCenter { sd_m }]);
        egg.reconstruction.motion.iter_mut().for_each(|pose| pose.com_sd_m = sd_m);
        page(&input(&egg.log, &egg.reconstruction))
    };
    let untold = "<dt>Centre-of-mass offset</dt><dd>–</dd>";
    let centroid = egg.reconstruction.shape.centroid();
    let offset_m = centroid.x_m.hypot(centroid.y_m);
    assert!(with_center(0.51 * offset_m).contains(untold) && !with_center(0.49 * offset_m).contains(untold));
    let modes = &first(&html)["modes"];
    assert_eq!((modes[0][0].as_i64(), modes[1][0].as_i64()), (Some(0), Some(-1)));
    assert!(modes[0][1].is_null());
    // The forces meet where the centre of mass is, with both inside their cones.
    let strips = first(&html)["strips"].as_array().expect("two edges").clone();
    assert!(
        strips[0][1].as_f64().expect("it does not jam") < 0.0 && strips[1][1].as_f64().expect("it does not jam") > 0.0
    );
    // Known to slide along palm 2, less is left.
    assert!(
        strips[1][0].as_f64().expect("an edge") - strips[0][0].as_f64().expect("an edge")
            < strips[1][1].as_f64().expect("an edge") - strips[0][1].as_f64().expect("an edge")
    );
}

#[test]
fn nothing_is_fetched_from_elsewhere() {
    let html = with_truth(&fixture(50, 1.0, 1.0));
    let (before, rest) = html.split_once("<link rel=\"icon\"").expect("an icon");
    let (_, after) = rest.split_once('>').expect("an end of the icon");
    for forbidden in ["src=", "@import", "url(http", "href=", "<link", "fetch("] {
        assert!(!before.contains(forbidden) && !after.contains(forbidden), "{forbidden}");
    }
}

#[test]
fn a_thinned_log_keeps_ends_of_pieces_and_the_worst_residual() {
    let mut egg = fixture(20_000, 100.0, 1.0);
    egg.reconstruction.motion[12_345].residual1_m = Some(0.005);
    egg.reconstruction.motion[11_111..].iter_mut().for_each(|pose| pose.piece += 1);
    let html = with_truth(&egg);
    assert!(html.contains("of 20000 samples"));
    let times = data(&html)["log"]["time"].clone();
    let times = times.as_array().expect("times");
    let shown = times.len();
    assert!(shown <= palpate_report::MAX_SAMPLES_SHOWN, "{shown}");
    let worst =
        first(&html)["residuals"][0]["values"].as_array().expect("residuals").iter().any(|r| r.as_f64() == Some(5.0));
    assert!(worst, "the worst residual is not drawn");
    for end in [11_110, 11_111] {
        let time = egg.log.samples[end].time_s;
        let kept = times.iter().any(|shown| shown.as_f64().is_some_and(|shown| (shown - time).abs() < 1e-4));
        assert!(kept, "sample {end} at the end of a piece is not drawn");
    }
}

#[test]
fn the_truth_is_laid_over_the_estimate() {
    // The true frame is turned against that of the estimate; once aligned, only the small errors are left.
    let data = first(&with_truth(&fixture(500, 10.0, 1.0)));
    let largest = |column: &serde_json::Value| {
        let values = column.as_array().expect("a column").iter().map(|v| v.as_f64().expect("a number").abs());
        values.fold(0.0, f64::max)
    };
    let truth = &data["truth"];
    assert!(largest(&truth["psiError"]) < 0.3, "psi: {} degrees", largest(&truth["psiError"]));
    assert!(largest(&truth["rError"]) < 0.05, "r: {} mm", largest(&truth["rError"]));
}

#[test]
fn text_is_escaped() {
    let egg = fixture(20, 1.0, 1.0);
    let mut result = egg.reconstruction.clone();
    result.verdict = Verdict::new(vec![Doubt::Reported { text: "</script><script>evil()".to_owned() }]);
    let html =
        page(&ReportInput { title: "{{data}}<b>", command: Some("palpate '<img src=x>'"), ..input(&egg.log, &result) });
    assert!(!html.contains("<script>evil") && !html.contains("<img") && !html.contains("<b></h1>"));
    assert!(html.contains("{{data}}&lt;b&gt;"));
}

#[test]
fn verdicts_are_told_apart() {
    let egg = fixture(20, 1.0, 1.0);
    let mut result = egg.reconstruction.clone();
    for (doubts, badge) in [
        (vec![], ">Certified<"),
        (vec![Doubt::Unbalanced { balance_sd_m: 1e-3 }], "centre of mass not"),
        (vec![Doubt::NotConvex], "Not certified"),
    ] {
        result.verdict = Verdict::new(doubts);
        let html = page(&input(&egg.log, &result));
        let badges = [">Certified<", "certified, centre of mass not", "Not certified"];
        let found: Vec<_> = badges.iter().filter(|text| html.contains(**text)).collect();
        assert!(found.len() == 1 && found[0].contains(badge), "{found:?} instead of {badge}");
    }
}

#[test]
fn a_chi2_of_nearly_0_is_explained() {
    let mut egg = fixture(50, 1.0, 1.0);
    assert!(!page(&input(&egg.log, &egg.reconstruction)).contains("Hardly any noise"));
    (egg.reconstruction.chi2_per_dof, egg.reconstruction.sensor_sd_m) = (2.06e-7, 2.8e-8);
    let html = page(&input(&egg.log, &egg.reconstruction));
    assert!(html.contains("the fit leaves 0.028 µm, where readings like these were expected to have 61.7 µm"));
    assert!(html.contains("<dd>≪ 1 <small>no noise</small></dd>"));
}

#[test]
fn lists_are_valid_and_the_shape_needs_no_script() {
    let html = with_truth(&fixture(50, 1.0, 1.0));
    // Within a group of a <dl> there are <dt> and <dd> alone.
    for list in html.split("<dl").skip(1).filter_map(|rest| rest.split_once("</dl>")).map(|(list, _)| list) {
        assert!(!list.contains("<p") && list.contains("<dd class="), "{list}");
    }
    let (_, still) =
        html.split_once("</style></noscript>").and_then(|(_, rest)| rest.split_once("<noscript>")).expect("it");
    let (still, _) = still.split_once("</noscript>").expect("an end");
    assert!(
        still.contains("class=\"felt\" d=\"M") && still.contains("class=\"unfelt\"") && still.contains(" mm</text>")
    );
    let mut nothing = fixture(50, 1.0, 1.0);
    nothing.reconstruction.outline.clear();
    assert!(!with_truth(&nothing).contains("class=\"card still\""));
}

#[test]
fn the_headline_says_how_much_finer_than_a_reading() {
    let mut egg = fixture(200, 6.0, 1.0);
    let html = with_truth(&egg);
    let (_, line) = html.split_once("<p class=\"headline\"").expect("a headline");
    let (line, _) = line.split_once("</p>").expect("an end of it");
    for part in [
        "Outline known to ±",
        " µm</b>, <b>",
        " times finer than one reading</b>",
        "; orientation to ±",
        "°, centre of mass to ±",
    ] {
        assert!(line.contains(part), "{part} is not in {line}");
    }
    // The factor is that of the two numbers on the page.
    let number = |after: &str| -> f64 {
        let (_, rest) = line.split_once(after).expect(after);
        rest.split_once(' ').and_then(|(number, _)| number.parse().ok()).expect("a number")
    };
    let (known_um, times) = (number("Outline known to ±"), number("</b>, <b>"));
    assert!((times * known_um - 1.96 * 100.0).abs() < 0.05 * 196.0, "{times} {known_um}");
    assert!(!line.contains("The size as a whole"));
    egg.reconstruction.calibration = Some(calibration());
    assert!(with_truth(&egg).contains("The size as a whole is known to 0.71 %, as the rig is."));
    // What is not certified promises nothing.
    egg.reconstruction.verdict = Verdict::new(vec![Doubt::NotConvex]);
    assert!(!with_truth(&egg).contains("class=\"headline\""));
}

#[test]
fn doubts_are_a_list_with_what_to_do() {
    let egg = fixture(20, 1.0, 1.0);
    let mut result = egg.reconstruction.clone();
    let of = |result: &Reconstruction| page(&input(&egg.log, result));
    assert!(!of(&result).contains("<b>Why"));
    result.verdict = Verdict::new(vec![Doubt::NotConvex, Doubt::Reported { text: "a < b; c".to_owned() }]);
    let list = "<b>Why, and what to do:</b><ul><li>the shape is not convex<br>look for a second touch: only convex objects are reconstructed \
        <code>docs/verdict.md#not-convex</code></li><li>a &lt; b; c</li></ul>";
    assert!(of(&result).contains(list));
}

#[test]
fn jumps_are_listed() {
    let mut egg = fixture(50, 1.0, 1.0);
    egg.reconstruction.jumps.clear();
    assert!(!with_truth(&egg).contains("<h2>Jumps</h2>"));
    let jump = Jump {
        time_s: 0.5,
        psi_before_rad: 0.1,
        psi_after_rad: 0.1 - 0.5,
        height_before_m: 0.0412,
        height_after_m: 0.0400,
        physical: true,
    };
    egg.reconstruction.jumps = vec![jump, Jump { time_s: f64::NAN, physical: false, ..jump }];
    let html = with_truth(&egg);
    assert!(html.contains(
        "<td><button type=\"button\" data-time=\"0.5\">0.50 s</button></td><td>\u{2212}28.6°</td><td>1.20 mm</td><td>yes</td>"
    ));
    assert!(html.contains(">– s</button>") && html.contains("<td class=\"no\">no</td>"));
}

#[test]
fn arrangements_that_fit_equally_well_are_all_there() {
    let mut egg = fixture(50, 1.0, 1.0);
    assert!(!with_truth(&egg).contains("<fieldset"));
    let mut other = egg.reconstruction.clone();
    other.jumps.clear();
    other.motion.iter_mut().for_each(|pose| pose.psi_rad += 1.0);
    egg.reconstruction.verdict = Verdict::new(vec![Doubt::Alternatives { objects: 2 }]);
    egg.reconstruction.alternatives = 2;
    egg.reconstruction.others = vec![other];
    let html = with_truth(&egg);
    assert_eq!(html.matches("name=\"arrangement\"").count(), 2);
    assert_eq!(html.matches("<dl class=\"figures\"").count(), 2);
    let arrangements = data(&html)["arrangements"].clone();
    assert_eq!(arrangements.as_array().map(Vec::len), Some(2));
    assert_ne!(arrangements[0]["psi"], arrangements[1]["psi"]);
}

const RIG: &str = "What this log says about your rig</h2>";

#[test]
fn the_rig_is_there_when_one_was_stated() {
    let mut egg = fixture(50, 1.0, 1.0);
    assert!(!with_truth(&egg).contains(RIG));
    egg.reconstruction.calibration = Some(calibration());
    let html = with_truth(&egg);
    assert_eq!(html.matches(RIG).count(), 1);
    // The clock was stated to be exact.
    assert_eq!(html.matches("role=\"rowheader\"").count(), 6);
    assert!(!html.contains("clock of angles"));
    for shown in [
        "scope=\"row\">zero of pad 1</th>",
        "\u{2212}0.022 ± 0.023 mm<small>stated 0.00 ± 0.50 mm</small>",
        "<b>told by the log</b>, 22 times finer than stated<",
        "3.040 ± 0.023 mm<",
        "<b>6.1 prior sd off</b>: check pad 2: ",
        "0.49 ± 0.43 %<small>stated 0.0 ± 1.4 %</small>",
        "<b>partly told</b>, 3.3 times finer than stated<",
        "0.17 ± 0.46°<",
        "<b>not told by this log</b>: turn both palms together, far to either side, and slowly (gravity is the level)<",
        "1.392 ± 0.017°<small>stated 1.00 ± 0.50°</small>",
        "aria-label=\"stated 1.00 ± 1.00°, found 1.392 ± 0.034°, each with two standard deviations\"",
        "<b>Size:</b> known to 0.71\u{a0}% and 0.35\u{a0}mm all around, because no log can tell the common scale and the common surface \
         offset; measure them with a calliper.",
    ] {
        assert!(html.contains(shown), "{shown} is not there");
    }
    assert!(!html.contains("Do not correct the rig by them"));
    egg.reconstruction.verdict = Verdict::new(vec![Doubt::NotConvex]);
    assert!(with_truth(&egg).contains("Do not correct the rig by them"));
}

#[test]
fn an_exact_rig_has_no_table() {
    let mut egg = fixture(50, 1.0, 1.0);
    let mut exact = calibration();
    exact.constants.iter_mut().for_each(|constant| constant.prior_sd = 0.0);
    (exact.size_sd, exact.offset_sd_m) = (0.0, 0.0);
    egg.reconstruction.calibration = Some(exact);
    let html = with_truth(&egg);
    assert!(html.contains(RIG) && html.contains("stated to be exact") && !html.contains("role=\"table\""));
}

#[test]
fn each_arrangement_has_its_own_rig() {
    let mut egg = fixture(50, 1.0, 1.0);
    egg.reconstruction.calibration = Some(calibration());
    let mut other = egg.reconstruction.clone();
    other.calibration.as_mut().expect("a rig").constants[0].name = "{{size}}<b>".to_owned();
    egg.reconstruction.others = vec![other];
    let html = with_truth(&egg);
    assert_eq!(html.matches(RIG).count(), 2);
    assert!(html.contains("<section class=\"card full rig\" data-arrangement=\"1\" hidden>"));
    // A constant without words of ours keeps its name.
    assert!(html.contains("scope=\"row\">{{size}}&lt;b&gt;</th>"));
}

/// Any number a computer can hold.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        Just(0.0),
        Just(f64::MAX),
        Just(f64::MIN_POSITIVE),
        any::<f64>(),
        -1.0..1.0_f64
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn no_number_stops_the_page(numbers in prop::collection::vec(any_number(), 24), samples in 0_usize..40, motion in 0_usize..40) {
        let mut egg = fixture(samples, 1.0, 1.0);
        let at = |i: usize| numbers[i % numbers.len()];
        for (i, sample) in egg.log.samples.iter_mut().enumerate() {
            (sample.time_s, sample.palms.phi1_rad, sample.palms.base1_m[0]) = (at(i), at(i + 1), at(i + 2));
            sample.s1_m = Some(at(i + 3));
        }
        for (i, pose) in egg.reconstruction.motion.iter_mut().enumerate() {
            (pose.psi_rad, pose.psi_sd_rad, pose.com_x_m, pose.com_sd_m) = (at(i + 4), at(i + 5), at(i + 6), at(i + 7));
            (pose.residual1_m, pose.residual2_m, pose.piece) = (Some(at(i + 8)), None, i as u32 / 3);
        }
        for (i, point) in egg.reconstruction.outline.iter_mut().enumerate() {
            (point.theta_rad, point.r_m, point.r_sd_m, point.x_m) = (at(i), at(i + 1), at(i + 2), at(i + 3));
        }
        for (i, pose) in egg.truth.motion.iter_mut().enumerate() {
            (pose.psi_rad, pose.com_x_m) = (at(i + 9), at(i + 10));
        }
        egg.truth.support.truncate(motion);
        egg.reconstruction.motion.truncate(motion);
        egg.reconstruction.sensor_sd_m = at(11);
        egg.reconstruction.coverage = at(12);
        egg.reconstruction.jumps = numbers
            .iter()
            .map(|&time_s| Jump { time_s, psi_after_rad: at(15), height_after_m: at(16), ..Default::default() })
            .collect();
        egg.reconstruction.shape = palpate::shape::SupportFunction::new(at(13), vec![[at(14), at(15)]]);
        let mut rig = calibration();
        for (i, constant) in rig.constants.iter_mut().enumerate() {
            (constant.value, constant.sd, constant.stated, constant.prior_sd) = (at(i + 17), at(i + 18), at(i + 19), at(i + 20));
        }
        (rig.size_sd, rig.offset_sd_m) = (at(21), at(22));
        egg.reconstruction.calibration = Some(rig);
        egg.reconstruction.others = vec![egg.reconstruction.clone()];
        let html = with_truth(&egg);
        let (_, rig) = html.split_once(RIG).expect("the rig");
        let (rig, _) = rig.split_once("</section>").expect("an end of the rig");
        prop_assert!(!rig.contains("NaN") && !rig.contains("inf"), "{rig}");
        data(&html);
    }
}
