//! Packets and columns that a thread uses again: to clear a wide one takes longer than to shade the few rays of a run.

use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::ops::{Deref, DerefMut};

thread_local! {
    static KEPT: RefCell<Vec<(TypeId, Box<dyn Any>)>> = const { RefCell::new(Vec::new()) };
}

/// A value on loan; it is kept for the next when it is dropped.
#[derive(Debug)]
pub(crate) struct Lent<T: 'static>(Option<Box<T>>);

/// Lends a value that holds what whoever had it last left in it; the first of its kind at a time is a default. Who borrows
/// writes the rows that they read.
pub(crate) fn lend<T: Default + 'static>() -> Lent<T> {
    let kept = KEPT.with_borrow_mut(|kept| {
        let at = kept.iter().rposition(|(kind, _)| *kind == TypeId::of::<T>())?;
        Some(kept.swap_remove(at).1)
    });
    Lent(Some(kept.and_then(|value| value.downcast().ok()).unwrap_or_default()))
}

impl<T> Deref for Lent<T> {
    type Target = T;
    #[inline(always)]
    fn deref(&self) -> &T {
        self.0.as_ref().expect("it is there until it is dropped")
    }
}

impl<T> DerefMut for Lent<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut T {
        self.0.as_mut().expect("it is there until it is dropped")
    }
}

impl<T> Drop for Lent<T> {
    fn drop(&mut self) {
        if let Some(value) = self.0.take() {
            // At a thread's end there may be nowhere left to keep it.
            let _ = KEPT.try_with(|kept| kept.borrow_mut().push((TypeId::of::<T>(), value)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_given_back_is_lent_again_and_what_is_out_is_not() {
        let mut first = lend::<[u32; 3]>();
        first[0] = 7;
        assert_eq!(*lend::<[u32; 3]>(), [0; 3]);
        drop(first);
        assert_eq!(*lend::<[u32; 3]>(), [7, 0, 0]);
        assert_eq!(*lend::<[i32; 3]>(), [0; 3]);
        std::thread::spawn(|| assert_eq!(*lend::<[u32; 3]>(), [0; 3])).join().expect("another thread has its own");
    }
}
