//! A headless Chromium over its debugging pipe: just enough of the DevTools protocol to click, look and listen.
//!
//! The pipe (file descriptors 3 and 4) needs no port and no library. A shell places the descriptors, because the standard
//! library cannot; the browser ends by itself when the pipe closes.
#![allow(dead_code, reason = "each test file uses its share")]

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// No verdict: it only ends a test that would wait for ever.
pub const PATIENCE: Duration = Duration::from_secs(1200);

/// Chromium, from `PALPATE_CHROMIUM` or the search path.
pub fn find_chromium() -> Option<PathBuf> {
    if let Some(chosen) = std::env::var_os("PALPATE_CHROMIUM") {
        return Some(PathBuf::from(chosen));
    }
    let folders = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    names.iter().find_map(|name| std::env::split_paths(&folders).map(|folder| folder.join(name)).find(|p| p.is_file()))
}

pub struct Browser {
    process: Child,
    input: Option<ChildStdin>,
    messages: Receiver<Value>,
    session: String,
    next_id: u64,
    /// Every event so far, as (method, parameters).
    pub events: Vec<(String, Value)>,
}

impl Browser {
    /// Starts the browser with an empty profile in `profile` and opens one empty page.
    pub fn start(chromium: &Path, profile: &Path) -> Self {
        let mut process = Command::new("sh")
            .args(["-c", "exec \"$@\" 3<&0 4>&1 </dev/null >&2", "sh"])
            .arg(chromium)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"])
            .args([
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
                "--disable-extensions",
            ])
            .args(["--hide-scrollbars", "--remote-debugging-pipe"])
            .arg(format!("--user-data-dir={}", profile.display()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("a shell to start the browser");
        let output = process.stdout.take().expect("a piped output");
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            for message in BufReader::new(output).split(0).map_while(Result::ok) {
                let Ok(message) = serde_json::from_slice(&message) else { continue };
                if sender.send(message).is_err() {
                    break;
                }
            }
        });
        let input = process.stdin.take();
        let mut browser = Self { process, input, messages, session: String::new(), next_id: 0, events: Vec::new() };
        let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attached =
            browser.call("Target.attachToTarget", json!({ "targetId": target["targetId"], "flatten": true }));
        browser.session = attached["sessionId"].as_str().expect("a session").to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// One call of the protocol; events that come meanwhile are kept.
    pub fn call(&mut self, method: &str, params: Value) -> Value {
        self.next_id += 1;
        let mut message = json!({ "id": self.next_id, "method": method, "params": params });
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        let mut bytes = message.to_string().into_bytes();
        bytes.push(0);
        let input = self.input.as_mut().expect("an open pipe");
        input.write_all(&bytes).and_then(|()| input.flush()).expect("a browser that listens");
        let deadline = Instant::now() + PATIENCE;
        loop {
            let answer = self.next(deadline).unwrap_or_else(|| panic!("no answer to {method} from the browser"));
            if answer["id"] == json!(self.next_id) {
                assert!(answer.get("error").is_none(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
        }
    }

    /// The next message; events are noted.
    fn next(&mut self, deadline: Instant) -> Option<Value> {
        let message = self.messages.recv_timeout(deadline.saturating_duration_since(Instant::now())).ok()?;
        if let Some(method) = message["method"].as_str() {
            self.events.push((method.to_owned(), message["params"].clone()));
        }
        Some(message)
    }

    /// Opens a file and waits until it has loaded.
    pub fn open(&mut self, page: &Path) -> String {
        let url = format!("file://{}", page.display());
        self.go(&url);
        url
    }

    /// Opens an address and waits until the page there has loaded.
    pub fn go(&mut self, url: &str) {
        let before = self.events.len();
        self.call("Page.navigate", json!({ "url": url }));
        let deadline = Instant::now() + PATIENCE;
        while !self.events[before..].iter().any(|(method, _)| method == "Page.loadEventFired") {
            assert!(self.next(deadline).is_some(), "the page did not load");
        }
    }

    /// The value of an expression in the page.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let answer = self
            .call("Runtime.evaluate", json!({ "expression": expression, "returnByValue": true, "awaitPromise": true }));
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {}", answer["exceptionDetails"]);
        answer["result"]["value"].clone()
    }

    /// Middle of an element in the window, after scrolling it into view.
    pub fn middle(&mut self, selector: &str) -> (f64, f64) {
        let place = self.evaluate(&format!(
            "(() => {{ const e = document.querySelector({selector:?}); e.scrollIntoView({{block: 'center', behavior: 'instant'}}); \
             const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; }})()"
        ));
        (place[0].as_f64().expect("an x"), place[1].as_f64().expect("a y"))
    }

    /// Moves the mouse to a place in the window.
    pub fn point_at(&mut self, (x, y): (f64, f64)) {
        self.call("Input.dispatchMouseEvent", json!({ "type": "mouseMoved", "x": x, "y": y }));
    }

    /// A real click at a place in the window.
    pub fn click_at(&mut self, (x, y): (f64, f64)) {
        for kind in ["mouseMoved", "mousePressed", "mouseReleased"] {
            let buttons = json!({ "type": kind, "x": x, "y": y, "button": "left", "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", buttons);
        }
    }

    /// A real click on the middle of an element.
    pub fn click(&mut self, selector: &str) {
        let place = self.middle(selector);
        self.click_at(place);
    }

    /// A tap with a finger.
    pub fn tap(&mut self, (x, y): (f64, f64)) {
        self.call("Input.dispatchTouchEvent", json!({ "type": "touchStart", "touchPoints": [{ "x": x, "y": y }] }));
        self.call("Input.dispatchTouchEvent", json!({ "type": "touchEnd", "touchPoints": [] }));
    }

    /// The page on paper, as PDF.
    pub fn pdf(&mut self) -> Vec<u8> {
        let answer = self.call("Page.printToPDF", json!({ "printBackground": true, "preferCSSPageSize": true }));
        base64(answer["data"].as_str().expect("a document"))
    }

    /// A key as `KeyboardEvent.key` names it.
    pub fn press(&mut self, key: &str) {
        let text = if key == " " { " " } else { "" };
        self.call("Input.dispatchKeyEvent", json!({ "type": "keyDown", "key": key, "text": text }));
        self.call("Input.dispatchKeyEvent", json!({ "type": "keyUp", "key": key }));
    }

    /// Size of the window and colour scheme of the system.
    pub fn window(&mut self, width: u32, height: u32, scheme: &str) {
        let mobile = width < 600;
        self.call(
            "Emulation.setDeviceMetricsOverride",
            json!({ "width": width, "height": height, "deviceScaleFactor": if mobile { 2 } else { 1 }, "mobile": mobile }),
        );
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": features }));
        self.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))");
    }

    /// Downloads go to a folder without being asked for.
    pub fn save_downloads_in(&mut self, folder: &Path) {
        self.call("Page.setDownloadBehavior", json!({ "behavior": "allow", "downloadPath": folder }));
    }

    /// The system of someone who wants less motion.
    pub fn less_motion(&mut self, scheme: &str) {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }, { "name": "prefers-reduced-motion", "value": "reduce" }]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": features }));
    }

    /// A picture of the whole page as PNG.
    pub fn screenshot(&mut self, file: &Path) {
        let size = self.evaluate("[document.documentElement.clientWidth, document.documentElement.scrollHeight]");
        let clip = json!({ "x": 0, "y": 0, "width": size[0], "height": size[1], "scale": 1 });
        let answer = self
            .call("Page.captureScreenshot", json!({ "format": "png", "captureBeyondViewport": true, "clip": clip }));
        std::fs::write(file, base64(answer["data"].as_str().expect("a picture"))).expect("a place for the picture");
    }

    /// What went wrong in the page so far: exceptions, errors on the console, blocked resources.
    pub fn complaints(&self) -> Vec<String> {
        self.events
            .iter()
            .filter(|(method, event)| match method.as_str() {
                "Runtime.exceptionThrown" => true,
                "Runtime.consoleAPICalled" => matches!(event["type"].as_str(), Some("error" | "warning" | "assert")),
                "Log.entryAdded" => matches!(event["entry"]["level"].as_str(), Some("error" | "warning")),
                _ => false,
            })
            .map(|(method, event)| format!("{method}: {event}"))
            .collect()
    }

    /// Addresses that were asked for, except data inside the page.
    pub fn requests(&self) -> Vec<String> {
        self.events
            .iter()
            .filter(|(method, _)| method == "Network.requestWillBeSent")
            .filter_map(|(_, event)| event["request"]["url"].as_str().map(str::to_owned))
            .filter(|url| !url.starts_with("data:"))
            .collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // A closed pipe ends the browser; if it does not, it is ended.
        self.input = None;
        for _ in 0..100 {
            if matches!(self.process.try_wait(), Ok(Some(_))) {
                return;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The bytes behind a base64 text.
fn base64(text: &str) -> Vec<u8> {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut bytes = Vec::with_capacity(text.len() * 3 / 4);
    let (mut bits, mut held) = (0_u32, 0);
    for digit in text.bytes().filter_map(|byte| DIGITS.iter().position(|&digit| digit == byte)) {
        bits = (bits << 6 | digit as u32) & 0xff_ffff;
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push((bits >> held) as u8);
        }
    }
    bytes
}
