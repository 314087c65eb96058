//! Memory in large pages, where the system gives them on request.

/// Bytes of a large page.
const LARGE: usize = 1 << 21;
/// Fewer large pages are not worth asking for: to clear one that is not needed whole costs as much as its faults.
const LEAST: usize = 4;

/// Asks the system to back this memory with large pages when it is first written: 512 times fewer faults then, and fewer
/// misses when addresses are translated ever after. Only whole large pages inside it are asked for, so no more memory is
/// used, and none where there are few. A wish: contents stay, and nothing tells whether it was granted.
pub fn prefer_large<T>(memory: &mut [T]) {
    let memory = memory.as_mut_ptr_range();
    let start = (memory.start as usize).next_multiple_of(LARGE);
    let end = (memory.end as usize) / LARGE * LARGE;
    if start + LEAST * LARGE <= end {
        advise(memory.start.with_addr(start).cast(), end - start);
    }
}

#[cfg(all(target_os = "linux", not(miri)))]
fn advise(start: *mut core::ffi::c_void, bytes: usize) {
    // SAFETY: the advice changes how memory is backed, never what is in it; all of it is borrowed by the caller.
    let granted = unsafe { rustix::mm::madvise(start, bytes, rustix::mm::Advice::LinuxHugepage) };
    // A system without large pages refuses, and nothing is lost.
    let _ = granted;
}

#[cfg(not(all(target_os = "linux", not(miri))))]
fn advise(_start: *mut core::ffi::c_void, _bytes: usize) {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    #[test]
    fn contents_stay() {
        for bytes in [0, 1, LARGE, 6 * LARGE + 5] {
            let mut memory = vec![7u8; bytes];
            prefer_large(&mut memory);
            assert!(memory.iter().all(|&x| x == 7));
        }
    }
}
