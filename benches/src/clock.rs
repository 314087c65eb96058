//! Time: what one thread used of its core, and how many ticks of the time stamp counter that is.
//!
//! On a shared machine the counter runs on while somebody else has the core. So cycles are thread time multiplied by the
//! counter's frequency, which is measured once; the counter itself is kept beside them.

use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

/// How long something took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Elapsed {
    /// Seconds in which this thread had the core.
    pub thread: f64,
    /// Seconds in which all threads of this process had cores.
    pub process: f64,
    /// Seconds on the wall.
    pub wall: f64,
}

/// Does `work` and says how long it took.
pub fn time<R>(work: impl FnOnce() -> R) -> (R, Elapsed) {
    let seconds = || (seconds(ClockId::ThreadCPUTime), seconds(ClockId::ProcessCPUTime));
    let (wall, (thread, process)) = (Instant::now(), seconds());
    let result = work();
    let (thread_end, process_end) = seconds();
    let wall = wall.elapsed().as_secs_f64();
    (result, Elapsed { thread: thread_end - thread, process: process_end - process, wall })
}

fn seconds(clock: ClockId) -> f64 {
    let time = clock_gettime(clock);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Ticks of the time stamp counter.
#[cfg(target_arch = "x86_64")]
fn ticks() -> u64 {
    // SAFETY: every x86-64 processor has the instruction; it reads a counter and touches no memory.
    unsafe { core::arch::x86_64::_rdtsc() }
}

/// Nanoseconds, where there is no counter.
#[cfg(not(target_arch = "x86_64"))]
fn ticks() -> u64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_nanos() as u64
}

/// Ticks of the time stamp counter in a second, measured over a fifth of one.
pub fn tick_frequency() -> f64 {
    let (start, first) = (Instant::now(), ticks());
    std::thread::sleep(Duration::from_millis(200));
    let (last, elapsed) = (ticks(), start.elapsed());
    (last - first) as f64 / elapsed.as_secs_f64()
}

/// The processor, its caches, and the counter's frequency, in a line.
pub fn machine(ticks_per_second: f64) -> String {
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        let line = cpuinfo.lines().find(|line| line.starts_with(name));
        line.and_then(|line| line.split_once(':')).map_or("?", |(_, value)| value.trim()).to_owned()
    };
    let cache = |index: u32| {
        let read = |what: &str| {
            let text = std::fs::read_to_string(format!("/sys/devices/system/cpu/cpu0/cache/index{index}/{what}"));
            Some(text.ok()?.trim().to_owned())
        };
        Some(format!("L{} {} {}", read("level")?, read("type")?.to_lowercase(), read("size")?))
    };
    let caches: Vec<String> = (0..4).filter_map(cache).collect();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    format!(
        "{} (family {}, model {}), {threads} hardware threads, {}, TSC {:.3} GHz",
        field("model name"),
        field("cpu family"),
        field("model\t"),
        caches.join(", "),
        ticks_per_second * 1e-9
    )
}
