//! Pictures as OpenEXR files: light as it arrives, and layers of what is behind each pixel.
//!
//! | channels | what they are |
//! |---|---|
//! | R, G, B, A | light, linear, before exposure and tone curve; A is 1 |
//! | Z | distance along the ray through the middle of the pixel, in units of the scene; infinite where nothing is |
//! | N.X, N.Y, N.Z | unit shading normal; 0 where nothing is |
//! | albedo.R, albedo.G, albedo.B | colour of the surface, unlit, linear |
//! | id.geometry, id.primitive, id.material | whole numbers from 0; 4294967295 where nothing is |

use std::io::{self, Cursor, Write};

use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::meta::header::LayerAttributes;
use exr::prelude::{SmallVec, WritableImage};

use crate::layers::{Layers, Plane};

/// Channels of light and of surfaces.
const NUMBERS: [(&str, Plane); 10] = [
    ("R", Plane::Red),
    ("G", Plane::Green),
    ("B", Plane::Blue),
    ("Z", Plane::Depth),
    ("N.X", Plane::NormalX),
    ("N.Y", Plane::NormalY),
    ("N.Z", Plane::NormalZ),
    ("albedo.R", Plane::AlbedoRed),
    ("albedo.G", Plane::AlbedoGreen),
    ("albedo.B", Plane::AlbedoBlue),
];
/// Channels of whole numbers.
const WHOLE: [(&str, Plane); 3] =
    [("id.geometry", Plane::Geometry), ("id.primitive", Plane::Primitive), ("id.material", Plane::Material)];

/// Encodes the layers of a picture.
pub(super) fn encode(mut out: impl Write, size: [usize; 2], layers: &Layers) -> io::Result<()> {
    let channel = |name: &str, samples| AnyChannel::new(name, samples);
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    channels.extend(NUMBERS.map(|(name, plane)| channel(name, FlatSamples::F32(layers.numbers(plane)))));
    channels.push(channel("A", FlatSamples::F32(vec![1.0; size[0] * size[1]])));
    channels.extend(WHOLE.map(|(name, plane)| channel(name, FlatSamples::U32(layers.whole_numbers(plane)))));
    let attributes = LayerAttributes { software_name: Some("Mobula".into()), ..LayerAttributes::default() };
    let layer = Layer::new((size[0], size[1]), attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(|error| match error {
        exr::error::Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    })?;
    // The writer goes back to where it was; pipes cannot.
    out.write_all(bytes.get_ref())?;
    out.flush()
}
