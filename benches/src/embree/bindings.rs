//! Embree 3, as little of it as the peer bench needs, bound by hand from its headers (`rtcore_*.h` of 3.13.5).
//!
//! The one file of this package that calls foreign code. Handles are owned here and never leave; the structures below
//! have the layout of Embree's `RTCRay*` and `RTCRayHit*`, which are arrays of 4-byte fields for every width.

#![allow(unsafe_code, reason = "foreign functions")]

use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::marker::PhantomData;
use std::ptr::null;
use std::sync::atomic::{AtomicIsize, Ordering::Relaxed};

use crate::scenes::Primitives;

type Handle = *mut c_void;

/// `RTCIntersectContext`.
#[repr(C)]
pub(super) struct Context {
    flags: c_int,
    filter: *const c_void,
    instance: [c_uint; 1],
}

/// `RTCRay` (`W` = 1), `RTCRay4`, `RTCRay8`, `RTCRay16`, or `W` rays of a stream; aligned for all of them.
#[repr(C, align(64))]
pub(super) struct Ray<const W: usize> {
    pub(super) origin: [[f32; W]; 3],
    pub(super) near: [f32; W],
    pub(super) direction: [[f32; W]; 3],
    pub(super) time: [f32; W],
    pub(super) far: [f32; W],
    pub(super) mask: [c_uint; W],
    pub(super) id: [c_uint; W],
    pub(super) flags: [c_uint; W],
}

/// `RTCRayHit` and its wider forms. The hit follows the ray without padding, as 12 rows of 4 bytes times 1, 4, 8 or 16
/// keep the alignment that it has there; so it is part of one structure here.
#[repr(C, align(64))]
pub(super) struct RayHit<const W: usize> {
    pub(super) origin: [[f32; W]; 3],
    pub(super) near: [f32; W],
    pub(super) direction: [[f32; W]; 3],
    pub(super) time: [f32; W],
    pub(super) far: [f32; W],
    pub(super) mask: [c_uint; W],
    pub(super) id: [c_uint; W],
    pub(super) flags: [c_uint; W],
    pub(super) normal: [[f32; W]; 3],
    pub(super) uv: [[f32; W]; 2],
    pub(super) primitive: [c_uint; W],
    pub(super) geometry: [c_uint; W],
    pub(super) instance: [c_uint; W],
}

type MemoryMonitor = extern "C" fn(*mut c_void, isize, bool) -> bool;

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
pub(super) const NONE: c_uint = c_uint::MAX;

/// What a device may have.
#[derive(Clone, Copy, Debug)]
pub(super) enum Property {
    Packets4 = 32,
    Packets8 = 33,
    Packets16 = 34,
    Streams = 35,
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

    /// Has it instructions for packets of so many rays, or for streams?
    pub(super) fn has(&self, property: Property) -> bool {
        // SAFETY: the handle is a device until `drop`.
        unsafe { rtcGetDeviceProperty(self.handle, property as c_int) != 0 }
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

/// A committed scene of one geometry.
#[derive(Debug)]
pub struct Scene<'a> {
    handle: Handle,
    /// Kept by the scene.
    geometry: Handle,
    bytes: isize,
    users: PhantomData<(&'a Device, &'a Primitives)>,
}

impl<'a> Scene<'a> {
    /// Builds; the primitives are shared, not copied.
    ///
    /// # Errors
    /// Embree's error.
    pub fn new(device: &'a Device, primitives: &'a Primitives, quality: Quality) -> Result<Self, String> {
        let before = device.bytes.load(Relaxed);
        // SAFETY: the buffers hold `count` items of the given stride and format, aligned to 4 bytes, are readable for
        // 16 bytes at the last vertex, and outlive the scene by `'a`. The geometry belongs to the scene once attached.
        let (handle, geometry) = unsafe {
            let geometry = match primitives {
                Primitives::Triangles(triangles) => {
                    // The positions have one more than the indices know: Embree reads 16 bytes at each corner.
                    let corners = triangles.positions.len() - 1;
                    let geometry = rtcNewGeometry(device.handle, TRIANGLES);
                    let (vertices, indices) = (triangles.positions.as_ptr().cast(), triangles.indices.as_ptr().cast());
                    rtcSetSharedGeometryBuffer(geometry, VERTEX_BUFFER, 0, FLOAT3, vertices, 0, 12, corners);
                    let count = triangles.indices.len();
                    rtcSetSharedGeometryBuffer(geometry, INDEX_BUFFER, 0, UINT3, indices, 0, 12, count);
                    geometry
                }
                Primitives::Spheres(spheres) => {
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
}

impl Drop for Scene<'_> {
    fn drop(&mut self) {
        // SAFETY: owned, and released once.
        unsafe { rtcReleaseScene(self.handle) };
    }
}

impl Context {
    pub(super) fn new(coherent: bool) -> Self {
        Self { flags: c_int::from(coherent), filter: null(), instance: [NONE] }
    }
}

/// Which rays of a packet to trace: -1 for each.
#[repr(align(64))]
pub(super) struct Valid([c_int; 256]);

impl Valid {
    /// All.
    pub(super) const ALL: Self = Self([-1; 256]);

    /// Only the first `count` of the first `width`.
    #[inline(always)]
    pub(super) fn only(&mut self, count: usize, width: usize) {
        self.0[count..width].fill(0);
    }
}

/// A structure of rays that Embree takes in one call.
pub(super) trait Query: Sized {
    /// Finds the hits of those that are valid; in a stream of 256, of all: an empty interval ends a ray there.
    fn find(&mut self, scene: &Scene<'_>, context: &mut Context, valid: &Valid);
}

/// A ray that Embree takes in streams of many.
pub(super) trait Stream: Sized {
    /// Finds the hits of all.
    fn find_all(rays: &mut [Self], scene: &Scene<'_>, context: &mut Context);
}

macro_rules! queries {
    ($($rays:ident: $one:ident, $many:ident, $block:ident, $($width:literal $packet:ident),*;)*) => {$(
        impl Query for $rays<1> {
            #[inline(always)]
            fn find(&mut self, scene: &Scene<'_>, context: &mut Context, _valid: &Valid) {
                // SAFETY: the scene is committed; the ray is laid out and aligned as the function asks.
                unsafe { $one(scene.handle, context, self) };
            }
        }

        $(impl Query for $rays<$width> {
            #[inline(always)]
            fn find(&mut self, scene: &Scene<'_>, context: &mut Context, valid: &Valid) {
                // SAFETY: the scene is committed; the mask and the rays are as wide as the function's name says and
                // aligned as the widest must be.
                unsafe { $packet(valid.0.as_ptr(), scene.handle, context, self) };
            }
        })*

        impl Query for $rays<256> {
            #[inline(always)]
            fn find(&mut self, scene: &Scene<'_>, context: &mut Context, _valid: &Valid) {
                // SAFETY: the scene is committed; it is one structure of 256 rays.
                unsafe { $block(scene.handle, context, (&raw mut *self).cast(), 256, 1, size_of::<Self>()) };
            }
        }

        impl Stream for $rays<1> {
            #[inline(always)]
            fn find_all(rays: &mut [Self], scene: &Scene<'_>, context: &mut Context) {
                let (start, count) = (rays.as_mut_ptr().cast(), rays.len() as c_uint);
                // SAFETY: the scene is committed; `count` rays lie so many bytes apart.
                unsafe { $many(scene.handle, context, start, count, size_of::<Self>()) };
            }
        }
    )*};
}

queries! {
    RayHit: rtcIntersect1, rtcIntersect1M, rtcIntersectNM, 4 rtcIntersect4, 8 rtcIntersect8, 16 rtcIntersect16;
    Ray: rtcOccluded1, rtcOccluded1M, rtcOccludedNM, 4 rtcOccluded4, 8 rtcOccluded8, 16 rtcOccluded16;
}

/// Denormal numbers count as zero on this thread while this lives, as Embree's manual asks of its callers.
pub(super) struct FlushToZero {
    before: u32,
}

impl FlushToZero {
    /// Bits "flush to zero" and "denormals are zero" of the control register.
    const BITS: u32 = 0x8040;

    pub(super) fn new() -> Self {
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
