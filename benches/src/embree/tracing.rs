//! Embree's interfaces, each a timed loop over rays: load them from the arrays, query, store.

use std::fmt::{self, Display};

use super::bindings::{Context, Device, FlushToZero, NONE, Property, Query, Ray, RayHit, Scene, Stream, Valid};
use crate::rays::{Found, RaySet};

/// What of Embree is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// One ray.
    One,
    /// Packets of 4.
    Four,
    /// Packets of 8.
    Eight,
    /// Packets of 16.
    Sixteen,
    /// Streams of 256 single rays (`rtc*1M`).
    Stream,
    /// Streams of 256 rays as one structure of arrays (`rtc*NM`).
    Block,
}

/// What of Embree is called, and what it is told about the rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interface {
    /// The function.
    pub entry: Entry,
    /// The coherent flag.
    pub coherent: bool,
}

impl Interface {
    /// Every one.
    pub fn all() -> impl Iterator<Item = Self> {
        use Entry::{Block, Eight, Four, One, Sixteen, Stream};
        [One, Four, Eight, Sixteen, Stream, Block]
            .into_iter()
            .flat_map(|entry| [false, true].map(|coherent| Self { entry, coherent }))
    }
}

impl Display for Interface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self.entry {
            Entry::One => "1",
            Entry::Four => "4",
            Entry::Eight => "8",
            Entry::Sixteen => "16",
            Entry::Stream => "1M",
            Entry::Block => "NM",
        };
        write!(f, "rtc{name}{}", if self.coherent { "c" } else { "" })
    }
}

impl Device {
    /// Has it instructions for this interface? Others are emulated by narrower ones, to no profit.
    pub fn is_native(&self, interface: Interface) -> bool {
        match interface.entry {
            Entry::One => true,
            Entry::Four => self.has(Property::Packets4),
            Entry::Eight => self.has(Property::Packets8),
            Entry::Sixteen => self.has(Property::Packets16),
            Entry::Stream | Entry::Block => self.has(Property::Streams),
        }
    }
}

impl Scene<'_> {
    /// Closest hits. Flush-to-zero is on, as Embree asks.
    pub fn intersect(&self, interface: Interface, rays: &RaySet, found: &mut Found) {
        let _flushing = FlushToZero::new();
        match interface.entry {
            Entry::One => self.packets::<RayHit<1>>(interface, rays, found),
            Entry::Four => self.packets::<RayHit<4>>(interface, rays, found),
            Entry::Eight => self.packets::<RayHit<8>>(interface, rays, found),
            Entry::Sixteen => self.packets::<RayHit<16>>(interface, rays, found),
            Entry::Stream => self.streams::<RayHit<1>>(interface, rays, found),
            Entry::Block => self.packets::<RayHit<256>>(interface, rays, found),
        }
    }

    /// Any hits: as [`intersect`](Self::intersect), without primitives.
    pub fn occluded(&self, interface: Interface, rays: &RaySet, found: &mut Found) {
        let _flushing = FlushToZero::new();
        match interface.entry {
            Entry::One => self.packets::<Ray<1>>(interface, rays, found),
            Entry::Four => self.packets::<Ray<4>>(interface, rays, found),
            Entry::Eight => self.packets::<Ray<8>>(interface, rays, found),
            Entry::Sixteen => self.packets::<Ray<16>>(interface, rays, found),
            Entry::Stream => self.streams::<Ray<1>>(interface, rays, found),
            Entry::Block => self.packets::<Ray<256>>(interface, rays, found),
        }
    }

    #[inline(always)]
    fn packets<R: Packet>(&self, interface: Interface, rays: &RaySet, found: &mut Found) {
        let mut context = Context::new(interface.coherent);
        let (mut packet, mut valid) = (R::new(), Valid::ALL);
        for at in (0..rays.len()).step_by(R::WIDTH) {
            let count = R::WIDTH.min(rays.len() - at);
            valid.only(count, R::WIDTH);
            packet.load(rays, at, count);
            packet.find(self, &mut context, &valid);
            packet.store(found, at, count);
        }
    }

    fn streams<R: Packet + Stream>(&self, interface: Interface, rays: &RaySet, found: &mut Found) {
        const MANY: usize = 256;
        let mut context = Context::new(interface.coherent);
        let mut stream: Vec<R> = (0..MANY).map(|_| R::new()).collect();
        for first in (0..rays.len()).step_by(MANY) {
            let count = MANY.min(rays.len() - first);
            for (i, ray) in stream[..count].iter_mut().enumerate() {
                ray.load(rays, first + i, 1);
            }
            R::find_all(&mut stream[..count], self, &mut context);
            for (i, ray) in stream[..count].iter().enumerate() {
                ray.store(found, first + i, 1);
            }
        }
    }
}

/// Rays in Embree's layout.
trait Packet: Query {
    const WIDTH: usize;
    fn new() -> Self;
    fn load(&mut self, rays: &RaySet, at: usize, count: usize);
    fn store(&self, found: &mut Found, at: usize, count: usize);
}

/// `to[..count] = from[at..at + count]`, as vectors where the packet is full.
#[inline(always)]
fn copy<T: Copy, const W: usize>(from: &[T], at: usize, to: &mut [T; W], count: usize) {
    if let (true, Some(from)) = (count == W, from.get(at..at + W)) {
        to.copy_from_slice(from);
    } else {
        to[..count].copy_from_slice(&from[at..at + count]);
    }
}

#[inline(always)]
fn put<T: Copy, const W: usize>(from: &[T; W], to: &mut [T], at: usize, count: usize) {
    if let (true, Some(to)) = (count == W, to.get_mut(at..at + W)) {
        to.copy_from_slice(from);
    } else {
        to[at..at + count].copy_from_slice(&from[..count]);
    }
}

impl<const W: usize> Packet for RayHit<W>
where
    Self: Query,
{
    const WIDTH: usize = W;

    fn new() -> Self {
        Self {
            origin: [[0.0; W]; 3],
            near: [0.0; W],
            direction: [[0.0; W]; 3],
            time: [0.0; W],
            far: [0.0; W],
            mask: [NONE; W],
            id: [0; W],
            flags: [0; W],
            normal: [[0.0; W]; 3],
            uv: [[0.0; W]; 2],
            primitive: [NONE; W],
            geometry: [NONE; W],
            instance: [NONE; W],
        }
    }

    #[inline(always)]
    fn load(&mut self, rays: &RaySet, at: usize, count: usize) {
        for axis in 0..3 {
            copy(&rays.origin[axis], at, &mut self.origin[axis], count);
            copy(&rays.direction[axis], at, &mut self.direction[axis], count);
        }
        copy(&rays.t_max, at, &mut self.far, count);
        self.far[count..].fill(f32::NEG_INFINITY);
        // A miss leaves the primitive alone, so it serves as the mark of a hit; the geometry must be reset as well.
        self.primitive = [NONE; W];
        self.geometry = [NONE; W];
    }

    #[inline(always)]
    fn store(&self, found: &mut Found, at: usize, count: usize) {
        put(&self.far, &mut found.t, at, count);
        put(&self.primitive, &mut found.primitive, at, count);
        for (from, to) in self.uv.iter().zip(found.uv.iter_mut().flatten()) {
            put(from, to, at, count);
        }
    }
}

impl<const W: usize> Packet for Ray<W>
where
    Self: Query,
{
    const WIDTH: usize = W;

    fn new() -> Self {
        Self {
            origin: [[0.0; W]; 3],
            near: [0.0; W],
            direction: [[0.0; W]; 3],
            time: [0.0; W],
            far: [0.0; W],
            mask: [NONE; W],
            id: [0; W],
            flags: [0; W],
        }
    }

    #[inline(always)]
    fn load(&mut self, rays: &RaySet, at: usize, count: usize) {
        for axis in 0..3 {
            copy(&rays.origin[axis], at, &mut self.origin[axis], count);
            copy(&rays.direction[axis], at, &mut self.direction[axis], count);
        }
        copy(&rays.t_max, at, &mut self.far, count);
        self.far[count..].fill(f32::NEG_INFINITY);
    }

    #[inline(always)]
    fn store(&self, found: &mut Found, at: usize, count: usize) {
        put(&self.far, &mut found.t, at, count);
    }
}
