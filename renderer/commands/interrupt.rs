//! Ctrl-C: the first one ends the work early and keeps what there is, the second ends the program.

use std::process;
use std::sync::atomic::{AtomicU8, Ordering};

/// The exit status of a program that Ctrl-C ended: 128 + SIGINT.
pub const STATUS: u8 = 130;

/// Set while files are being written, beside the number of times that Ctrl-C came.
const WRITING: u8 = 0x80;
/// More than once is all the same.
const TWICE: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(0);

/// Catches Ctrl-C from now on. Where that cannot be had, Ctrl-C ends the program as it would anyway.
pub fn catch() {
    let _ = ctrlc::set_handler(|| {
        let count = |state: u8| Some(state & WRITING | ((state & !WRITING) + 1).min(TWICE));
        let before = STATE.fetch_update(Ordering::Relaxed, Ordering::Relaxed, count).unwrap_or_default();
        if before & WRITING == 0 && before + 1 >= TWICE {
            process::exit(STATUS.into());
        }
    });
}

/// Whether Ctrl-C came.
pub fn came() -> bool {
    STATE.load(Ordering::Relaxed) & !WRITING != 0
}

/// Does what must not be cut short, so that no temporary file is left behind: a second Ctrl-C ends the program after
/// it.
pub fn spare<T>(work: impl FnOnce() -> T) -> T {
    STATE.fetch_or(WRITING, Ordering::Relaxed);
    let result = work();
    let state = STATE.fetch_and(!WRITING, Ordering::Relaxed);
    if state & !WRITING >= TWICE {
        process::exit(STATUS.into());
    }
    result
}
