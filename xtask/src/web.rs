//! The page: its engine compiled to WebAssembly, the page made around it, the program that serves it,
//! and all of it tried in a browser.

use crate::ci::{build_with, call, is_there, target};
use anyhow::{Context, Result, bail};
use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const TARGET: &str = "wasm32-unknown-unknown";

const APT: &str = "/usr/bin/apt-get";

/// Where Debian puts the sources of the library of Rust.
const SOURCES: &str = "/usr/lib/rustlib/src/rust/library";

/// Node that the page is made with, at least.
const LEAST_NODE: u32 = 18;

/// Largest engine, compressed \[bytes\].
const LARGEST_ENGINE: u64 = 6_000_000;

/// Builds the page into `web/dist` and the program that has it, and tries both; says what is missing
/// where it cannot.
///
/// - `profile`: folder that the program is built in, `release` or `debug`
pub(crate) fn run(root: &Path, profile: &str) -> Result<()> {
    let is_required = env::var_os("TORQUEWISE_WEB_REQUIRED").is_some();
    if is_required && Path::new(APT).exists() {
        install(&lacking())?;
    }
    if let Some((what, _)) = lacking().first() {
        if is_required {
            bail!("{what}");
        }
        eprintln!("skipped: {what}; docs/browser.md says what it takes");
        return Ok(());
    }
    let engine = engine(root)?;
    call(&mut npm(root, &["ci", "--ignore-scripts", "--no-audit", "--no-fund"]))?;
    call(&mut npm(root, &["run", "check"]))?;
    call(npm(root, &["run", "build"]).env("TORQUEWISE_ENGINE", &engine))?;
    let page = root.join("web/dist");
    let size = fs::metadata(page.join("engine.js")).context("no engine in the page")?.len();
    // In base64 three bytes are four.
    let compressed = size / 4 * 3;
    eprintln!("engine: {:.1} MB, compressed", compressed as f64 / 1e6);
    if compressed > LARGEST_ENGINE {
        bail!("the engine has {compressed} bytes, at most {LARGEST_ENGINE} are allowed");
    }
    let program = build_with(root, &page, profile)?;
    let mut npm = npm(root, &["test"]);
    call(npm.env("TORQUEWISE_CHROMIUM", chromium()).env("TORQUEWISE_PROGRAM", program))
}

fn npm(root: &Path, words: &[&str]) -> Command {
    let mut npm = Command::new("npm");
    npm.args(words).current_dir(root.join("web"));
    npm
}

/// What is missing, and the packages of Debian that have it.
fn lacking() -> Vec<(&'static str, &'static str)> {
    let by_debian = Path::new(SOURCES).exists() && is_there("wasm-ld-19");
    let has_chromium = is_there(chromium());
    let has_node = node().is_some_and(|node| node >= LEAST_NODE) && is_there("npm");
    let needs = [
        (
            rustup_has_target() || by_debian,
            "no Rust for wasm32-unknown-unknown, which `rustup target add` has",
            "rustc-web cargo-web rust-web-src lld-19",
        ),
        (is_there(clang()), "no clang, which compiles zstd to WebAssembly", "clang-19"),
        (has_node, "no Node.js 18 or newer with npm", "nodejs npm"),
        (has_chromium, "no Chromium: install it or name it in TORQUEWISE_CHROMIUM", "chromium"),
    ];
    let lacks = needs.into_iter().filter(|(is_there, ..)| !is_there);
    lacks.map(|(_, what, packages)| (what, packages)).collect()
}

fn install(lacking: &[(&str, &str)]) -> Result<()> {
    let packages: Vec<&str> = lacking.iter().flat_map(|(_, names)| names.split(' ')).collect();
    if packages.is_empty() {
        return Ok(());
    }
    let apt = |words: &[&str]| {
        let mut apt = Command::new(APT);
        apt.args(["-qq", "-o", "Dpkg::Use-Pty=0"]).args(words).stdout(Stdio::null());
        call(apt.env("DEBIAN_FRONTEND", "noninteractive"))
    };
    apt(&["update"])?;
    apt(&[&["install", "--yes", "--no-install-recommends"][..], &packages].concat())
}

/// Compiles the engine; by rustup where it has the target, else by the Rust of Debian, which has
/// no library for it and compiles that too.
fn engine(root: &Path) -> Result<PathBuf> {
    let folder = target(root).join("web");
    let by_rustup = rustup_has_target();
    let mut cargo = Command::new(if by_rustup { "cargo" } else { "/usr/bin/cargo" });
    cargo.current_dir(root).args(["rustc", "--package", "torquewise-web", "--lib", "--locked"]);
    cargo.args(["--crate-type", "cdylib", "--profile", "web", "--target", TARGET, "--target-dir"]);
    cargo.arg(&folder).env_remove("RUSTC").env_remove("CARGO_TARGET_DIR");
    cargo.env_remove("CARGO_ENCODED_RUSTFLAGS");
    // A stack as large as that of a thread elsewhere.
    cargo.env("RUSTFLAGS", "-Ctarget-feature=+simd128 -Clink-arg=-zstack-size=4194304");
    cargo.env("CC_wasm32_unknown_unknown", clang());
    if !by_rustup {
        cargo.args(["-Z", "build-std=std,panic_abort"]);
        cargo.env("RUSTC", "/usr/bin/rustc").env("RUSTC_BOOTSTRAP", "1");
        cargo.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", "wasm-ld-19");
    }
    call(&mut cargo)?;
    Ok(folder.join(TARGET).join("web/torquewise_web.wasm"))
}

fn rustup_has_target() -> bool {
    let mut rustc = Command::new("rustc");
    rustc.args(["--print", "target-libdir", "--target", TARGET]);
    let folder = rustc.output().ok().filter(|output| output.status.success());
    let folder = folder.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    folder.is_some_and(|folder| Path::new(&folder).exists())
}

fn clang() -> &'static str {
    if is_there("clang-19") { "clang-19" } else { "clang" }
}

fn chromium() -> OsString {
    env::var_os("TORQUEWISE_CHROMIUM").unwrap_or_else(|| "chromium".into())
}

/// Its first number.
fn node() -> Option<u32> {
    let output = Command::new("node").arg("--version").output().ok()?;
    let version = String::from_utf8_lossy(&output.stdout).into_owned();
    version.trim_start_matches('v').split('.').next()?.parse().ok()
}
