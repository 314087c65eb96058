//! What a run took: frames, times, and where the time of each thread went.

use std::time::Duration;

use super::stage::Balance;

/// The account of one run.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Frames rendered.
    pub frames: u64,
    /// Wall time of the run in seconds.
    pub seconds: f64,
    /// Statistics of the frame times.
    pub frame_times: FrameTimes,
    /// Time in which one thread worked at the barrier while the others waited: transactions, serial callbacks, setup of
    /// stages. Seconds; idle sleep not included.
    pub serial_seconds: f64,
    /// Transactions carried out (a batch counts once).
    pub transactions: u64,
    /// Each render thread that took part, by index.
    pub threads: Vec<ThreadReport>,
    /// Each stage, in the order in which frames pass through.
    pub stages: Vec<StageReport>,
    /// Whether there were ever more threads than cores.
    pub oversubscribed: bool,
    /// What did not go as asked for: threads that could not be started or pinned.
    pub notes: Vec<String>,
}

impl Report {
    /// Frames per second over the whole run.
    pub fn frames_per_second(&self) -> f64 {
        if self.seconds > 0.0 { self.frames as f64 / self.seconds } else { 0.0 }
    }
}

/// Frame times in seconds, from barrier to barrier. The quantiles are those of the last 4096 frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// Shortest.
    pub min: f64,
    /// Arithmetic mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// 95 of 100 frames took no longer.
    pub p95: f64,
    /// Longest.
    pub max: f64,
}

/// Where the time of one thread went, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThreadReport {
    /// Index of the thread.
    pub index: usize,
    /// In stages and parallel callbacks.
    pub busy_seconds: f64,
    /// At the barrier, waiting for others.
    pub waiting_seconds: f64,
    /// At the barrier, doing serial work for all.
    pub serial_seconds: f64,
    /// Whether it was pinned to a core of its own.
    pub pinned: bool,
}

/// What one stage took.
#[derive(Clone, Debug, PartialEq)]
pub struct StageReport {
    /// Its name.
    pub name: String,
    /// How its work is shared.
    pub balance: Balance,
    /// Time in it, in seconds, all threads together.
    pub seconds: f64,
}

impl StageReport {
    pub(super) fn new(name: &str, balance: Balance) -> Self {
        Self { name: name.to_owned(), balance, seconds: 0.0 }
    }
}

const KEPT_TIMES: usize = 4096;

/// Collects frame times in bounded memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Stopwatch {
    count: u64,
    sum: f64,
    min: f64,
    max: f64,
    last: Vec<f64>,
}

impl Stopwatch {
    pub(super) fn record(&mut self, time: Duration) {
        let seconds = time.as_secs_f64();
        self.min = if self.count == 0 { seconds } else { self.min.min(seconds) };
        self.max = self.max.max(seconds);
        self.sum += seconds;
        if self.last.len() < KEPT_TIMES {
            self.last.push(seconds);
        } else {
            self.last[(self.count % KEPT_TIMES as u64) as usize] = seconds;
        }
        self.count += 1;
    }

    pub(super) fn frames(&self) -> u64 {
        self.count
    }

    pub(super) fn times(&self) -> FrameTimes {
        if self.count == 0 {
            return FrameTimes::default();
        }
        let mut sorted = self.last.clone();
        sorted.sort_by(f64::total_cmp);
        let quantile = |q: f64| sorted[((sorted.len() - 1) as f64 * q).round() as usize];
        FrameTimes {
            min: self.min,
            mean: self.sum / self.count as f64,
            median: quantile(0.5),
            p95: quantile(0.95),
            max: self.max,
        }
    }
}

/// One thread's own account, added to the report when it leaves.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    pub(super) busy: Duration,
    pub(super) waiting: Duration,
    pub(super) serial: Duration,
    pub(super) stages: Vec<Duration>,
}

impl Tally {
    pub(super) fn add_stage(&mut self, stage: usize, time: Duration) {
        if self.stages.len() <= stage {
            self.stages.resize(stage + 1, Duration::ZERO);
        }
        self.stages[stage] += time;
    }
}

impl Report {
    pub(super) fn add(&mut self, index: usize, pinned: bool, tally: &Tally) {
        let place = self.threads.iter().position(|thread| thread.index == index).unwrap_or_else(|| {
            self.threads.push(ThreadReport { index, ..ThreadReport::default() });
            self.threads.len() - 1
        });
        let thread = &mut self.threads[place];
        thread.busy_seconds += tally.busy.as_secs_f64();
        thread.waiting_seconds += tally.waiting.as_secs_f64();
        thread.serial_seconds += tally.serial.as_secs_f64();
        thread.pinned |= pinned;
        for (stage, time) in self.stages.iter_mut().zip(&tally.stages) {
            stage.seconds += time.as_secs_f64();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_times_stay_bounded() {
        let mut watch = Stopwatch::default();
        assert_eq!(watch.times(), FrameTimes::default());
        for time in 0..10_000_u64 {
            watch.record(Duration::from_millis(time));
        }
        let times = watch.times();
        assert_eq!((watch.frames(), watch.last.len()), (10_000, KEPT_TIMES));
        assert_eq!((times.min, times.max), (0.0, 9.999));
        assert!((times.mean - 4.9995).abs() < 1e-9);
        assert!(times.median > 7.9 && times.p95 > times.median);
    }
}
