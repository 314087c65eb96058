//! Memory in large pages, where the system gives them on request.

/// Bytes of a large page.
const LARGE: usize = 1 << 21;
/// Fewer large pages are not worth asking for: to clear one that is not needed whole costs as much as its faults.
const LEAST: usize = 4;

/// Asks the system to back this memory with large pages when it is first written: 512 times fewer faults then, and fewer
/// misses when addresses are translated ever after. Only whole large pages inside it are asked for, so no more memory is
/// used, and none where there are few. A wish: contents stay, and nothing tells whether it was granted.
pub fn prefer_large<T>(memory: &mut [T]) {
    let start = (memory.as_mut_ptr() as usize).next_multiple_of(LARGE);
    let end = (memory.as_mut_ptr_range().end as usize) / LARGE * LARGE;
    if start + LEAST * LARGE <= end {
        advise(start, end - start);
    }
}

#[cfg(all(target_os = "linux", target_arch = "x86_64", target_pointer_width = "64", not(miri)))]
fn advise(start: usize, bytes: usize) {
    const MADVISE: usize = 28;
    const HUGE_PAGE: usize = 14;
    // SAFETY: the call changes how the memory is backed, never what is in it, and reads and writes nothing of this program.
    // The kernel leaves its result in rax and changes rcx and r11.
    unsafe {
        core::arch::asm!(
            "syscall",
            inout("rax") MADVISE => _,
            in("rdi") start,
            in("rsi") bytes,
            in("rdx") HUGE_PAGE,
            out("rcx") _,
            out("r11") _,
            options(nostack),
        );
    }
}

#[cfg(not(all(target_os = "linux", target_arch = "x86_64", target_pointer_width = "64", not(miri))))]
fn advise(_start: usize, _bytes: usize) {}

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
