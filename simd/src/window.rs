//! The part of a slice that a vector covers.

/// `src[at..at + W]`, where all of it exists. With lengths known at compile time the branch on it disappears.
#[inline(always)]
pub(crate) fn window<X, const W: usize>(src: &[X], at: usize) -> Option<&[X; W]> {
    match src.get(at..) {
        Some(rest) => rest.first_chunk(),
        None => None,
    }
}

/// As [`window`], to write.
#[inline(always)]
pub(crate) fn window_mut<X, const W: usize>(dst: &mut [X], at: usize) -> Option<&mut [X; W]> {
    match dst.get_mut(at..) {
        Some(rest) => rest.first_chunk_mut(),
        None => None,
    }
}
