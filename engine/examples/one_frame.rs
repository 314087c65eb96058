//! Renders one frame of the built-in scene on one thread, without the pipeline, and writes a PNG.
//!
//!     cargo run --release --example one_frame -- [output.png] [WIDTH HEIGHT] [renderer] [sampler]

use std::error::Error;

use mobula::accel::AccelerationKind;
use mobula::builtin;
use mobula::camera::Pinhole;
use mobula::image::FrameBuffer;
use mobula::renderer::RendererKind;
use mobula::sampler::SamplerKind;
use mobula::scene;
use mobula::stack::{Context, Fragment, Statistics};
use mobula::tone::Tone;
use mobula_simd::AnyToken;

/// Rays in a packet.
const WIDTH: usize = 64;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut next = |default: &str| arguments.next().unwrap_or_else(|| default.to_owned());
    let output = next("frame.png");
    let (width, height): (u32, u32) = (next("800").parse()?, next("600").parse()?);
    let renderer = next("raytracer").parse::<RendererKind>()?.build();
    let sampler = next("single").parse::<SamplerKind>()?.build();

    let scene = scene::build(&builtin::scene(), AccelerationKind::Bvh)?;
    let camera = Pinhole::new(scene.view(width as f32 / height as f32));
    let picture = FrameBuffer::new(width as usize, height as usize)?;
    let statistics = Statistics::default();
    let (token, renderer) = (AnyToken::detect(), &*renderer);
    let context = Context {
        token,
        width: WIDTH,
        scene: &scene,
        renderer,
        statistics: &statistics,
        tone: Tone::default(),
        eye: Some(scene.view(width as f32 / height as f32).eye),
        frame: 0,
    };
    let whole = Fragment { channel: 0, x0: 0, y0: 0, x1: width as usize, y1: height as usize, step: 1 };
    let start = std::time::Instant::now();
    sampler.render_fragment(&context, &camera, whole, &picture);
    eprintln!("{:?}, {statistics:?}", start.elapsed());

    let mut encoder = png::Encoder::new(std::fs::File::create(&output)?, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header()?.write_image_data(&picture.to_rgba8())?;
    println!("wrote {output}");
    Ok(())
}
