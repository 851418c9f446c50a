//! Ctrl-C: the first one ends a rendering early and keeps what there is, the second ends the program.

use std::process;
use std::sync::atomic::{AtomicU8, Ordering};

const RUNNING: u8 = 0;
const STOPPING: u8 = 1;
const WRITING: u8 = 2;

/// The exit status of a program that Ctrl-C ended: 128 + SIGINT.
pub const STATUS: u8 = 130;

static STATE: AtomicU8 = AtomicU8::new(RUNNING);

/// Catches Ctrl-C from now on. Where that cannot be had, Ctrl-C ends the program as it would anyway.
pub fn catch() {
    let _ = ctrlc::set_handler(|| {
        let before = STATE.compare_exchange(RUNNING, STOPPING, Ordering::Relaxed, Ordering::Relaxed);
        if before == Err(STOPPING) {
            process::exit(STATUS.into());
        }
    });
}

/// Whether Ctrl-C came.
pub fn came() -> bool {
    STATE.load(Ordering::Relaxed) == STOPPING
}

/// Lets Ctrl-C pass unheard from now on, so that no temporary file is left behind.
pub fn writing() {
    STATE.store(WRITING, Ordering::Relaxed);
}
