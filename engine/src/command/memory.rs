//! How much memory steps of time may take.

use std::fs;

use mobula::load::Memory;

/// A size in bytes: `500M`, `4G`, `1.5 GiB`; K, M, G, T are powers of 1024.
pub(super) fn limit(text: &str) -> Result<u64, String> {
    let wrong = || "this is no size: write a number with K, M, G or T behind it, such as 500M or 4G".to_owned();
    let end = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let shift = match unit.trim().to_ascii_lowercase().as_str() {
        "" | "b" => 0,
        "k" | "kb" | "kib" => 10,
        "m" | "mb" | "mib" => 20,
        "g" | "gb" | "gib" => 30,
        "t" | "tb" | "tib" => 40,
        _ => return Err(wrong()),
    };
    let number: f64 = number.parse().map_err(|_| wrong())?;
    // What is too large is as good as no limit.
    Ok((number * f64::from(1_u32 << (shift / 2)) * f64::from(1_u32 << (shift - shift / 2))) as u64)
}

/// As much as was asked for, or else three quarters of what is free.
pub(super) fn memory(limit: Option<u64>) -> Memory {
    Memory::new(limit.unwrap_or_else(default_limit))
}

/// Three quarters of the memory that is free; no limit where the system does not say.
fn default_limit() -> u64 {
    let text = fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
    let kib = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kib.map_or(u64::MAX, |kib| kib.saturating_mul(1024) / 4 * 3)
}

/// A size as people read it.
pub(super) fn shown(bytes: u64) -> String {
    let units = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let unit = (bytes.max(1).ilog2() / 10).min(4);
    let number = bytes as f64 / f64::from(1_u32 << (10 * unit / 2)) / f64::from(1_u32 << (10 * unit - 10 * unit / 2));
    if unit == 0 || number >= 100.0 {
        format!("{number:.0} {}", units[unit as usize])
    } else {
        format!("{number:.1} {}", units[unit as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_and_shown() {
        for (text, bytes, text_again) in [
            ("100", 100, "100 bytes"),
            ("2k", 2048, "2.0 KiB"),
            ("500M", 500 << 20, "500 MiB"),
            ("1.5 GiB", 3 << 29, "1.5 GiB"),
            ("3TB", 3 << 40, "3.0 TiB"),
        ] {
            assert_eq!(limit(text), Ok(bytes));
            assert_eq!(shown(bytes), text_again);
        }
        for text in ["", "G", "-1G", "1..5", "4 sheep", "1e3", "nan"] {
            assert!(limit(text).is_err(), "{text}");
        }
        assert!(default_limit() > 0);
    }
}
