//! What a worker calls, and what it is called for: the only code that is not safe.
//!
//! A request is written where [`room`] says; [`respond`] answers it, and the answer lies where
//! [`reply`] and [`content`] say until the next one.
#![expect(unsafe_code, reason = "functions of another language, on memory they share")]

use crate::answer::{Answer, answer};
use crate::request::FileAt;
use std::cell::RefCell;
use std::io::{self, ErrorKind};
use std::ops::ControlFlow;
use std::panic;
use std::sync::Arc;
use torquewise::Event;
use torquewise::logs::{HeldBytes, LogInput};
use torquewise::stepwise::Progress;

#[link(wasm_import_module = "page")]
unsafe extern "C" {
    /// Puts bytes of a file at `into`; how many, or less than 0 where they cannot be had.
    fn read(file: u32, first: f64, into: *mut u8, length: usize) -> i32;
    /// Says what is done now; `rows` of it in all, 0 where that is not known.
    fn tell(text: *const u8, length: usize, rows: f64);
    /// So many more rows were read.
    fn passed(rows: usize);
    /// Says why the engine is about to stop.
    fn fail(text: *const u8, length: usize);
}

thread_local! {
    static REQUEST: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static REPLY: RefCell<(String, Vec<u8>)> = const { RefCell::new((String::new(), Vec::new())) };
}

/// Room for the text of a request.
#[unsafe(no_mangle)]
pub extern "C" fn room(length: usize) -> *mut u8 {
    REQUEST.with_borrow_mut(|request| {
        request.resize(length, 0);
        request.as_mut_ptr()
    })
}

/// Answers the request; bytes of the text of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn respond() -> usize {
    panic::set_hook(Box::new(|panic| {
        let text = panic.to_string();
        // SAFETY: the text is alive, and only read.
        unsafe { fail(text.as_ptr(), text.len()) }
    }));
    let request = REQUEST.with_borrow_mut(std::mem::take);
    let held = |file: &FileAt| {
        LogInput::held(&file.name, Arc::new(InPage { file: file.at, count: file.size }))
    };
    let Answer { json, content } = answer(&String::from_utf8_lossy(&request), &held, &watch);
    REPLY.set((json.to_string(), content));
    REPLY.with_borrow(|(json, _)| json.len())
}

/// Where the text of the answer lies.
#[unsafe(no_mangle)]
pub extern "C" fn reply() -> *const u8 {
    REPLY.with_borrow(|(json, _)| json.as_ptr())
}

/// Where the bytes of the answer lie.
#[unsafe(no_mangle)]
pub extern "C" fn content() -> *const u8 {
    REPLY.with_borrow(|(_, content)| content.as_ptr())
}

/// How many there are.
#[unsafe(no_mangle)]
pub extern "C" fn content_length() -> usize {
    REPLY.with_borrow(|(_, content)| content.len())
}

/// Tells the page what is done. To stop it, the page ends the worker.
fn watch(event: Event) -> ControlFlow<()> {
    let told = match event {
        Event::Stage(Progress::Working) => None,
        Event::Stage(stage) => Some((stage.to_string(), 0)),
        Event::Reading { doing, rows } => Some((doing.to_owned(), rows.unwrap_or_default())),
        Event::Rows(rows) => {
            // SAFETY: takes a number.
            unsafe { passed(rows) };
            None
        }
    };
    if let Some((text, rows)) = told {
        // SAFETY: the text is alive, and only read.
        unsafe { tell(text.as_ptr(), text.len(), rows as f64) };
    }
    ControlFlow::Continue(())
}

#[derive(Debug)]
struct InPage {
    file: u32,
    count: u64,
}

impl HeldBytes for InPage {
    fn count(&self) -> u64 {
        self.count
    }

    fn read(&self, first: u64, into: &mut [u8]) -> io::Result<usize> {
        // SAFETY: the page writes as many bytes as there is room for at most.
        let found = unsafe { read(self.file, first as f64, into.as_mut_ptr(), into.len()) };
        let refused = |_| {
            let reason = "the browser does not let it be read any more: choose the file again";
            io::Error::new(ErrorKind::PermissionDenied, reason)
        };
        usize::try_from(found).map_err(refused)
    }
}
