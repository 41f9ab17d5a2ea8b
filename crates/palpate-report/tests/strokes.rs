//! The page of a pivoting grasp, without a browser.

#[path = "fixture/strokes.rs"]
mod fixture;

use fixture::strokes;
use palpate::pivot::{PivotDoubt, PivotLog, PivotRig};
use palpate_report::{StrokesInput, strokes_page};

/// What is shown without the script.
fn before_the_script(html: &str) -> &str {
    html.split_once("id=\"data\"").expect("data in the page").0
}

#[test]
fn what_was_found_stands_in_the_page() {
    let egg = strokes();
    assert!(egg.found.is_certified(), "{:?}", egg.found.doubts);
    let html = egg.page();
    assert!(html.contains("Certified") && html.contains("Outline known to ±") && html.contains("Against the truth"));
    assert!(html.contains("Zero of the pad") && html.contains("not told by a log of strokes"));
    assert!(!before_the_script(&html).contains("NaN") && !html.contains("{{"));
    assert!(html.len() < 1_500_000, "{} bytes", html.len());
    let (before, rest) = html.split_once("<link rel=\"icon\"").expect("an icon");
    let (_, after) = rest.split_once('>').expect("an end of the icon");
    for forbidden in ["src=", "@import", "url(http", "href=", "<link", "fetch("] {
        assert!(!before.contains(forbidden) && !after.contains(forbidden), "{forbidden}");
    }
    // What is drawn without a script: outline, band, five charts in two widths each.
    let body = before_the_script(&html);
    assert_eq!(body.matches("svg class=\"broad\"").count(), 6);
    assert!(body.contains("class=\"band\"") && body.contains("class=\"truth\"") && body.contains("class=\"unfelt\""));
}

#[test]
fn reasons_stand_beside_the_badge_and_no_markup_comes_in() {
    let mut egg = strokes();
    egg.found.doubts = vec![PivotDoubt::Leaps { leaps: 3 }];
    let rig = PivotRig::exact(egg.rig.pad);
    let html = strokes_page(&StrokesInput {
        title: "<script>alert(1)</script>",
        log: &egg.log,
        rig: &rig,
        reconstruction: &egg.found,
        truth: None,
        seconds: 1.0,
        command: None,
        version: "0.1.0",
    });
    assert!(html.contains("leaps 3 times") && html.contains("Drag more slowly") && html.contains("Not certified"));
    assert!(!html.contains("<script>alert") && !html.contains("Outline known") && !html.contains("Zero of the pad"));
}

#[test]
fn a_result_without_anything_is_a_page() {
    let mut egg = strokes();
    egg.found.outline.clear();
    egg.found.motion.clear();
    (egg.found.coverage, egg.found.chi2_per_dof) = (0.0, f64::NAN);
    let html = strokes_page(&StrokesInput {
        title: "nothing",
        log: &PivotLog::default(),
        rig: &egg.rig,
        reconstruction: &egg.found,
        truth: None,
        seconds: 0.0,
        command: None,
        version: "0.1.0",
    });
    let drawn = before_the_script(&html);
    assert!(drawn.contains("no outline") && !drawn.contains("NaN") && html.ends_with("</html>\n"));
}
