//! The page of `palpate watch --serve` in a real browser: the object moves, the past can be looked at, nothing goes wrong on its console, and nothing but
//! the page itself is fetched. Skipped without Chromium as the report's test is (`crates/palpate-report/tests/browser.rs`), with the same variables.
#![cfg(unix)]
#![allow(clippy::print_stderr, reason = "who is without a browser must know")]

mod common;
#[path = "../../palpate-report/tests/devtools/mod.rs"]
mod devtools;

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Stdio};
use std::time::{Duration, Instant};

use common::{command, folder, palpate};
use devtools::{Browser, PATIENCE};

/// A stone that is turned round.
const PLAN: &str = "shape = 'pebble'\nmotion = 'turn'\nduration_s = 40\nrate_hz = 30\nspeed = 0\n";

/// An egg that is dragged over a pad.
const STROKES: &str = "motion = 'strokes'\nshape = 'egg'\nspeed = 0\n";

/// Lines that are sent at once, and the time between them: faster than a rig, and slow enough for the page to show what happens.
const AT_ONCE: usize = 15;
const PAUSE: Duration = Duration::from_millis(25);

/// A watch that is fed by the test, so that nothing depends on how soon a browser is there, and that is ended with it.
struct Watch {
    child: Child,
    input: Option<ChildStdin>,
    lines: Vec<String>,
    sent: usize,
}

impl Watch {
    /// Starts one over what a rig sends, and gives the address of its page.
    fn start(dir: &std::path::Path, plan: &str) -> (Self, String) {
        fs::write(dir.join("plan.toml"), plan).expect("a plan");
        assert_eq!(palpate(dir, &["record", "sim:plan.toml", "-o", "log.csv"]).code, Some(0));
        let log = fs::read_to_string(dir.join("log.csv")).expect("the recording");
        let arguments = ["watch", "-", "--serve", "127.0.0.1:0"];
        let child = command(dir, &arguments).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
        let mut child = child.expect("the program starts");
        let mut line = String::new();
        BufReader::new(child.stderr.take().expect("a pipe")).read_line(&mut line).expect("a line");
        let url = line.trim().strip_prefix("note: the page is at ").unwrap_or_else(|| panic!("{line}")).to_owned();
        let (input, lines) = (child.stdin.take(), log.lines().map(|line| format!("{line}\n")).collect());
        (Self { child, input, lines, sent: 0 }, url)
    }

    /// Sends lines up to this share of all.
    fn send_up_to(&mut self, share: f64) {
        let until = (share * self.lines.len() as f64) as usize;
        let input = self.input.as_mut().expect("an open pipe");
        for lines in self.lines[self.sent..until].chunks(AT_ONCE) {
            input.write_all(lines.concat().as_bytes()).expect("a program that listens");
            std::thread::sleep(PAUSE);
        }
        self.sent = until;
    }

    /// Sends the rest, and ends the source.
    fn send_all(&mut self) {
        self.send_up_to(1.0);
        self.input = None;
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn until(browser: &mut Browser, expression: &str) {
    let deadline = Instant::now() + PATIENCE;
    while browser.evaluate(expression) != true {
        assert!(Instant::now() < deadline, "{expression}");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
}

fn picture(browser: &mut Browser, name: &str) {
    if let Some(folder) = std::env::var_os("PALPATE_SCREENSHOTS") {
        browser.screenshot(&PathBuf::from(folder).join(name));
    }
}

/// Where the browser is; `None` where there need be none.
fn chromium() -> Option<PathBuf> {
    let found = devtools::find_chromium();
    if found.is_none() {
        let required = std::env::var("PALPATE_REQUIRE_CHROMIUM").is_ok_and(|value| value == "1");
        assert!(!required, "PALPATE_REQUIRE_CHROMIUM=1, but there is no Chromium (set PALPATE_CHROMIUM)");
        eprintln!("skipped: no Chromium found (set PALPATE_CHROMIUM to test the page)");
    }
    found
}

#[test]
fn the_page_shows_strokes_over_a_pad() {
    let Some(chromium) = chromium() else { return };
    let dir = folder();
    let (mut watch, url) = Watch::start(dir.path(), STROKES);
    let mut browser = Browser::start(&chromium, &dir.path().join("profile"));
    browser.window(1280, 900, "light");
    browser.go(&url);
    watch.send_up_to(0.5);
    until(&mut browser, "document.getElementById('object').getAttribute('visibility') === 'visible'");
    assert_eq!(browser.evaluate("document.getElementById('seen').textContent"), "Pad and object");
    let turn = "document.getElementById('object').getAttribute('transform')";
    let there = browser.evaluate(turn);
    watch.send_up_to(0.8);
    until(&mut browser, &format!("{turn} !== {there}"));
    picture(&mut browser, "strokes-light.png");
    watch.send_all();
    until(&mut browser, "ended && document.getElementById('status').textContent === 'ended: certified'");
    assert_eq!(
        browser.evaluate("document.querySelector('#verdict b').textContent"),
        "certified: shape about the pivot and motion"
    );
    for (width, height, scheme) in [(390, 844, "dark"), (320, 640, "light"), (1280, 900, "dark")] {
        browser.window(width, height, scheme);
        let widest = browser.evaluate("document.documentElement.scrollWidth").as_u64().expect("a width");
        assert!(widest <= u64::from(width), "{widest} pixels in a window of {width}");
        picture(&mut browser, &format!("strokes-{width}-{scheme}.png"));
    }
    // The contact is drawn on the pad, and the boundary where the contact is: what is felt in this moment may not be in the shape yet, so at the end.
    let apart = "(() => { const f = frames.filter(f => f.s[0] !== null && f.pose).pop(); at = frames.indexOf(f); show(f); \
         const c = contacts[0].getBoundingClientRect(), x = c.x + c.width / 2, y = c.y + c.height / 2; \
         const paths = [felt, unfelt].map(p => [p, p.getScreenCTM()]); let least = 1e9; \
         for (const [p, m] of paths) for (let l = 0; l < p.getTotalLength(); l += 0.2) { const q = p.getPointAtLength(l).matrixTransform(m); \
         least = Math.min(least, Math.hypot(q.x - x, q.y - y)); } return least; })()";
    let apart = browser.evaluate(apart).as_f64().expect("pixels");
    assert!(apart < 4.0, "{apart} pixels between the contact and the boundary");
    assert_eq!(browser.complaints(), Vec::<String>::new(), "the console complains");
}

#[test]
fn the_page_shows_what_is_felt_and_looks_back() {
    let Some(chromium) = chromium() else { return };
    let dir = folder();
    let (mut watch, url) = Watch::start(dir.path(), PLAN);

    // Viewers that take nothing do not hold it up.
    let address = url.trim_start_matches("http://").trim_end_matches('/').to_owned();
    let stalled: Vec<TcpStream> = (0..20)
        .map(|_| {
            let mut stream = TcpStream::connect(&address).expect("a connection");
            let request = format!("GET /events HTTP/1.1\r\nHost: {address}\r\n\r\n");
            stream.write_all(request.as_bytes()).expect("a request");
            stream
        })
        .collect();
    let half_open = TcpStream::connect(&address).expect("a connection");

    let mut browser = Browser::start(&chromium, &dir.path().join("profile"));
    browser.window(1280, 900, "light");
    browser.go(&url);
    watch.send_up_to(0.4);
    until(&mut browser, "document.getElementById('object').getAttribute('visibility') === 'visible'");
    let turn = "document.getElementById('object').getAttribute('transform')";
    let there = browser.evaluate(turn);
    watch.send_up_to(0.7);
    until(&mut browser, &format!("{turn} !== {there}"));
    until(&mut browser, "document.querySelector('#object .felt').getAttribute('d').length > 500");
    picture(&mut browser, "watch-light.png");

    // Paused it stays, and the slider goes back.
    browser.click("#pause");
    let paused = browser.evaluate(turn);
    let frames = browser.evaluate("frames.length").as_u64().expect("frames");
    watch.send_up_to(0.9);
    until(&mut browser, &format!("frames.length > {}", frames + 5));
    assert_eq!(browser.evaluate(turn), paused, "it moves though it is paused");
    watch.send_all();
    browser.evaluate(
        "(() => { const e = document.getElementById('time'); e.value = 1; e.dispatchEvent(new Event('input')); })()",
    );
    until(&mut browser, "document.getElementById('shown').textContent === frames[1].t.toFixed(1) + ' s'");
    browser.click("#pause");
    until(&mut browser, "document.getElementById('verdict').className === 'certified'");
    until(&mut browser, "ended && document.getElementById('status').textContent === 'ended: certified'");
    assert!(
        browser.evaluate("document.getElementById('felt').textContent").as_str().is_some_and(|felt| felt.len() > 10)
    );

    // Phone and dark, nothing wider than the window.
    for (width, height, scheme) in [(390, 844, "dark"), (320, 640, "light"), (1280, 900, "dark")] {
        browser.window(width, height, scheme);
        let widest = browser.evaluate("document.documentElement.scrollWidth").as_u64().expect("a width");
        assert!(widest <= u64::from(width), "{widest} pixels in a window of {width}");
        picture(&mut browser, &format!("watch-{width}-{scheme}.png"));
    }
    browser.click("#theme");
    assert_eq!(browser.evaluate("document.documentElement.dataset.theme"), "light");
    browser.save_downloads_in(dir.path());
    for (button, name, beginning) in
        [("#save-svg", "palpate.svg", "<svg"), ("#save-json", "palpate.json", "{\"shown\":{")]
    {
        browser.click(button);
        let deadline = Instant::now() + PATIENCE;
        let mut saved = String::new();
        while !saved.starts_with(beginning) {
            assert!(Instant::now() < deadline, "{name}: {saved:.100}");
            std::thread::sleep(std::time::Duration::from_millis(50));
            saved = fs::read_to_string(dir.path().join(name)).unwrap_or_default();
        }
        assert!(!saved.contains("var(") && !saved.contains("NaN"), "{name}");
    }

    // Who comes late sees the same, reopened after the end as well.
    let frames = browser.evaluate("frames.length").as_u64().expect("frames");
    browser.go(&url);
    until(&mut browser, &format!("ended && frames.length >= {frames} && outline !== null"));
    assert_eq!(browser.complaints(), Vec::<String>::new(), "the console complains");
    let asked = browser.requests();
    assert!(asked.iter().all(|asked| asked.starts_with(&url) || asked.starts_with("blob:")), "{asked:?}");
    drop((stalled, half_open, watch));
}

#[test]
fn a_page_that_cannot_be_served_ends_in_one_message() {
    let dir = folder();
    fs::write(dir.path().join("plan.toml"), PLAN).expect("a plan");
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = taken.local_addr().expect("an address").to_string();
    let child = command(dir.path(), &["watch", "sim:plan.toml", "--serve", &address]).stderr(Stdio::piped()).spawn();
    let mut child = child.expect("the program starts");
    assert_eq!(child.wait().expect("an end").code(), Some(1));
    let mut text = String::new();
    child.stderr.take().expect("a pipe").read_to_string(&mut text).expect("text");
    assert!(text.starts_with(&format!("error: --serve {address}: ")), "{text}");
}
