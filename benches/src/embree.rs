//! Embree 3, as little of it as the peer bench needs, bound by hand from its headers (`rtcore_*.h` of 3.13.5).
//!
//! The one file of this package that calls foreign code. Handles are owned here and never leave; the structures below
//! have the layout of Embree's `RTCRay*` and `RTCRayHit*`, which are arrays of 4-byte fields for every width.

#![allow(unsafe_code, reason = "foreign functions")]

use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::fmt::{self, Display};
use std::marker::PhantomData;
use std::ptr::null;
use std::sync::atomic::{AtomicIsize, Ordering::Relaxed};

use crate::rays::{Found, RaySet};
use crate::scenes::Triangles;

type Handle = *mut c_void;

/// `RTCIntersectContext`.
#[repr(C)]
struct Context {
    flags: c_int,
    filter: *const c_void,
    instance: [c_uint; 1],
}

/// `RTCRay` (`W` = 1), `RTCRay4`, `RTCRay8`, `RTCRay16`, or `W` rays of a stream; aligned for all of them.
#[repr(C, align(64))]
struct Ray<const W: usize> {
    origin: [[f32; W]; 3],
    near: [f32; W],
    direction: [[f32; W]; 3],
    time: [f32; W],
    far: [f32; W],
    mask: [c_uint; W],
    id: [c_uint; W],
    flags: [c_uint; W],
}

/// `RTCRayHit` and its wider forms. The hit follows the ray without padding, as 12 rows of 4 bytes times 1, 4, 8 or 16
/// keep the alignment that it has there; so it is part of one structure here.
#[repr(C, align(64))]
struct RayHit<const W: usize> {
    origin: [[f32; W]; 3],
    near: [f32; W],
    direction: [[f32; W]; 3],
    time: [f32; W],
    far: [f32; W],
    mask: [c_uint; W],
    id: [c_uint; W],
    flags: [c_uint; W],
    normal: [[f32; W]; 3],
    uv: [[f32; W]; 2],
    primitive: [c_uint; W],
    geometry: [c_uint; W],
    instance: [c_uint; W],
}

type MemoryMonitor = extern "C" fn(*mut c_void, isize, bool) -> bool;
type Query<R> = unsafe extern "C" fn(*const c_int, Handle, *mut Context, *mut R);
type QueryOne<R> = unsafe extern "C" fn(Handle, *mut Context, *mut R);
type QueryMany = unsafe extern "C" fn(Handle, *mut Context, *mut c_void, c_uint, usize);
type QueryBlocks = unsafe extern "C" fn(Handle, *mut Context, *mut c_void, c_uint, c_uint, usize);

#[link(name = "embree3")]
unsafe extern "C" {
    fn rtcNewDevice(config: *const c_char) -> Handle;
    fn rtcReleaseDevice(device: Handle);
    fn rtcGetDeviceError(device: Handle) -> c_int;
    fn rtcGetDeviceProperty(device: Handle, property: c_int) -> isize;
    fn rtcSetDeviceMemoryMonitorFunction(device: Handle, monitor: MemoryMonitor, user: *mut c_void);
    fn rtcNewGeometry(device: Handle, kind: c_int) -> Handle;
    fn rtcReleaseGeometry(geometry: Handle);
    fn rtcSetGeometryBuildQuality(geometry: Handle, quality: c_int);
    fn rtcSetSharedGeometryBuffer(
        geometry: Handle,
        kind: c_int,
        slot: c_uint,
        format: c_int,
        data: *const c_void,
        offset: usize,
        stride: usize,
        count: usize,
    );
    fn rtcUpdateGeometryBuffer(geometry: Handle, kind: c_int, slot: c_uint);
    fn rtcCommitGeometry(geometry: Handle);
    fn rtcNewScene(device: Handle) -> Handle;
    fn rtcSetSceneFlags(scene: Handle, flags: c_int);
    fn rtcReleaseScene(scene: Handle);
    fn rtcSetSceneBuildQuality(scene: Handle, quality: c_int);
    fn rtcAttachGeometry(scene: Handle, geometry: Handle) -> c_uint;
    fn rtcCommitScene(scene: Handle);
    fn rtcIntersect1(scene: Handle, context: *mut Context, ray: *mut RayHit<1>);
    fn rtcIntersect4(valid: *const c_int, scene: Handle, context: *mut Context, rays: *mut RayHit<4>);
    fn rtcIntersect8(valid: *const c_int, scene: Handle, context: *mut Context, rays: *mut RayHit<8>);
    fn rtcIntersect16(valid: *const c_int, scene: Handle, context: *mut Context, rays: *mut RayHit<16>);
    fn rtcIntersect1M(scene: Handle, context: *mut Context, rays: *mut c_void, count: c_uint, stride: usize);
    fn rtcIntersectNM(scene: Handle, context: *mut Context, rays: *mut c_void, n: c_uint, m: c_uint, stride: usize);
    fn rtcOccluded1(scene: Handle, context: *mut Context, ray: *mut Ray<1>);
    fn rtcOccluded4(valid: *const c_int, scene: Handle, context: *mut Context, rays: *mut Ray<4>);
    fn rtcOccluded8(valid: *const c_int, scene: Handle, context: *mut Context, rays: *mut Ray<8>);
    fn rtcOccluded16(valid: *const c_int, scene: Handle, context: *mut Context, rays: *mut Ray<16>);
    fn rtcOccluded1M(scene: Handle, context: *mut Context, rays: *mut c_void, count: c_uint, stride: usize);
    fn rtcOccludedNM(scene: Handle, context: *mut Context, rays: *mut c_void, n: c_uint, m: c_uint, stride: usize);
}

const TRIANGLES: c_int = 0;
const SPHERES: c_int = 50;
const INDEX_BUFFER: c_int = 0;
const VERTEX_BUFFER: c_int = 1;
const UINT3: c_int = 0x5003;
const FLOAT3: c_int = 0x9003;
const FLOAT4: c_int = 0x9004;
const DYNAMIC: c_int = 1;
const NONE: c_uint = c_uint::MAX;
const NATIVE_4: c_int = 32;
const NATIVE_8: c_int = 33;
const NATIVE_16: c_int = 34;
const STREAMS: c_int = 35;

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

/// How much work the builder puts in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// Morton order, for per-frame builds.
    Low,
    /// Binned surface area heuristic: the default.
    Medium,
    /// With spatial splits.
    High,
    /// For geometry that moves: [`Scene::refit`] follows.
    Refit,
}

impl Quality {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
            Self::Refit => "refit",
        }
    }
}

/// Embree, limited to an instruction set and a number of threads.
#[derive(Debug)]
pub struct Device {
    handle: Handle,
    /// Bytes that it holds now, as its memory monitor tells; boxed, for Embree keeps the address.
    bytes: Box<AtomicIsize>,
}

impl Device {
    /// A device for `isa` (`sse2`, `sse4.2`, `avx2`, `avx512`) with so many builder threads.
    ///
    /// # Errors
    /// If Embree refuses.
    pub fn new(isa: &str, threads: usize) -> Result<Self, String> {
        let config = format!("isa={isa},threads={threads},set_affinity=0,frequency_level=simd512");
        let config = CString::new(config).map_err(|error| error.to_string())?;
        // SAFETY: the string ends in a zero and is only read during the call.
        let handle = unsafe { rtcNewDevice(config.as_ptr()) };
        if handle.is_null() {
            // SAFETY: a null device asks for the error of this thread.
            return Err(format!("Embree refuses {config:?}: error {}", unsafe { rtcGetDeviceError(handle) }));
        }
        let device = Self { handle, bytes: Box::default() };
        let counter: *const AtomicIsize = &*device.bytes;
        // SAFETY: the counter lives on the heap until after the device is released, in `drop`.
        unsafe { rtcSetDeviceMemoryMonitorFunction(handle, count_bytes, counter.cast_mut().cast()) };
        Ok(device)
    }

    fn has(&self, property: c_int) -> bool {
        // SAFETY: the handle is a device until `drop`.
        unsafe { rtcGetDeviceProperty(self.handle, property) != 0 }
    }

    /// Has it instructions for this interface? Others are emulated by narrower ones, to no profit.
    pub fn is_native(&self, interface: Interface) -> bool {
        match interface.entry {
            Entry::One => true,
            Entry::Four => self.has(NATIVE_4),
            Entry::Eight => self.has(NATIVE_8),
            Entry::Sixteen => self.has(NATIVE_16),
            Entry::Stream | Entry::Block => self.has(STREAMS),
        }
    }

    fn check(&self) -> Result<(), String> {
        // SAFETY: the handle is a device until `drop`.
        match unsafe { rtcGetDeviceError(self.handle) } {
            0 => Ok(()),
            error => Err(format!("Embree error {error}")),
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: scenes borrow the device, so this was its last user here.
        unsafe { rtcReleaseDevice(self.handle) };
    }
}

extern "C" fn count_bytes(counter: *mut c_void, bytes: isize, _after: bool) -> bool {
    // SAFETY: the pointer that `Device::new` gave: an atomic that outlives the device.
    unsafe { (*counter.cast::<AtomicIsize>()).fetch_add(bytes, Relaxed) };
    true
}

/// What a scene is made of.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// A triangle mesh.
    Triangles(&'a Triangles),
    /// Spheres: centre, radius.
    Spheres(&'a [[f32; 4]]),
}

/// A committed scene of one geometry.
#[derive(Debug)]
pub struct Scene<'a> {
    handle: Handle,
    /// Kept by the scene.
    geometry: Handle,
    bytes: isize,
    users: PhantomData<(&'a Device, Source<'a>)>,
}

impl<'a> Scene<'a> {
    /// Builds; the primitives are shared, not copied.
    ///
    /// # Errors
    /// Embree's error.
    pub fn new(device: &'a Device, source: Source<'a>, quality: Quality) -> Result<Self, String> {
        let before = device.bytes.load(Relaxed);
        // SAFETY: the buffers hold `count` items of the given stride and format, aligned to 4 bytes, are readable for
        // 16 bytes at the last vertex, and outlive the scene by `'a`. The geometry belongs to the scene once attached.
        let (handle, geometry) = unsafe {
            let geometry = match source {
                Source::Triangles(triangles) => {
                    // The positions have one more than the indices know: Embree reads 16 bytes at each corner.
                    let corners = triangles.positions.len() - 1;
                    let geometry = rtcNewGeometry(device.handle, TRIANGLES);
                    let (vertices, indices) = (triangles.positions.as_ptr().cast(), triangles.indices.as_ptr().cast());
                    rtcSetSharedGeometryBuffer(geometry, VERTEX_BUFFER, 0, FLOAT3, vertices, 0, 12, corners);
                    let count = triangles.indices.len();
                    rtcSetSharedGeometryBuffer(geometry, INDEX_BUFFER, 0, UINT3, indices, 0, 12, count);
                    geometry
                }
                Source::Spheres(spheres) => {
                    let geometry = rtcNewGeometry(device.handle, SPHERES);
                    let data = spheres.as_ptr().cast();
                    rtcSetSharedGeometryBuffer(geometry, VERTEX_BUFFER, 0, FLOAT4, data, 0, 16, spheres.len());
                    geometry
                }
            };
            rtcSetGeometryBuildQuality(geometry, quality as c_int);
            rtcCommitGeometry(geometry);
            let scene = rtcNewScene(device.handle);
            if quality == Quality::Refit {
                // Refitting is what its builder of dynamic scenes does, with the geometry's own tree below.
                rtcSetSceneFlags(scene, DYNAMIC);
                rtcSetSceneBuildQuality(scene, Quality::Low as c_int);
            } else {
                rtcSetSceneBuildQuality(scene, quality as c_int);
            }
            rtcAttachGeometry(scene, geometry);
            rtcReleaseGeometry(geometry);
            rtcCommitScene(scene);
            (scene, geometry)
        };
        let scene = Self { handle, geometry, bytes: device.bytes.load(Relaxed) - before, users: PhantomData };
        device.check().map(|()| scene)
    }

    /// Says that all vertices moved, and refits if it was built for that.
    pub fn refit(&mut self) {
        // SAFETY: the scene and its geometry live until `drop`; nobody traces meanwhile.
        unsafe {
            rtcUpdateGeometryBuffer(self.geometry, VERTEX_BUFFER, 0);
            rtcCommitGeometry(self.geometry);
            rtcCommitScene(self.handle);
        }
    }

    /// Bytes that the scene occupies, without the triangles that it shares.
    pub fn bytes(&self) -> usize {
        self.bytes.max(0) as usize
    }

    /// Embree's timed loop for closest hits: load rays from the arrays, query, store. Flush-to-zero is on, as Embree asks.
    pub fn intersect(&self, interface: Interface, rays: &RaySet, found: &mut Found) {
        let _flushing = FlushToZero::new();
        match interface.entry {
            Entry::One => self.packets(interface, rays, found, Call::One(rtcIntersect1)),
            Entry::Four => self.packets(interface, rays, found, Call::Packet(rtcIntersect4)),
            Entry::Eight => self.packets(interface, rays, found, Call::Packet(rtcIntersect8)),
            Entry::Sixteen => self.packets(interface, rays, found, Call::Packet(rtcIntersect16)),
            Entry::Stream => self.streams::<RayHit<1>>(interface, rays, found, rtcIntersect1M),
            Entry::Block => self.packets(interface, rays, found, Call::<RayHit<256>>::Block(rtcIntersectNM)),
        }
    }

    /// Embree's timed loop for any hits: as [`intersect`](Self::intersect), without primitives.
    pub fn occluded(&self, interface: Interface, rays: &RaySet, found: &mut Found) {
        let _flushing = FlushToZero::new();
        match interface.entry {
            Entry::One => self.packets(interface, rays, found, Call::One(rtcOccluded1)),
            Entry::Four => self.packets(interface, rays, found, Call::Packet(rtcOccluded4)),
            Entry::Eight => self.packets(interface, rays, found, Call::Packet(rtcOccluded8)),
            Entry::Sixteen => self.packets(interface, rays, found, Call::Packet(rtcOccluded16)),
            Entry::Stream => self.streams::<Ray<1>>(interface, rays, found, rtcOccluded1M),
            Entry::Block => self.packets(interface, rays, found, Call::<Ray<256>>::Block(rtcOccludedNM)),
        }
    }

    #[inline(always)]
    fn packets<R: Packet>(&self, interface: Interface, rays: &RaySet, found: &mut Found, call: Call<R>) {
        let mut context = Context::new(interface);
        let mut packet = R::new();
        let mut valid = Valid([-1; 256]);
        for at in (0..rays.len()).step_by(R::WIDTH) {
            let count = R::WIDTH.min(rays.len() - at);
            valid.0[count..R::WIDTH].fill(0);
            packet.load(rays, at, count);
            // SAFETY: the scene is committed; `valid` and the packet are aligned as the widest ones must be and as wide
            // as the function's name says, by `Call`'s types. Rays after `count` are masked, in a stream by their
            // empty interval.
            unsafe {
                match call {
                    Call::One(query) => query(self.handle, &mut context, &mut packet),
                    Call::Packet(query) => query(valid.0.as_ptr(), self.handle, &mut context, &mut packet),
                    Call::Block(query) => {
                        let (packet, width) = ((&raw mut packet).cast(), R::WIDTH as c_uint);
                        query(self.handle, &mut context, packet, width, 1, size_of::<R>());
                    }
                }
            }
            packet.store(found, at, count);
        }
    }

    fn streams<R: Packet>(&self, interface: Interface, rays: &RaySet, found: &mut Found, query: QueryMany) {
        const MANY: usize = 256;
        let mut context = Context::new(interface);
        let mut stream: Vec<R> = (0..MANY).map(|_| R::new()).collect();
        for first in (0..rays.len()).step_by(MANY) {
            let count = MANY.min(rays.len() - first);
            for (i, ray) in stream[..count].iter_mut().enumerate() {
                ray.load(rays, first + i, 1);
            }
            let (stream_start, stride) = (stream.as_mut_ptr().cast(), size_of::<R>());
            // SAFETY: the scene is committed; `count` rays lie `stride` bytes apart.
            unsafe { query(self.handle, &mut context, stream_start, count as c_uint, stride) };
            for (i, ray) in stream[..count].iter().enumerate() {
                ray.store(found, first + i, 1);
            }
        }
    }
}

impl Drop for Scene<'_> {
    fn drop(&mut self) {
        // SAFETY: owned, and released once.
        unsafe { rtcReleaseScene(self.handle) };
    }
}

impl Context {
    fn new(interface: Interface) -> Self {
        Self { flags: c_int::from(interface.coherent), filter: null(), instance: [NONE] }
    }
}

/// -1 for each ray to trace.
#[repr(align(64))]
struct Valid([c_int; 256]);

/// A function and how it takes its rays.
enum Call<R> {
    One(QueryOne<R>),
    Packet(Query<R>),
    Block(QueryBlocks),
}

/// Rays in Embree's layout.
trait Packet {
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

impl<const W: usize> Packet for RayHit<W> {
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
    }
}

impl<const W: usize> Packet for Ray<W> {
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

/// Denormal numbers count as zero on this thread while this lives, as Embree's manual asks of its callers.
struct FlushToZero {
    before: u32,
}

impl FlushToZero {
    /// Bits "flush to zero" and "denormals are zero" of the control register.
    const BITS: u32 = 0x8040;

    fn new() -> Self {
        let mut before = 0u32;
        // SAFETY: stores and loads the control register. Rust code that runs meanwhile copies floats, but computes none.
        unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut before, options(nostack)) };
        let flushing = before | Self::BITS;
        // SAFETY: as above; only the two bits change.
        unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const flushing, options(nostack)) };
        Self { before }
    }
}

impl Drop for FlushToZero {
    fn drop(&mut self) {
        // SAFETY: what the register held before.
        unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const self.before, options(nostack)) };
    }
}
