//! A headless Chromium, driven over its DevTools protocol.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use serde_json::{Value, json};
use std::env;
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket, connect};

/// Longer than any answer takes, shorter than anyone waits.
const PATIENCE: Duration = Duration::from_secs(60);

type Socket = WebSocket<MaybeTlsStream<TcpStream>>;

/// A browser that ends with its test.
pub(crate) struct Chromium {
    process: Child,
    /// `ws://127.0.0.1:port/…`, the address of the browser.
    address: String,
    _profile: TempDir,
}

impl Chromium {
    /// A new browser with an empty profile; `None`, once said so, where there is none.
    pub(crate) fn start() -> Option<Self> {
        let Some(program) = program() else {
            let required = env::var("TORQUEWISE_BROWSER_REQUIRED").is_ok_and(|value| value == "1");
            assert!(!required, "no Chromium: install it or name it in TORQUEWISE_CHROMIUM");
            eprintln!("skipped: no Chromium, name it in TORQUEWISE_CHROMIUM");
            return None;
        };
        let profile = TempDir::new().unwrap();
        let mut process = Command::new(&program)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic"])
            .args(["--no-first-run", "--disable-background-networking"])
            .args(["--disable-component-update", "--disable-sync", "--disable-dev-shm-usage"])
            .args(["--hide-scrollbars", "--window-size=1280,900", "--remote-debugging-port=0"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(process.stderr.take().unwrap()).lines();
        let address = lines.find_map(|line| {
            line.unwrap().strip_prefix("DevTools listening on ").map(str::to_owned)
        });
        // What it says from now on is read and forgotten, so that it never waits for a reader.
        std::thread::spawn(move || lines.for_each(drop));
        let address = address.expect("the browser ended before it listened");
        Some(Self { process, address, _profile: profile })
    }

    /// A new tab.
    pub(crate) fn tab(&mut self) -> Tab {
        let mut browser = Tab::connect(&self.address);
        let target = browser.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let id = target["targetId"].as_str().unwrap();
        let host = self.address.split('/').nth(2).unwrap();
        let mut tab = Tab::connect(&format!("ws://{host}/devtools/page/{id}"));
        for domain in ["Page", "Runtime", "Log", "Network"] {
            tab.call(&format!("{domain}.enable"), &json!({}));
        }
        tab
    }
}

impl Drop for Chromium {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn program() -> Option<String> {
    let answers = |program: &String| {
        let mut asked = Command::new(program);
        asked.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
        asked.status().is_ok_and(|status| status.success())
    };
    let named = env::var("TORQUEWISE_CHROMIUM").ok();
    let usual = ["chromium", "chromium-browser", "google-chrome"].map(str::to_owned);
    named.into_iter().chain(usual).find(answers)
}

/// One page of the browser.
pub(crate) struct Tab {
    socket: Socket,
    calls: u64,
    /// What happened since the tab was opened.
    events: Vec<Value>,
}

impl Tab {
    fn connect(address: &str) -> Self {
        let (socket, _) = connect(address).unwrap();
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
        }
        Self { socket, calls: 0, events: Vec::new() }
    }

    /// Calls a method of the protocol and waits for its answer.
    fn call(&mut self, method: &str, parameters: &Value) -> Value {
        self.calls += 1;
        let call = json!({ "id": self.calls, "method": method, "params": parameters });
        self.socket.send(Message::text(call.to_string())).unwrap();
        loop {
            let answer = self.next();
            if answer["id"] == self.calls {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.events.push(answer);
        }
    }

    /// The next thing the browser says.
    fn next(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.socket.read().unwrap() {
                return serde_json::from_str(&text).unwrap();
            }
        }
    }

    /// Opens a file and waits until its script is done.
    pub(crate) fn open(&mut self, path: &Path) {
        let url = format!("file://{}", path.display());
        self.call("Page.navigate", &json!({ "url": url }));
        let start = Instant::now();
        while self.value("document.documentElement?.dataset.ready ?? null").is_null() {
            assert!(start.elapsed() < PATIENCE, "never ready: {:?}", self.complaints());
        }
        self.settle();
    }

    /// Value of an expression in the page, or what it promises.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let parameters = json!({
            "expression": expression, "returnByValue": true, "awaitPromise": true
        });
        let answer = self.call("Runtime.evaluate", &parameters);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Waits until what was asked for is drawn.
    fn settle(&mut self) {
        let frame =
            "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))";
        self.value(&format!("{frame}.then(() => 0)"));
    }

    /// Errors and warnings of the console, and uncaught exceptions.
    pub(crate) fn complaints(&mut self) -> Vec<String> {
        self.settle();
        let is_complaint = |event: &&Value| match event["method"].as_str() {
            Some("Runtime.exceptionThrown" | "Log.entryAdded") => true,
            Some("Runtime.consoleAPICalled") => {
                ["error", "warning", "assert"].iter().any(|kind| event["params"]["type"] == *kind)
            }
            _ => false,
        };
        self.events.iter().filter(is_complaint).map(Value::to_string).collect()
    }

    /// How many addresses the page asked for.
    pub(crate) fn requests(&mut self) -> usize {
        self.settle();
        let sent = |event: &&Value| event["method"] == "Network.requestWillBeSent";
        self.events.iter().filter(sent).count()
    }

    /// Middle of an element, once it is in sight.
    pub(crate) fn middle(&mut self, selector: &str) -> [f64; 2] {
        let selector = json!(selector);
        let middle = self.value(&format!(
            "(() => {{ const element = document.querySelector({selector}); \
             element.scrollIntoView({{ block: 'center', behavior: 'instant' }}); \
             const box = element.getBoundingClientRect(); \
             return [box.x + box.width / 2, box.y + box.height / 2]; }})()"
        ));
        self.settle();
        [0, 1].map(|axis| middle[axis].as_f64().unwrap())
    }

    /// Does with the mouse what the protocol calls `kind`; with the left button for `clicks` > 0.
    pub(crate) fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], clicks: u32) {
        let button = if clicks > 0 { "left" } else { "none" };
        let parameters = json!({
            "type": kind, "x": x, "y": y, "button": button, "clickCount": clicks,
            "buttons": u32::from(clicks > 0),
        });
        self.call("Input.dispatchMouseEvent", &parameters);
        self.settle();
    }

    /// Screen or print, dark or light.
    pub(crate) fn emulate_media(&mut self, media: &str, scheme: &str) {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        let parameters = json!({ "media": media, "features": features });
        self.call("Emulation.setEmulatedMedia", &parameters);
        self.settle();
    }

    /// Another size of the window.
    pub(crate) fn resize(&mut self, width: u64, height: u64) {
        let parameters = json!({
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false
        });
        self.call("Emulation.setDeviceMetricsOverride", &parameters);
        self.settle();
    }

    /// The page on paper.
    pub(crate) fn pdf(&mut self) -> Vec<u8> {
        let answer = self.call("Page.printToPDF", &json!({ "preferCSSPageSize": true }));
        decoded(answer["data"].as_str().unwrap())
    }
}

/// Base64 as RFC 4648 has it.
fn decoded(text: &str) -> Vec<u8> {
    let sextet = |letter: u8| match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let letters: Vec<u8> = text.bytes().filter(|&letter| letter != b'=').collect();
    let bytes = letters.chunks(4).flat_map(|four| {
        let bits = four.iter().fold(0_u32, |bits, &letter| bits << 6 | u32::from(sextet(letter)));
        let bits = bits << (6 * (4 - four.len()));
        bits.to_be_bytes()[1..four.len()].to_vec()
    });
    bytes.collect()
}
