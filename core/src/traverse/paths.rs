//! Which paths rays took.

/// How many rays took which path: what `--stats` prints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Paths {
    /// Rays that travelled in packets with a common origin.
    pub common_origin: u64,
    /// Rays that travelled in packets without one.
    pub general: u64,
    /// Rays that had nothing in common with their neighbours, or hardly any.
    pub single: u64,
}

impl core::ops::AddAssign for Paths {
    fn add_assign(&mut self, other: Self) {
        self.common_origin += other.common_origin;
        self.general += other.general;
        self.single += other.single;
    }
}
