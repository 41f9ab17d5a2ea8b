//! Opens the report in a real browser: nothing may go wrong on its console, nothing may be fetched, and play, slider,
//! keys and theme must do what they say.
//!
//! Looks for Chromium in `PALPATE_CHROMIUM` and on the search path. Without one the test is skipped with a note, unless
//! `PALPATE_REQUIRE_CHROMIUM=1`. `PALPATE_AXE` is the file of axe-core; without it, nobody looks at how accessible the page is. With `PALPATE_SCREENSHOTS=DIR` it also leaves pictures there.
#![cfg(unix)]
#![allow(clippy::print_stderr, reason = "who is without a browser must know")]

mod devtools;
mod fixture;
#[path = "fixture/strokes.rs"]
mod strokes;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use devtools::{Browser, PATIENCE};
use fixture::fixture;
use palpate::compare::TruthError;
use palpate::reconstruct::{Doubt, Verdict};
use palpate::shape::SupportFunction;
use palpate_report::{ReportInput, TruthOverlay, page};
use serde_json::json;

/// Runs `look` on a page in a browser, or skips with a note.
fn in_browser(html: &str, look: impl FnOnce(&mut Browser, &Path)) {
    let Some(chromium) = devtools::find_chromium() else {
        let required = std::env::var("PALPATE_REQUIRE_CHROMIUM").is_ok_and(|value| value == "1");
        assert!(!required, "PALPATE_REQUIRE_CHROMIUM=1, but there is no Chromium (set PALPATE_CHROMIUM)");
        eprintln!("skipped: no Chromium found (set PALPATE_CHROMIUM to test the page)");
        return;
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("report.html");
    std::fs::write(&file, html).expect("a place for the page");
    let mut browser = Browser::start(&chromium, &folder.path().join("profile"));
    browser.window(1400, 900, "light");
    let url = browser.open(&file);
    look(&mut browser, &file);
    assert_eq!(browser.complaints(), Vec::<String>::new(), "the console complains");
    assert!(browser.requests().iter().all(|asked| *asked == url), "the page fetched {:?}", browser.requests());
}

fn picture(browser: &mut Browser, name: &str) {
    if let Some(folder) = std::env::var_os("PALPATE_SCREENSHOTS") {
        browser.screenshot(&PathBuf::from(folder).join(name));
    }
}

fn transform(browser: &mut Browser) -> String {
    let value = browser.evaluate("document.getElementById('object').getAttribute('transform')");
    value.as_str().expect("the object has a transform").to_owned()
}

/// Where the object is once it is no longer there.
fn moved(browser: &mut Browser, from: &str, complaint: &str) -> String {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let now = transform(browser);
        if now != from {
            return now;
        }
        assert!(Instant::now() < deadline, "{complaint}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn time(browser: &mut Browser) -> f64 {
    browser.evaluate("Number(document.getElementById('time').value)").as_f64().expect("a time")
}

const ERRORS: TruthError =
    TruthError { rms_r_m: 7.4e-6, rms_form_m: 5.1e-6, hausdorff_m: 2.3e-5, rms_psi_rad: 0.0016, rms_com_m: 4.2e-6 };

fn egg_page() -> String {
    let egg = fixture(800, 12.0, 1.4);
    page(&ReportInput {
        title: "egg_full_turn.csv",
        log: &egg.log,
        reconstruction: &egg.reconstruction,
        truth: Some(TruthOverlay { truth: &egg.truth, errors: ERRORS }),
        seconds: 3.21,
        command: Some("palpate reconstruct egg_full_turn.csv -o egg --truth egg_full_turn.truth"),
        version: "0.1.0",
    })
}

#[test]
fn the_page_plays_scrubs_and_changes_theme() {
    in_browser(&egg_page(), |browser, _| {
        // Play: the object moves by itself, and the boundary fills in. Slowly, so that the end is not reached meanwhile.
        let at_rest = transform(browser);
        browser.evaluate("document.getElementById('speed').value = '0.1'");
        browser.click("#play");
        let rolling = moved(browser, &at_rest, "play did not move the object");
        moved(browser, &rolling, "the object stopped while playing");
        let drawn =
            "[...document.querySelectorAll('#object .felt')].reduce((n, p) => n + p.getAttribute('d').length, 0)";
        let early = browser.evaluate(drawn).as_f64().expect("a length");

        // Pause: it stays where it is.
        browser.click("#play");
        let paused = transform(browser);
        std::thread::sleep(Duration::from_millis(300));
        assert_eq!(paused, transform(browser), "pause did not stop the object");

        // The slider: a click at three quarters of it goes there.
        browser.evaluate("document.getElementById('time').scrollIntoView({block: 'center'})");
        let (x, y) = browser.middle("#time");
        let width = browser.evaluate("document.getElementById('time').clientWidth").as_f64().expect("a width");
        browser.click_at((x + 0.25 * width, y));
        let there = time(browser);
        assert!((there - 9.0).abs() < 0.4, "the slider went to {there} s instead of 9 s");
        assert_ne!(paused, transform(browser), "the slider did not move the object");
        let late = browser.evaluate(drawn).as_f64().expect("a length");
        assert!(late > early, "the boundary did not fill in: {early} -> {late}");

        // Keys: an arrow steps by one sample of 12 s / 799.
        browser.press("ArrowRight");
        let stepped = time(browser) - there;
        assert!(stepped > 0.0 && stepped < 0.031, "an arrow key stepped by {stepped} s");

        // Theme: the background changes, and stays changed.
        let background = "getComputedStyle(document.body).backgroundColor";
        let light = browser.evaluate(background);
        browser.click("#theme");
        assert_ne!(light, browser.evaluate(background), "the theme did not change");
        browser.click("#theme");
        assert_eq!(light, browser.evaluate(background), "the theme did not change back");

        // Pointing at a figure explains it, inside the window; pointing at a chart reads it out.
        let last = browser.middle(".figures .figure:nth-child(6)");
        browser.point_at(last);
        let tip = "(() => { const b = document.querySelector('.figures .figure:nth-child(6) .tip').getBoundingClientRect(); return b.width > 100 && b.right <= innerWidth; })()";
        assert_eq!(browser.evaluate(tip), json!(true), "no explanation inside the window");
        picture(browser, "tip.png");
        let words = "document.getElementById('psi-readout').textContent";
        let before = browser.evaluate(words);
        let stage = "document.getElementById('stage-readout').textContent";
        let on_stage = browser.evaluate(stage);
        let chart = browser.middle("#com");
        browser.point_at((chart.0 - 100.0, chart.1));
        assert_ne!(before, browser.evaluate(words), "pointing at a chart reads nothing out");
        assert_eq!(on_stage, browser.evaluate(stage), "pointing at a chart changed what is said about the stage");
        picture(browser, "hover.png");

        // A click on a chart over time goes to that time.
        let psi = browser.middle("#psi");
        browser.click_at(psi);
        assert!((time(browser) - 6.0).abs() < 0.5, "the chart went to {} s", time(browser));
    });
}

#[test]
fn the_page_fits_every_screen_in_both_themes() {
    in_browser(&egg_page(), |browser, file| {
        for (width, height) in [(1400, 900), (820, 1100), (390, 844), (320, 640)] {
            for scheme in ["light", "dark"] {
                browser.window(width, height, scheme);
                browser.open(file);
                browser.evaluate("document.getElementById('time').value = 7; document.getElementById('time').dispatchEvent(new Event('input'))");
                let overflow = "document.documentElement.scrollWidth - document.documentElement.clientWidth";
                assert_eq!(browser.evaluate(overflow), json!(0), "the page is wider than a window of {width} px");
                picture(browser, &format!("egg-{width}-{scheme}.png"));
            }
        }
    });
}

/// Plays at a speed at which a round takes about so many seconds.
fn play_in(browser: &mut Browser, seconds: f64) {
    // The speeds to choose from are no concern here.
    browser.evaluate(&format!(
        "(() => {{ const o = document.createElement('option'), t = document.getElementById('time'); \
         o.value = (t.max - t.min) / {seconds}; const s = document.getElementById('speed'); s.appendChild(o); s.value = o.value; }})()"
    ));
    browser.click("#play");
}

/// Waits until an expression is true.
fn until(browser: &mut Browser, expression: &str, complaint: &str) {
    let deadline = Instant::now() + PATIENCE;
    while browser.evaluate(expression) != json!(true) {
        assert!(Instant::now() < deadline, "{complaint}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// How much of what was inferred is shown.
const CLEAR: &str = "Number(document.querySelector('#object .body').getAttribute('opacity'))";

#[test]
fn the_motion_plays_as_a_loop_that_starts_blind() {
    in_browser(&egg_page(), |browser, file| {
        // Opened, it stands in the middle, with all that there is to see.
        assert!((time(browser) - 6.0).abs() < 0.02, "it opens at {} s", time(browser));
        assert_eq!(browser.evaluate(CLEAR), json!(1));
        // Played, it begins with palms and contacts alone.
        let record = "window.seen = []; new MutationObserver(() => seen.push([Number(document.getElementById('time').value), \
            Number(document.querySelector('#object .body').getAttribute('opacity'))])).observe(document.querySelector('#object .body'), \
            { attributes: true, attributeFilter: ['opacity'] })";
        browser.evaluate(record);
        play_in(browser, 4.0);
        until(browser, &format!("{CLEAR} === 1 && seen.some(([t]) => t < 0.8)"), "the outline did not appear");
        assert_eq!(browser.evaluate("seen.filter(([t, o]) => t < 0.8).every(([t, o]) => o === 0)"), json!(true));
        let haze = browser.evaluate("seen.some(([t, o]) => o > 0.05 && o < 0.95)");
        assert_eq!(haze, json!(true), "the outline did not condense");
        let contacts =
            "[...document.querySelectorAll('#stage .dot')].filter((dot) => dot.closest('[visibility=visible]')).length";
        assert_eq!(browser.evaluate(contacts), json!(2));
        // After the end it begins anew.
        until(browser, "seen.some(([t], k) => k && t < seen[k - 1][0] - 6)", "it plays but once");
        // A pause shows all that is known, at any time.
        browser.click("#play");
        assert_eq!(browser.evaluate(CLEAR), json!(1));

        // Who wants less motion gets neither the haze nor the loop.
        browser.less_motion("light");
        browser.open(file);
        browser.evaluate(record);
        play_in(browser, 1.0);
        until(browser, "Number(document.getElementById('time').value) > 11.99", "it did not play");
        until(browser, "!document.getElementById('play').classList.contains('playing')", "it did not stop at the end");
        assert_eq!(browser.evaluate("seen.every(([t, o]) => o === 1)"), json!(true));
    });
}

#[test]
fn the_readings_are_drawn_in_step_with_the_motion() {
    in_browser(&egg_page(), |browser, _| {
        let places = "[...document.querySelectorAll('#angles .dot, #contacts .dot')].map((dot) => \
            dot.getAttribute('visibility') === 'visible' ? Number(dot.getAttribute('cx')) : -1)";
        let before = browser.evaluate(places);
        assert_eq!(before.as_array().map(Vec::len), Some(4));
        browser.press("ArrowRight");
        browser.press("ArrowRight");
        let after = browser.evaluate(places);
        for (before, after) in before.as_array().into_iter().flatten().zip(after.as_array().into_iter().flatten()) {
            assert!(before.as_f64() > Some(0.0) && after.as_f64() > before.as_f64(), "{before} -> {after}");
        }
        let words = browser.evaluate("document.getElementById('contacts-readout').textContent");
        assert!(words.as_str().is_some_and(|words| words.contains("s₁") && words.contains("mm")), "{words}");
        // A click goes to that time on the stage too.
        let middle = browser.middle("#contacts");
        browser.click_at((middle.0 - 100.0, middle.1));
        assert!(time(browser) < 5.5, "the readings went to {} s", time(browser));
    });
}

#[test]
fn figures_and_motion_are_saved_as_files() {
    in_browser(&egg_page(), |browser, page| {
        let downloads = page.with_file_name("downloads");
        std::fs::create_dir(&downloads).expect("a folder");
        browser.save_downloads_in(&downloads);
        let saved = |name: &str| {
            let deadline = Instant::now() + PATIENCE;
            let file = downloads.join(name);
            loop {
                match std::fs::read(&file) {
                    Ok(bytes) if !bytes.is_empty() => return bytes,
                    _ => assert!(Instant::now() < deadline, "{name} was not saved"),
                }
                std::thread::sleep(Duration::from_millis(20));
            }
        };
        // Every figure has its buttons, and each of them gives a drawing that needs no style sheet.
        let cards = browser.evaluate(
            "[...document.querySelectorAll('.card:has(.save)')].map((card) => card.querySelector('.plot').id)",
        );
        assert_eq!(cards, json!(["shape", "stage", "angles", "contacts", "psi", "com", "support", "residual1"]));
        for id in cards.as_array().into_iter().flatten().filter_map(|id| id.as_str()) {
            let button = |kind: &str| {
                format!(
                    "[...document.querySelectorAll('.card:has(#{id}) .save button')].find((b) => b.textContent === '{kind}').click()"
                )
            };
            browser.evaluate(&button("SVG"));
            let svg = String::from_utf8(saved(&format!("egg_full_turn-{id}.svg"))).expect("text");
            let picture = palpate_report::paper::png(&svg).expect("a drawing that another program reads");
            assert!(picture.len() > 10_000, "{id}: {} bytes", picture.len());
            assert!(!svg.contains("light-dark") && !svg.contains("NaN") && svg.contains("stroke=\"rgb("), "{id}");
            browser.evaluate(&button("PNG"));
            let png = saved(&format!("egg_full_turn-{id}.png"));
            assert!(png.starts_with(b"\x89PNG") && png.len() > 10_000, "{id}: {} bytes", png.len());
            if let Some(folder) = std::env::var_os("PALPATE_SCREENSHOTS") {
                std::fs::write(Path::new(&folder).join(format!("saved-{id}.png")), png).expect("a place");
                std::fs::write(Path::new(&folder).join(format!("saved-{id}-resvg.png")), picture).expect("a place");
            }
        }
        // The motion, from its blind begin; what was shown comes back.
        let there = time(browser);
        browser.evaluate("document.getElementById('film').click()");
        let film = saved("egg_full_turn-motion.gif");
        assert!((time(browser) - there).abs() < 1e-9 && browser.evaluate(CLEAR) == json!(1));
        if let Some(folder) = std::env::var_os("PALPATE_SCREENSHOTS") {
            std::fs::write(Path::new(&folder).join("saved-motion.gif"), &film).expect("a place");
        }
        let mut decoder = gif::DecodeOptions::new().read_info(film.as_slice()).expect("a GIF");
        assert!(decoder.width() > 500 && film.len() < 2_500_000, "{} px, {} bytes", decoder.width(), film.len());
        let mut frames = 0;
        while decoder.read_next_frame().expect("a frame that can be read").is_some() {
            frames += 1;
        }
        assert_eq!(frames, 120);
    });
}

#[test]
fn the_outline_is_read_out_by_keys_and_by_taps() {
    in_browser(&egg_page(), |browser, _| {
        let words = "document.getElementById('shape-readout').textContent";
        let theta = "Number(document.getElementById('shape').getAttribute('aria-valuenow'))";
        let there = time(browser);
        browser.evaluate("document.getElementById('shape').focus()");
        for _ in 0..10 {
            browser.press("ArrowRight");
        }
        assert_eq!(browser.evaluate(theta), json!(9));
        let said = browser.evaluate("document.getElementById('shape').getAttribute('aria-valuetext')");
        assert!(said.as_str().is_some_and(|said| said.contains("θ 9.0°, r ") && said.contains("felt")), "{said}");
        assert!(browser.evaluate(words).as_str().is_some_and(|words| words.contains("9.0°")));
        assert_eq!(time(browser), there, "the keys moved the time");
        // The curve of r goes along.
        let support = browser.evaluate("document.getElementById('support-readout').textContent");
        assert!(support.as_str().is_some_and(|words| words.contains("9.0°")), "{support}");
        browser.press("Escape");
        assert!(browser.evaluate(words).as_str().is_some_and(|words| words.contains("tap it")));
        // A finger: what it tapped stays when it has left.
        browser.window(390, 844, "light");
        browser.evaluate("document.getElementById('shape').scrollIntoView({ block: 'center' })");
        let place = browser.evaluate(
            "(() => { const b = document.querySelector('#shape .felt').getBoundingClientRect(); return [b.left + 2, b.top + b.height / 2]; })()",
        );
        browser.tap((place[0].as_f64().expect("a place"), place[1].as_f64().expect("a place")));
        assert!(
            browser.evaluate(words).as_str().is_some_and(|words| words.contains("curvature")),
            "a tap says nothing"
        );
    });
}

#[test]
fn every_figure_has_a_name() {
    in_browser(&egg_page(), |browser, _| {
        let names = browser.evaluate(
            "[...document.querySelectorAll('.plot svg[role=img]')].map((svg) => svg.getAttribute('aria-label'))",
        );
        let names: Vec<&str> = names.as_array().into_iter().flatten().filter_map(|name| name.as_str()).collect();
        let distinct: std::collections::BTreeSet<&str> = names.iter().copied().collect();
        assert!(names.len() == 9 && distinct.len() == 9 && names.iter().all(|name| name.len() > 20), "{names:?}");
    });
}

#[test]
fn on_paper_the_motion_is_a_strip() {
    in_browser(&egg_page(), |browser, _| {
        let there = time(browser);
        browser.evaluate(
            "addEventListener('beforeprint', () => { window.printed = [...document.querySelectorAll('.strip figure')].map((f) => \
             f.textContent + f.querySelectorAll('g')[3].getAttribute('transform')); })",
        );
        let pdf = browser.pdf();
        assert!(pdf.starts_with(b"%PDF"));
        if let Some(folder) = std::env::var_os("PALPATE_SCREENSHOTS") {
            std::fs::write(Path::new(&folder).join("print.pdf"), &pdf).expect("a place");
        }
        let printed = browser.evaluate("[window.printed.length, new Set(window.printed).size]");
        assert_eq!(printed, json!([6, 6]), "six pictures of different times");
        assert_eq!(browser.evaluate("document.querySelectorAll('.strip figure').length"), json!(0));
        assert_eq!(time(browser), there);
        browser.window(700, 900, "light");
        browser.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
        browser.evaluate("dispatchEvent(new Event('beforeprint'))");
        picture(browser, "print.png");
    });
}

#[test]
fn without_scripts_the_shape_is_there() {
    in_browser(&egg_page(), |browser, page| {
        browser.call("Emulation.setScriptExecutionDisabled", json!({ "value": true }));
        browser.open(page);
        let html = browser.evaluate("document.querySelectorAll('.still .felt').length > 0 && document.querySelector('.still svg').getBoundingClientRect().width > 200");
        assert_eq!(html, json!(true));
        let blank = "[...document.querySelectorAll('.card:has(.plot)')].some((card) => card.offsetHeight > 0)";
        assert_eq!(browser.evaluate(blank), json!(false));
        picture(browser, "no-script.png");
    });
}

/// A page with all that there can be on one.
fn full_page() -> String {
    let mut egg = ambiguous_page().0;
    egg.reconstruction.calibration = Some(fixture::calibration());
    page(&ReportInput {
        title: "all_of_it.csv",
        log: &egg.log,
        reconstruction: &egg.reconstruction,
        truth: Some(TruthOverlay { truth: &egg.truth, errors: ERRORS }),
        seconds: 3.21,
        command: Some("palpate reconstruct all_of_it.csv"),
        version: "0.1.0",
    })
}

#[test]
fn nothing_on_the_page_is_out_of_reach() {
    let Some(axe) = std::env::var_os("PALPATE_AXE") else {
        eprintln!("skipped: PALPATE_AXE says nothing of where axe-core is");
        return;
    };
    let axe = std::fs::read_to_string(axe).expect("axe-core");
    for html in [egg_page(), full_page(), strokes::strokes().page()] {
        in_browser(&html, |browser, page| {
            for (width, scheme) in [(1400, "light"), (1400, "dark"), (390, "light"), (390, "dark")] {
                browser.window(width, 900, scheme);
                browser.open(page);
                browser.evaluate("document.querySelectorAll('details').forEach((details) => { details.open = true; })");
                browser.evaluate(&format!("{{ {axe} }}; true"));
                let found = browser.evaluate(
                    "axe.run().then((found) => found.violations.flatMap((rule) => rule.nodes.map((node) => \
                     `${rule.id}: ${node.target} ${node.any.concat(node.all).map((check) => check.message)[0] ?? ''}`)))",
                );
                assert_eq!(found, json!([]), "at {width} px, {scheme}");
            }
        });
    }
}

/// A result with another beside it that has a different shape and no jumps.
fn ambiguous_page() -> (fixture::Fixture, String) {
    let mut egg = fixture(800, 12.0, 1.4);
    let mut other = egg.reconstruction.clone();
    other.jumps.clear();
    other.shape = SupportFunction::new(1.2 * other.shape.mean_radius_m(), vec![[0.0, 0.0], [0.004, 0.0]]);
    for point in &mut other.outline {
        (point.x_m, point.y_m, point.r_m) = (1.35 * point.x_m, 1.1 * point.y_m, 1.2 * point.r_m);
    }
    for pose in &mut other.motion {
        (pose.psi_rad, pose.piece) = (1.3 * pose.psi_rad, 0);
    }
    let result = &mut egg.reconstruction;
    (result.verdict, result.alternatives) = (Verdict::new(vec![Doubt::Alternatives { objects: 2 }]), 2);
    result.others = vec![other];
    let html = page(&ReportInput {
        title: "two_answers.csv",
        log: &egg.log,
        reconstruction: &egg.reconstruction,
        truth: None,
        seconds: 3.21,
        command: None,
        version: "0.1.0",
    });
    (egg, html)
}

#[test]
fn the_choice_of_an_arrangement_changes_what_is_shown() {
    in_browser(&ambiguous_page().1, |browser, _| {
        let outline = "document.querySelector('#shape svg .body').getAttribute('d')";
        let radius = "[...document.querySelectorAll('dl.figures')].filter((e) => e.offsetHeight).map((e) => e.querySelector('dd').textContent).join()";
        let jumps = "[...document.querySelectorAll('.jumps')].filter((e) => e.offsetHeight).length";
        let look = |browser: &mut Browser| [outline, radius, jumps].map(|what| browser.evaluate(what));
        let first = look(browser);
        assert_eq!(first[2], json!(1), "the jumps are not listed");
        picture(browser, "arrangement-1.png");

        browser.evaluate("document.getElementById('time').value = 7; document.getElementById('time').dispatchEvent(new Event('input'))");
        browser.evaluate("document.querySelector('#card-shape details').open = true");
        browser.click("[name=arrangement][value='1']");
        let second = look(browser);
        assert_ne!(first[0], second[0], "the shape did not change");
        assert_ne!(first[1], second[1], "the figures did not change");
        assert_eq!(second[2], json!(0), "the jumps of another arrangement are listed");
        assert!((time(browser) - 7.0).abs() < 0.02, "the time went to {}", time(browser));
        assert_eq!(browser.evaluate("document.querySelector('#card-shape details').open"), json!(true));
        picture(browser, "arrangement-2.png");

        // What is shown moves, and only once.
        browser.click("[name=arrangement][value='0']");
        assert_eq!(look(browser), first, "the first arrangement did not come back");
        browser.evaluate("document.activeElement.blur()");
        let there = time(browser);
        browser.press("ArrowRight");
        let stepped = time(browser) - there;
        assert!(stepped > 0.0 && stepped < 0.031, "an arrow key stepped by {stepped} s");
        let at_rest = transform(browser);
        browser.click("#play");
        moved(browser, &at_rest, "play did not move the object");

        // A jump of the table is a time of the stage.
        browser.evaluate("document.querySelector('.jumps:not([hidden])').scrollIntoView()");
        let wanted = browser.evaluate("Number(document.querySelector('.jumps:not([hidden]) button').dataset.time)");
        let wanted = wanted.as_f64().expect("a time");
        browser.click(".jumps:not([hidden]) button");
        assert!((time(browser) - wanted).abs() < 1e-3, "the jump at {wanted} s led to {} s", time(browser));
        for (width, scheme) in [(390, "light"), (390, "dark"), (320, "light")] {
            browser.window(width, 844, scheme);
            let overflow = "document.documentElement.scrollWidth - document.documentElement.clientWidth";
            assert_eq!(browser.evaluate(overflow), json!(0), "the page is wider than a window of {width} px");
            picture(browser, &format!("arrangements-{width}-{scheme}.png"));
        }
    });
}

#[test]
fn a_poor_result_is_drawn_without_complaint() {
    let mut egg = fixture(300, 9.0, 1.6);
    egg.reconstruction.alternatives = 3;
    egg.reconstruction.chi2_per_dof = f64::NAN;
    egg.reconstruction.sensor_sd_m = f64::NAN;
    egg.reconstruction.verdict = Verdict::new(vec![
        Doubt::Misfit { left_m: f64::NAN, expected_m: 1e-4, stated: false },
        Doubt::LittleFelt { coverage: 0.2 },
        Doubt::Reported { text: "3 arrangements of the pieces fit equally well <script>alert(1)</script>".to_owned() },
    ]);
    for (i, pose) in egg.reconstruction.motion.iter_mut().enumerate() {
        if (100..140).contains(&i) {
            (pose.psi_rad, pose.com_x_m, pose.residual1_m) = (f64::NAN, f64::INFINITY, None);
            egg.log.samples[i].s1_m = None;
        }
    }
    egg.reconstruction.outline[5].r_sd_m = f64::NAN;
    egg.reconstruction.outline[300].x_m = f64::NAN;
    let input = ReportInput {
        title: "</title><script>alert(1)</script> & friends",
        log: &egg.log,
        reconstruction: &egg.reconstruction,
        truth: None,
        seconds: f64::NAN,
        command: None,
        version: "0.1.0",
    };
    in_browser(&page(&input), |browser, _| {
        assert!(!transform(browser).contains("NaN"));
        browser.click("#play");
        std::thread::sleep(Duration::from_millis(300));
        let broken = "[...document.querySelectorAll('svg *')].some((e) => [...e.attributes].some((a) => /NaN|Infinity/.test(a.value)))";
        assert_eq!(browser.evaluate(broken), json!(false), "NaN reached the drawing");
        picture(browser, "poor.png");
    });
}

#[test]
fn an_empty_result_is_drawn_without_complaint() {
    let nothing = fixture(0, 0.0, 1.0);
    let mut reconstruction = nothing.reconstruction.clone();
    reconstruction.outline.clear();
    reconstruction.verdict = Verdict::new(vec![Doubt::Reported { text: "the log has no samples".to_owned() }]);
    let input = ReportInput {
        title: "empty.csv",
        log: &nothing.log,
        reconstruction: &reconstruction,
        truth: None,
        seconds: 0.0,
        command: None,
        version: "0.1.0",
    };
    in_browser(&page(&input), |browser, _| {
        assert_eq!(browser.evaluate("document.getElementById('play').disabled"), json!(true));
        picture(browser, "empty.png");
    });
}

#[test]
fn the_rig_is_drawn_at_every_width() {
    let mut egg = fixture(200, 6.0, 1.0);
    egg.reconstruction.calibration = Some(fixture::calibration());
    let input = ReportInput {
        title: "a_rig.csv",
        log: &egg.log,
        reconstruction: &egg.reconstruction,
        truth: None,
        seconds: 1.0,
        command: None,
        version: "0.1.0",
    };
    in_browser(&page(&input), |browser, file| {
        for (width, scheme) in
            [(1400, "light"), (1400, "dark"), (820, "light"), (390, "light"), (390, "dark"), (320, "light")]
        {
            browser.window(width, 900, scheme);
            browser.open(file);
            let overflow = "document.documentElement.scrollWidth - document.documentElement.clientWidth";
            assert_eq!(browser.evaluate(overflow), json!(0), "the page is wider than a window of {width} px");
            // Pictures are wide enough to read, and lie within their card; words do not overlap them.
            let placed = "[...document.querySelectorAll('.rig tbody tr')].every((row) => { \
                 const box = (what) => row.querySelector(what).getBoundingClientRect(), card = document.querySelector('.rig').getBoundingClientRect(); \
                 const p = box('.picture > svg'), n = box('.number'), s = box('.says'); \
                 const apart = (a, b) => a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top; \
                 return p.width > (innerWidth < 700 ? 0.8 * row.offsetWidth : 140) && p.left >= card.left && s.right <= card.right && apart(p, n) && apart(p, s) && apart(n, s); })";
            assert_eq!(browser.evaluate(placed), json!(true), "the table is crammed in a window of {width} px");
            picture(browser, &format!("rig-{width}-{scheme}.png"));
        }
    });
}

#[test]
fn the_page_of_strokes_plays_and_fits_every_screen() {
    in_browser(&strokes::strokes().page(), |browser, page| {
        let at_rest = transform(browser);
        browser.evaluate("document.getElementById('speed').value = '0.25'");
        browser.click("#play");
        moved(browser, &at_rest, "play did not move the object");
        browser.click("#play");
        let paused = transform(browser);
        std::thread::sleep(Duration::from_millis(300));
        assert_eq!(paused, transform(browser), "pause did not stop the object");
        // A chart over time goes to the moment that it is pointed at.
        let before = time(browser);
        browser.evaluate("document.getElementById('psi').scrollIntoView({block: 'center'})");
        browser.click("#psi svg.broad");
        let there = time(browser);
        assert!((there - before).abs() > 1e-3, "{before} {there}");
        browser.evaluate("document.getElementById('stage').scrollIntoView({block: 'center'})");
        for (width, scheme) in [(1400, "light"), (1400, "dark"), (390, "light"), (390, "dark")] {
            browser.window(width, 900, scheme);
            browser.open(page);
            let over = "document.documentElement.scrollWidth - document.documentElement.clientWidth";
            assert_eq!(browser.evaluate(over), json!(0), "at {width} px something stands over");
            let shown = browser.evaluate(
                "[...document.querySelectorAll('#psi svg')].filter((svg) => svg.clientWidth > 0).map((svg) => svg.classList[0])",
            );
            assert_eq!(shown, json!([if width < 512 { "narrow" } else { "broad" }]));
            picture(browser, &format!("strokes-{width}-{scheme}.png"));
        }
    });
}
