//! Packet widths that can be chosen at run time: the one table of those that intersection is compiled for.

use std::fmt;
use std::str::FromStr;

use mobula_core::simd::Level;

/// Calls a macro with all packet widths: a name, the number of rays, and what a packet of pixels looks like. By rising width. This
/// is the one table.
macro_rules! packet_widths {
    ($macro:ident) => {
        $macro! {
            W1 1 "Single rays.",
            W16 16 "4 x 4 pixels.",
            W64 64 "8 x 8 pixels.",
            W256 256 "16 x 16 pixels.",
        }
    };
}
pub(super) use packet_widths;

macro_rules! widths {
    ($($name:ident $rays:literal $shape:literal,)+) => {
        /// How many rays a packet holds.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum PacketWidth {
            $(#[doc = $shape] $name,)+
        }

        impl PacketWidth {
            /// All of them, by rising width.
            pub const ALL: &[Self] = &[$(Self::$name,)+];

            /// The number of rays.
            pub const fn rays(self) -> usize {
                match self {
                    $(Self::$name => $rays,)+
                }
            }
        }
    };
}
packet_widths!(widths);

impl PacketWidth {
    /// The number of rays of the widest packets.
    pub const WIDEST: usize = Self::ALL[Self::ALL.len() - 1].rays();

    /// The fastest for whole frames at a level, as measured (`benches/record`).
    pub const fn best(level: Level) -> Self {
        match level {
            Level::Scalar => Self::W64,
            Level::Sse2 | Level::Avx2 | Level::Avx512 => Self::W256,
        }
    }

    /// The widths as people read them: "1, 16, 64 or 256".
    pub fn list() -> String {
        let numbers: Vec<String> = Self::ALL.iter().map(Self::to_string).collect();
        let (last, others) = numbers.split_last().expect("there are several");
        format!("{} or {last}", others.join(", "))
    }
}

/// A packet width that the engine was not built for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("packets hold {} rays, not {name}", PacketWidth::list())]
pub struct UnknownWidth {
    /// What was asked for.
    pub name: String,
}

impl FromStr for PacketWidth {
    type Err = UnknownWidth;

    fn from_str(text: &str) -> Result<Self, UnknownWidth> {
        let found = Self::ALL.iter().copied().find(|width| text.parse() == Ok(width.rays()));
        found.ok_or_else(|| UnknownWidth { name: text.to_owned() })
    }
}

impl fmt::Display for PacketWidth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.rays())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers_agree() {
        for &width in PacketWidth::ALL {
            assert_eq!(width.to_string().parse(), Ok(width));
        }
        assert!(PacketWidth::ALL.is_sorted_by_key(|width| width.rays()));
        for bad in ["", "0", "2", "64 ", "-1", "99999999999999999999"] {
            let message = bad.parse::<PacketWidth>().unwrap_err().to_string();
            assert!(message.contains("1, 16, 64 or 256"), "{message}");
        }
    }
}
