//! Numbers as nearly all files write them, read as fast as may be: few digits, a point, blanks between. Whatever else there is in a
//! text is for others to read.

/// Powers of ten that are exact.
const TENS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];
/// More digits may not fit.
const MOST_DIGITS: usize = 18;

/// A text that is taken from the front.
pub(super) struct Plain<'a>(pub(super) &'a [u8]);

impl Plain<'_> {
    /// Skips blanks; is anything behind them?
    #[inline(always)]
    pub(super) fn more(&mut self) -> bool {
        while let [b' ' | b'\t', rest @ ..] = self.0 {
            self.0 = rest;
        }
        !self.0.is_empty()
    }

    /// Takes a byte if it is next.
    #[inline(always)]
    pub(super) fn take(&mut self, byte: u8) -> bool {
        let rest = self.0.strip_prefix(&[byte]);
        self.0 = rest.unwrap_or(self.0);
        rest.is_some()
    }

    /// Does a word end here?
    #[inline(always)]
    pub(super) fn ends(&self) -> bool {
        matches!(self.0, [] | [b' ' | b'\t', ..])
    }

    /// Takes digits; how many, and `number` with them behind it. Of more than [`MOST_DIGITS`] the number means nothing.
    #[inline(always)]
    fn digits(&mut self, mut number: u64) -> (usize, u64) {
        let mut count = 0;
        while let [digit @ b'0'..=b'9', rest @ ..] = self.0 {
            number = number.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
            count += 1;
            self.0 = rest;
        }
        (count, number)
    }

    /// Takes a whole number.
    #[inline(always)]
    pub(super) fn whole(&mut self) -> Option<u64> {
        let (count, number) = self.digits(0);
        (1..=MOST_DIGITS).contains(&count).then_some(number)
    }

    /// Takes a word that is a number with a point or without. Digits and power of ten are both exact, so the quotient is the nearest
    /// number to what is written: the one that `str::parse` gives (Clinger, PLDI 1990).
    #[inline(always)]
    fn decimal(&mut self) -> Option<f64> {
        let negative = self.take(b'-');
        let (before, number) = self.digits(0);
        let (behind, number) = if self.take(b'.') { self.digits(number) } else { (0, number) };
        let plain = (1..=MOST_DIGITS).contains(&(before + behind)) && number < 1 << 53 && self.ends();
        let size = plain.then(|| number as f64 / TENS[behind])?;
        Some(if negative { -size } else { size })
    }

    /// The numbers of a text that has so many and nothing else.
    #[inline(always)]
    pub(super) fn decimals<const N: usize>(mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = if self.more() { self.decimal()? } else { return None };
        }
        (!self.more()).then_some(numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_is_not_plain_is_left_to_others() {
        for text in
            ["", "1", "1 2 3", "1 2x", "1 e5", "1 1e5", "1 .", "1 -", "1 +2", "1 1.2.3", "1 2\r", "1 9007199254740993"]
        {
            assert_eq!(Plain(text.as_bytes()).decimals::<2>(), None, "{text:?}");
        }
        assert_eq!(Plain(b" 5.\t-.25 ").decimals(), Some([5.0, -0.25]));
    }

    proptest! {
        #[test]
        fn numbers_are_those_that_the_standard_library_reads(word in "-?[0-9]{0,12}(\\.[0-9]{0,12})?") {
            if let Some([number]) = Plain(word.as_bytes()).decimals::<1>() {
                prop_assert_eq!(Some(number.to_bits()), word.parse().ok().map(f64::to_bits));
            }
        }
    }
}
