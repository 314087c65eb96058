//! Numbers that look random.

/// A number in `[0, 1)` that looks random.
pub(super) fn mixed(mut h: u32) -> f32 {
    h ^= h >> 13;
    h = h.wrapping_mul(0x9e37_79b1);
    h ^= h >> 15;
    h = h.wrapping_mul(0x85eb_ca77);
    h ^= h >> 13;
    (h >> 8) as f32 * (1.0 / 16_777_216.0)
}
