//! `serve`: the page that fits logs in the browser, handed out by the program itself.

use crate::{CliError, Outcome, Result};
use clap::Args;
use std::io;
use std::process::{Command, Stdio};
use std::thread;
use tiny_http::{Header, Request, Response, Server};

/// Name and compressed content of each file of the page; none in a program built without it.
const PAGE: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/page.rs"));

/// Open the page that fits logs in the browser, until Ctrl-C
///
/// The page is the one in this program, for this machine alone: no log and no model leaves it.
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Port of 127.0.0.1 to listen on [default: any that is free]
    #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Print the address and open no browser
    #[arg(long)]
    no_browser: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    if PAGE.is_empty() {
        return Err(CliError::NoPage);
    }
    let address = format!("127.0.0.1:{}", arguments.port);
    let server = Server::http(&address).map_err(|source| CliError::Port { address, source })?;
    let address = format!("http://{}/", server.server_addr());
    eprintln!("{address} until Ctrl-C");
    if !arguments.no_browser {
        open(&address);
    }
    loop {
        match server.recv() {
            // One that is slow keeps no other waiting; a browser may turn away from what it asked for.
            Ok(request) => drop(thread::spawn(move || answer(request))),
            Err(source) => return Err(CliError::Port { address, source: source.into() }),
        }
    }
}

fn answer(request: Request) -> io::Result<()> {
    let path = request.url().split(['?', '#']).next().unwrap_or_default();
    let name = if path == "/" { "index.html" } else { path.trim_start_matches('/') };
    let Some((name, content)) = PAGE.iter().find(|(file, _)| *file == name) else {
        return request.respond(Response::from_string("not found").with_status_code(404));
    };
    let is_html = *name == "index.html";
    let kind = if is_html { "text/html; charset=utf-8" } else { "text/javascript; charset=utf-8" };
    let header = |field: &str, value: &str| Header::from_bytes(field, value).ok();
    let mut response = Response::from_data(*content);
    let own = [header("Content-Type", kind), header("Content-Encoding", "gzip")];
    own.into_iter().flatten().for_each(|header| response.add_header(header));
    request.respond(response)
}

/// Shows an address in the browser of whoever sits here; the address is printed where there is none.
fn open(address: &str) {
    let words: &[&str] = if cfg!(windows) {
        &["cmd", "/C", "start"]
    } else if cfg!(target_os = "macos") {
        &["open"]
    } else {
        &["xdg-open"]
    };
    let mut program = Command::new(words[0]);
    program.args(&words[1..]).arg(address);
    let _ = program.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
}
