//! A headless Chromium, driven by its DevTools protocol (<https://chromedevtools.github.io/devtools-protocol/>) over a
//! pipe: JSON messages, each ended by a zero byte.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::harness::skip;

const PROGRAMS: &[&str] =
    &["chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// What a page gets at most for anything it is asked.
const PATIENCE: Duration = Duration::from_secs(60);

/// A browser with one page.
pub struct Browser {
    child: Child,
    input: ChildStdin,
    messages: Receiver<Value>,
    session: String,
    sent: u64,
    /// Events since the start, oldest first.
    events: Vec<Value>,
    _profile: tempfile::TempDir,
}

impl Browser {
    /// Starts the browser that is installed, with an empty profile and no network. Where there is none, the running test
    /// is skipped by name, or fails where `SHADOWGRAPH_CI` is `1`.
    pub fn start() -> Option<Self> {
        let starts = |program: &&&str| {
            let mut version = Command::new(program);
            version.arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|s| s.success())
        };
        // The pipe is set up by `sh`.
        let Some(program) = PROGRAMS.iter().find(|program| cfg!(unix) && starts(program)) else {
            assert!(
                std::env::var_os("SHADOWGRAPH_CI").is_none_or(|v| v != "1"),
                "no browser: none of {PROGRAMS:?} starts"
            );
            skip("no Chromium; Debian's package is chromium-headless-shell");
            return None;
        };
        Some(Self::of(program))
    }

    fn of(program: &str) -> Self {
        let profile = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
        // The browser reads commands from descriptor 3 and answers on 4. Its sandbox does not start for root; the pages
        // are the tests' own.
        let mut child = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 1>&2", program])
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--remote-debugging-pipe"])
            .arg("--host-resolver-rules=MAP * ~NOTFOUND")
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|error| panic!("{program} does not start: {error}"));
        let (input, output) = child.stdin.take().zip(child.stdout.take()).expect("both are piped");
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            let mut output = BufReader::new(output);
            let mut bytes = Vec::new();
            while output.read_until(0, &mut bytes).is_ok_and(|read| read > 0) {
                bytes.pop();
                let sent = serde_json::from_slice(&bytes).map(|message| sender.send(message));
                if !matches!(sent, Ok(Ok(()))) {
                    return;
                }
                bytes.clear();
            }
        });
        let session = String::new();
        let mut browser = Self { child, input, messages, session, sent: 0, events: Vec::new(), _profile: profile };
        let target = browser.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        browser.session = text(&browser.call("Target.attachToTarget", &attach)["sessionId"]);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), &json!({}));
        }
        let offline = json!({ "offline": true, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0 });
        browser.call("Network.emulateNetworkConditions", &offline);
        browser
    }

    /// Sends a command and gives its result. Panics where the browser refuses it or does not answer.
    pub fn call(&mut self, method: &str, parameters: &Value) -> Value {
        self.sent += 1;
        let mut message = json!({ "id": self.sent, "method": method, "params": parameters });
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        let bytes = format!("{message}\0");
        self.input.write_all(bytes.as_bytes()).unwrap_or_else(|error| panic!("{method}: {error}"));
        let id = self.sent;
        let answer = self.wait(method, |message| message["id"] == id);
        assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
        answer["result"].clone()
    }

    /// Opens a file, `hash` (`#…`) added to its address, and waits until its scripts have run.
    pub fn open(&mut self, file: &Path, hash: &str) {
        // An address that differs in its hash alone loads nothing.
        self.call("Page.navigate", &json!({ "url": "about:blank" }));
        self.wait("about:blank", |message| message["method"] == "Page.loadEventFired");
        self.events.clear();
        self.call("Page.navigate", &json!({ "url": format!("file://{}{hash}", file.display()) }));
        if !self.events.iter().any(|event| event["method"] == "Page.loadEventFired") {
            self.wait("the page", |message| message["method"] == "Page.loadEventFired");
        }
    }

    /// Runs an expression that has the page load itself anew, and waits until it has.
    pub fn reload_by(&mut self, expression: &str) {
        self.events.clear();
        self.evaluate(expression);
        if !self.events.iter().any(|event| event["method"] == "Page.loadEventFired") {
            self.wait("the page", |message| message["method"] == "Page.loadEventFired");
        }
    }

    /// The width and height of the window in CSS pixels, and whether the user wants dark pages.
    pub fn window(&mut self, [width, height]: [u32; 2], dark: bool) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600 });
        self.call("Emulation.setDeviceMetricsOverride", &size);
        let scheme = json!({ "name": "prefers-color-scheme", "value": if dark { "dark" } else { "light" } });
        self.call("Emulation.setEmulatedMedia", &json!({ "features": [scheme] }));
    }

    /// The value of an expression of JavaScript on the page. Panics where it throws.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let result = self.call("Runtime.evaluate", &parameters);
        assert!(result["exceptionDetails"].is_null(), "{expression}: {}", result["exceptionDetails"]);
        result["result"]["value"].clone()
    }

    /// Moves the mouse to a point in CSS pixels and, where asked to, clicks.
    pub fn mouse(&mut self, [x, y]: [f64; 2], click: bool) {
        let kinds: &[&str] = if click { &["mouseMoved", "mousePressed", "mouseReleased"] } else { &["mouseMoved"] };
        for kind in kinds {
            let button = if *kind == "mouseMoved" { "none" } else { "left" };
            let event = json!({ "type": kind, "x": x, "y": y, "button": button, "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", &event);
        }
    }

    /// Presses a key, by its name in JavaScript.
    pub fn key(&mut self, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            self.call("Input.dispatchKeyEvent", &json!({ "type": kind, "key": key, "code": key }));
        }
    }

    /// Writes what the window shows as a PNG file.
    pub fn picture(&mut self, path: &Path) {
        // Waits for a frame, so that what was asked before is on it.
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(0))))");
        let shot = self.call("Page.captureScreenshot", &json!({ "format": "png" }));
        let bytes = from_base64(&text(&shot["data"]));
        std::fs::write(path, bytes).unwrap_or_else(|error| panic!("cannot write {}: {error}", path.display()));
    }

    /// Errors and warnings of the page since it was opened: exceptions, the console's, what its policy refused.
    pub fn complaints(&mut self) -> Vec<String> {
        self.evaluate("0");
        let bad = |event: &&Value| {
            let parameters = &event["params"];
            let level = |value: &Value| value == "error" || value == "warning" || value == "assert";
            match event["method"].as_str() {
                Some("Runtime.exceptionThrown") => true,
                Some("Runtime.consoleAPICalled") => level(&parameters["type"]),
                Some("Log.entryAdded") => level(&parameters["entry"]["level"]),
                _ => false,
            }
        };
        self.events.iter().filter(bad).map(Value::to_string).collect()
    }

    /// Addresses that the page asked for since it was opened, its own among them.
    pub fn requests(&mut self) -> Vec<String> {
        self.evaluate("0");
        let asked = self.events.iter().filter(|event| event["method"] == "Network.requestWillBeSent");
        asked.map(|event| text(&event["params"]["request"]["url"])).collect()
    }

    /// Waits for a message; others on the way are kept as events.
    fn wait(&mut self, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let message = match self.messages.recv_timeout(left) {
                Ok(message) => message,
                Err(RecvTimeoutError::Timeout) => panic!("{what}: no answer from the browser in {PATIENCE:?}"),
                Err(RecvTimeoutError::Disconnected) => panic!("{what}: the browser has gone"),
            };
            let found = wanted(&message);
            if message["method"].is_string() {
                self.events.push(message.clone());
            }
            if found {
                return message;
            }
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // At the end of its input the browser ends as well; but nothing is to outlive the test.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_else(|| panic!("the browser gave {value}, not a text")).to_owned()
}

fn from_base64(text: &str) -> Vec<u8> {
    let value = |byte: u8| match byte {
        b'A'..=b'Z' => Some(byte - b'A'),
        b'a'..=b'z' => Some(byte - b'a' + 26),
        b'0'..=b'9' => Some(byte - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let (mut out, mut bits, mut count) = (Vec::with_capacity(text.len() / 4 * 3), 0u32, 0);
    for six in text.bytes().filter_map(value) {
        bits = bits << 6 | u32::from(six);
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_read() {
        assert_eq!(from_base64("AAEC/w=="), [0, 1, 2, 255]);
        assert_eq!(from_base64("+/8="), [251, 255]);
        assert_eq!(from_base64(""), [0; 0]);
    }
}
