//! Pictures that are too large for one request of X11, drawn in strips.
//!
//! The library that draws, softbuffer, gives pictures to the server in shared memory. Where there is none (the extension
//! MIT-SHM is missing, or the display is another machine's) it sends a picture in one request, and fails if that is longer than
//! requests may be: 16 MiB on common servers. Then pictures are sent from here, through a connection of its own.

#[cfg(all(unix, not(target_vendor = "apple")))]
pub(super) use x11::Strips;

#[cfg(not(all(unix, not(target_vendor = "apple"))))]
pub(super) use elsewhere::Strips;

#[cfg(all(unix, not(target_vendor = "apple")))]
mod x11 {
    use std::error::Error;

    use winit::raw_window_handle::{HasWindowHandle, RawWindowHandle};
    use winit::window::Window;
    use x11rb::connection::{Connection, RequestConnection};
    use x11rb::protocol::xproto::{ConnectionExt, CreateGCAux, Gcontext, ImageFormat, ImageOrder};
    use x11rb::rust_connection::RustConnection;

    /// The bytes of a request before its pixels, generously.
    const HEAD: usize = 64;
    /// The most bytes of pixels in a strip.
    const STRIP: usize = 1 << 20;

    /// Draws in a window of an X server.
    pub(in super::super) struct Strips {
        connection: RustConnection,
        window: u32,
        context: Gcontext,
        depth: u8,
        row: Vec<u32>,
        bytes: Vec<u8>,
    }

    impl Strips {
        /// None on other systems.
        pub(in super::super) fn new(window: &Window) -> Option<Self> {
            let window = match window.window_handle().ok()?.as_raw() {
                RawWindowHandle::Xlib(handle) => u32::try_from(handle.window).ok()?,
                RawWindowHandle::Xcb(handle) => handle.window.get(),
                _ => return None,
            };
            let (connection, _) = RustConnection::connect(None).ok()?;
            let depth = connection.get_geometry(window).ok()?.reply().ok()?.depth;
            let context = connection.generate_id().ok()?;
            connection.create_gc(context, window, &CreateGCAux::new().graphics_exposures(0)).ok()?.check().ok()?;
            Some(Self { connection, window, context, depth, row: Vec::new(), bytes: Vec::new() })
        }

        /// Whether a picture of this size is one request.
        pub(in super::super) fn fits(&self, [width, height]: [usize; 2]) -> bool {
            width * height * 4 <= self.connection.maximum_request_bytes().saturating_sub(HEAD)
        }

        /// Draws a picture, whose rows `fill` writes as 0x00RRGGBB.
        pub(in super::super) fn draw(
            &mut self,
            size: [usize; 2],
            fill: &dyn Fn(usize, &mut [u32]),
        ) -> Result<(), String> {
            self.send(size, fill).map_err(|error| format!("the display takes no picture: {error}"))
        }

        fn send(
            &mut self,
            [width, height]: [usize; 2],
            fill: &dyn Fn(usize, &mut [u32]),
        ) -> Result<(), Box<dyn Error>> {
            let Self { connection, row, bytes, .. } = self;
            let most = connection.maximum_request_bytes().saturating_sub(HEAD).min(STRIP);
            let rows = (most / (4 * width)).max(1);
            let low_first = connection.setup().image_byte_order == ImageOrder::LSB_FIRST;
            row.resize(width, 0);
            for top in (0..height).step_by(rows) {
                let bottom = height.min(top + rows);
                bytes.clear();
                for y in top..bottom {
                    fill(y, row);
                    let order = |pixel: &u32| if low_first { pixel.to_le_bytes() } else { pixel.to_be_bytes() };
                    bytes.extend(row.iter().flat_map(order));
                }
                let (wide, high, y) = (u16::try_from(width)?, u16::try_from(bottom - top)?, i16::try_from(top)?);
                let (format, window, context) = (ImageFormat::Z_PIXMAP, self.window, self.context);
                connection.put_image(format, window, context, wide, high, 0, y, 0, self.depth, bytes)?;
            }
            // Pictures do not queue up: the next one is sent when this one is there.
            connection.get_input_focus()?.reply()?;
            Ok(())
        }
    }
}

#[cfg(not(all(unix, not(target_vendor = "apple"))))]
mod elsewhere {
    use winit::window::Window;

    /// There are none.
    pub(in super::super) enum Strips {}

    impl Strips {
        pub(in super::super) fn new(_: &Window) -> Option<Self> {
            None
        }

        pub(in super::super) fn fits(&self, _: [usize; 2]) -> bool {
            match *self {}
        }

        pub(in super::super) fn draw(&mut self, _: [usize; 2], _: &dyn Fn(usize, &mut [u32])) -> Result<(), String> {
            match *self {}
        }
    }
}
