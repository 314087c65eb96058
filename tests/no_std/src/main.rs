//! `mobula-core` without the standard library: builds a tree, traces a packet, exits with 0 if it hit what it should.
//!
//!     cargo run --release --manifest-path tests/no_std/Cargo.toml
//!
//! If anything pulled std in, this would not compile: std has a panic handler too, and there can be only one.
#![no_std]
#![no_main]

use core::alloc::{GlobalAlloc, Layout};
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicUsize, Ordering};

use mobula_core::bvh::Serial;
use mobula_core::leaf::TriangleBlock;
use mobula_core::glam::Vec3;
use mobula_core::simd::AnyToken;
use mobula_core::{Bvh, RayPacket};

// The C library, for the start of the process and for memcpy; nothing else is linked.
#[link(name = "c")]
unsafe extern "C" {}

/// Bytes that can be allocated before memory is exhausted.
const ARENA: usize = 1 << 20;

/// Hands out memory from the front of an arena and takes none back.
struct Bump {
    arena: UnsafeCell<[u8; ARENA]>,
    next: AtomicUsize,
}

// SAFETY: the arena is only ever reached through `alloc`, which gives each byte to one caller.
unsafe impl Sync for Bump {}

// SAFETY: `fetch_update` reserves disjoint, aligned ranges within the arena; null where none is left.
unsafe impl GlobalAlloc for Bump {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let base = self.arena.get() as usize;
        let place = |next: usize| (base + next).next_multiple_of(layout.align()) - base;
        // Pairs with itself: only the number matters.
        let claimed = self.next.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |next| {
            place(next).checked_add(layout.size()).filter(|&end| end <= ARENA)
        });
        match claimed {
            // SAFETY: `place(next) + size <= ARENA`, as was checked.
            Ok(next) => unsafe { self.arena.get().cast::<u8>().add(place(next)) },
            Err(_) => core::ptr::null_mut(),
        }
    }

    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[global_allocator]
static MEMORY: Bump = Bump { arena: UnsafeCell::new([0; ARENA]), next: AtomicUsize::new(0) };

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

/// Named by the unwind tables of the prebuilt `alloc`; never called, because a panic stops here.
// SAFETY: std, which has the real one, is not linked.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

/// A wall of 20 x 20 squares before an eye: which rays of an 8 x 8 packet hit it, at every level?
fn trace() -> Result<(), i32> {
    let wall = |i: usize| {
        let (x, y) = ((i / 2 % 20) as f32 - 10.0, (i / 40) as f32 - 10.0);
        let corner = if i % 2 == 0 { [x + 1.0, y, 5.0] } else { [x, y + 1.0, 5.0] };
        [[x, y, 5.0], [x + 1.0, y + 1.0, 5.0], corner]
    };
    let bvh = Bvh::<TriangleBlock>::triangles(800, 0, &Serial, wall);
    for (code, token) in (1..).zip(AnyToken::available()) {
        let mut packet = RayPacket::<64>::default();
        packet.reset(0..64);
        for i in 0..64 {
            let aim = Vec3::new((i % 8) as f32 * 4.0 - 13.8, (i / 8) as f32 * 4.0 - 13.9, 5.0);
            packet.set_ray(i, Vec3::ZERO, aim);
        }
        packet.set_common_origin(Vec3::ZERO);
        bvh.intersect(token, &mut packet);
        for i in 0..64 {
            let aim = packet.ray(i).1;
            let on_wall = aim.x.abs() < 10.0 && aim.y.abs() < 10.0;
            let distance = if on_wall { (packet.t_max[i] - 1.0).abs() } else { 0.0 };
            if packet.was_hit(i) != on_wall || distance > 1e-6 {
                return Err(code);
            }
        }
    }
    Ok(())
}

/// Where the C library starts us.
// SAFETY: no other `main` is linked.
#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    match trace() {
        Ok(()) => 0,
        Err(code) => code,
    }
}
