//! Packets and columns that a thread uses again: to make a wide one takes longer than to shade the few rays of a run.

use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::ops::{Deref, DerefMut};

use bytemuck::Pod;

use crate::packet::{AnyHitPacket, Column, Columns3, Packet, columns3};

thread_local! {
    static KEPT: RefCell<Vec<Kept>> = const { RefCell::new(Vec::new()) };
}

/// A value that waits to be lent: of which type, for packets of which width.
struct Kept {
    kind: TypeId,
    width: usize,
    value: Box<dyn Any>,
}

/// What is made for packets of a width.
pub(crate) trait ForWidth: 'static {
    /// Makes one.
    fn for_width(width: usize) -> Self;
}

impl<T: Pod> ForWidth for Column<T> {
    fn for_width(width: usize) -> Self {
        Self::new(width)
    }
}

impl ForWidth for Columns3 {
    fn for_width(width: usize) -> Self {
        columns3(width)
    }
}

impl ForWidth for Packet {
    fn for_width(width: usize) -> Self {
        Self::new(width)
    }
}

impl ForWidth for AnyHitPacket {
    fn for_width(width: usize) -> Self {
        Self::new(width)
    }
}

/// A value on loan; it is kept for the next when it is dropped.
#[derive(Debug)]
pub(crate) struct Lent<T: 'static> {
    value: Option<Box<T>>,
    width: usize,
}

/// Lends a value for packets of a width. It holds what whoever had it last left in it; the first of its kind at a time is new. Who
/// borrows writes the rows that they read.
pub(crate) fn lend<T: ForWidth>(width: usize) -> Lent<T> {
    let kept = KEPT.with_borrow_mut(|kept| {
        let at = kept.iter().rposition(|kept| kept.kind == TypeId::of::<T>() && kept.width == width)?;
        Some(kept.swap_remove(at).value)
    });
    let value = kept.and_then(|value| value.downcast().ok()).unwrap_or_else(|| Box::new(T::for_width(width)));
    Lent { value: Some(value), width }
}

impl<T> Deref for Lent<T> {
    type Target = T;
    #[inline(always)]
    fn deref(&self) -> &T {
        self.value.as_ref().expect("it is there until it is dropped")
    }
}

impl<T> DerefMut for Lent<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut T {
        self.value.as_mut().expect("it is there until it is dropped")
    }
}

impl<T> Drop for Lent<T> {
    fn drop(&mut self) {
        if let Some(value) = self.value.take() {
            let kept = Kept { kind: TypeId::of::<T>(), width: self.width, value };
            // At a thread's end there may be nowhere left to keep it.
            let _ = KEPT.try_with(|all| all.borrow_mut().push(kept));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_given_back_is_lent_again_and_what_is_out_is_not() {
        let mut first = lend::<Column<u32>>(8);
        first[0] = 7;
        assert_eq!(lend::<Column<u32>>(8)[0], 0);
        drop(first);
        assert_eq!(lend::<Column<u32>>(8)[0], 7);
        assert_eq!(lend::<Column<u32>>(16)[0], 0, "another width");
        assert_eq!(lend::<Column<f32>>(8)[0], 0.0, "another type");
        std::thread::spawn(|| assert_eq!(lend::<Column<u32>>(8)[0], 0)).join().expect("another thread has its own");
    }
}
