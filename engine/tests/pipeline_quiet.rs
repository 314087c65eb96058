//! Panics of components print nothing; those of other threads go to the hook that was there. One test, one process.

use std::panic::set_hook;
use std::sync::atomic::{AtomicUsize, Ordering};

use mobula::pipeline::{Config, Pipeline};

static HEARD: AtomicUsize = AtomicUsize::new(0);

#[test]
fn the_hook_that_was_there_hears_of_other_threads_only() {
    set_hook(Box::new(|_| {
        HEARD.fetch_add(1, Ordering::SeqCst);
    }));
    let mut pipeline = Pipeline::new((), Config::with_threads(2)).unwrap();
    pipeline.callbacks().at_frame("frail", 1, |_| panic!("caught"));
    let fault = pipeline.run(3).unwrap_err();
    assert!(fault.location.unwrap().contains("pipeline_quiet.rs"));
    // With RUST_BACKTRACE set the hook hears of everything.
    let loud = std::env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0");
    let heard = HEARD.load(Ordering::SeqCst);
    assert_eq!(heard, usize::from(loud));
    std::thread::spawn(|| panic!("not caught")).join().unwrap_err();
    assert_eq!(HEARD.load(Ordering::SeqCst), heard + 1);
}
