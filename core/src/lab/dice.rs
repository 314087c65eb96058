//! Where inputs come from: a seed, or the bytes of a fuzzer or of proptest, which shrink.

/// What kind of numbers a case is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Between -1 and 1.
    Ordinary,
    /// Multiples of 1/4: edges and corners meet, products are exact, ties are common.
    Grid,
    /// Mostly zero, of either sign.
    Zero,
    /// Below the least normal number.
    Denormal,
    /// Up to the greatest number.
    Huge,
    /// Ordinary ones among infinities, NaN, and the ends of the range.
    Special,
    /// Any bits.
    Bits,
}

const STYLES: [Style; 10] = [
    Style::Ordinary,
    Style::Grid,
    Style::Special,
    Style::Zero,
    Style::Denormal,
    Style::Huge,
    Style::Bits,
    Style::Grid,
    Style::Ordinary,
    Style::Ordinary,
];

const SPECIAL: [f32; 12] = [
    0.0,
    -0.0,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    -1e-45,
    1e18,
    1.0,
    f32::EPSILON,
];

/// Draws numbers. The same source gives the same numbers everywhere.
#[derive(Clone, Debug)]
pub struct Dice<'a> {
    bytes: Option<&'a [u8]>,
    at: usize,
    state: u64,
    style: Style,
}

impl Dice<'static> {
    /// An endless source.
    pub fn from_seed(seed: u64) -> Self {
        Self { bytes: None, at: 0, state: seed ^ 0x9e37_79b9_7f4a_7c15, style: Style::Ordinary }
    }
}

impl<'a> Dice<'a> {
    /// The numbers that the bytes spell. When they are used up they are read again, so a few bytes make a regular case,
    /// and none makes all zeros: what a failing case shrinks to is easy to read.
    pub fn from_bytes(bytes: &'a [u8]) -> Self {
        Self { bytes: Some(bytes), at: 0, state: 0, style: Style::Ordinary }
    }

    /// The next 8 bits.
    pub fn byte(&mut self) -> u8 {
        match self.bytes {
            Some([]) => 0,
            Some(bytes) => {
                self.at += 1;
                bytes[(self.at - 1) % bytes.len()]
            }
            None => {
                // A step of PCG's generator; the high bits are the good ones.
                self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let x = self.state ^ (self.state >> 22);
                (x.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 56) as u8
            }
        }
    }

    /// One of `0..n`; 0 when `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        let x = usize::from(self.byte()) << 8 | usize::from(self.byte());
        x % n.max(1)
    }

    /// True once in `n` times; false when the bytes are zero.
    pub fn one_in(&mut self, n: usize) -> bool {
        usize::from(self.byte()) % n == n - 1
    }

    /// In `0..1`, whatever the style.
    pub fn unit(&mut self) -> f32 {
        (u32::from(self.byte()) << 16 | u32::from(self.byte()) << 8 | u32::from(self.byte())) as f32 / 16_777_216.0
    }

    /// In `-1..=1`, whatever the style; 0 when the bytes are zero.
    pub fn signed(&mut self) -> f32 {
        let negative = self.byte() & 1 == 1;
        let x = self.unit();
        if negative { -x } else { x }
    }

    /// The style of what [`value`](Self::value) gives.
    pub fn style(&self) -> Style {
        self.style
    }

    /// Sets the style.
    pub fn set_style(&mut self, style: Style) {
        self.style = style;
    }

    /// Draws a style.
    pub fn draw_style(&mut self) -> Style {
        self.style = STYLES[self.below(STYLES.len())];
        self.style
    }

    /// A number of the present style.
    pub fn value(&mut self) -> f32 {
        let ordinary = self.signed();
        match self.style {
            Style::Ordinary => ordinary,
            Style::Grid => (ordinary * 8.0) as i32 as f32 * 0.25,
            Style::Zero => [0.0, -0.0, 0.0, 0.0, 1.0, -0.0, 0.0, -1.0][self.below(8)],
            Style::Denormal => ordinary * 1e-38,
            Style::Huge => ordinary * [1e10, 1e17, 1e19, 1e25, 3e38][self.below(5)],
            Style::Special => match self.below(48) {
                at @ 1..=12 => SPECIAL[at - 1],
                _ => ordinary,
            },
            Style::Bits => f32::from_bits(u32::from_le_bytes([self.byte(), self.byte(), self.byte(), self.byte()])),
        }
    }

    /// Three of them.
    pub fn point(&mut self) -> [f32; 3] {
        [self.value(), self.value(), self.value()]
    }
}
