//! How builders use threads that somebody else has: halves of the work, always cut at the same places.

/// How two halves of the work are done: one after the other, or by threads that somebody else has.
pub trait Join: Sync {
    /// Does both and returns both results.
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B);

    /// Hears of how many more primitives a build is done with. It goes over all of them twice, a refit once; of what is done in
    /// no time nothing is heard. Called by the threads that build.
    fn done_with(&self, primitives: usize) {
        let _ = primitives;
    }
}

/// One after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial;

impl Join for Serial {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        (a(), b())
    }
}

/// Runs of this many items are done without asking [`Join`].
pub(super) const RUN: usize = 1 << 15;

/// Does `run` for runs of items, given where each starts, and merges the results of neighbours: `merge` gets the items of
/// both and where the second begins. Where the runs are cut depends on the number of items only.
pub(super) fn reduce<T: Send, R: Send>(
    join: &impl Join,
    items: &mut [T],
    start: usize,
    run: &(impl Fn(&mut [T], usize) -> R + Sync),
    merge: &(impl Fn(&mut [T], usize, R, R) -> R + Sync),
) -> R {
    if items.len() <= RUN {
        return run(items, start);
    }
    let middle = items.len() / 2;
    let (left, right) = items.split_at_mut(middle);
    let (left, right) =
        join.join(|| reduce(join, left, start, run, merge), || reduce(join, right, start + middle, run, merge));
    merge(items, middle, left, right)
}

/// Does something with each, in parallel; gives the results in order.
pub(super) fn each<T: Send, R: Send>(
    join: &impl Join,
    items: &mut [T],
    work: &(impl Fn(&mut T) -> R + Sync),
) -> alloc::vec::Vec<R> {
    match items {
        [] => alloc::vec::Vec::new(),
        [item] => alloc::vec![work(item)],
        _ => {
            let (left, right) = items.split_at_mut(items.len() / 2);
            let (mut left, right) = join.join(|| each(join, left, work), || each(join, right, work));
            left.extend(right);
            left
        }
    }
}
