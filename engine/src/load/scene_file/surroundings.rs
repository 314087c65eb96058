//! Background, camera, and what else concerns the whole scene.

use std::sync::Arc;

use glam::Vec3;
use toml::Spanned;

use super::keys::{self, Camera, Head};
use super::lights::{WantedLight, light, vector};
use super::text::Text;
use super::textures::picture;
use super::values::{Named, point};
use crate::background::{self, Background, Constant, Gradient};
use crate::camera::CameraKind;
use crate::image::Size;
use crate::light::Hemisphere;
use crate::load::place::Place;
use crate::load::{self, LoadError, is_picture};
use crate::medium::Fog;
use crate::scene::{Ground, SceneDescription, Time};
use crate::view::{Up, View};

/// Puts all this into a scene whose files were put somewhere.
pub(super) fn add(
    text: &Text<'_>,
    head: &Head,
    lights: &[WantedLight],
    place: &Place,
    scene: &mut SceneDescription,
) -> Result<(), LoadError> {
    if !lights.is_empty() {
        scene.lights = lights.iter().map(|wanted| light(wanted, place)).collect();
    }
    match head.ambient.as_ref().map(Spanned::get_ref) {
        None => {}
        Some(keys::Ambient::Plain(color)) => {
            scene.ambient = Arc::new(Hemisphere { above: color.0, below: color.0 });
        }
        Some(keys::Ambient::Hemisphere(keys::Hemisphere { above, below })) => {
            scene.ambient = Arc::new(Hemisphere { above: above.0, below: below.0 });
        }
    }
    let background: Option<Arc<dyn Background>> = match head.background.as_ref().map(Spanned::get_ref) {
        Some(keys::Background::Picture(keys::Panorama { file, rotate, strength })) => {
            let [rotate, strength] = [rotate.map_or(0.0, |x| x.0), strength.map_or(1.0, |x| x.0)].map(|x| x as f32);
            Some(Arc::new(load::environment(&picture(text, file)?, rotate, strength)?))
        }
        None => None,
        Some(keys::Background::Words(words)) if is_picture(words.as_ref()) => {
            let span = head.background.as_ref().map_or(0..0, Spanned::span);
            Some(Arc::new(load::environment(&picture(text, &Spanned::new(span, words.clone()))?, 0.0, 1.0)?))
        }
        Some(keys::Background::Words(words)) => background::parse(words),
        Some(keys::Background::Plain(color)) => Some(Arc::new(Constant { color: color.0 })),
        Some(keys::Background::Sky(keys::Sky { zenith, horizon, nadir })) => {
            Some(Arc::new(Gradient { zenith: zenith.0, horizon: horizon.0, nadir: nadir.0 }))
        }
    };
    if let Some(background) = background {
        if let Some(ambient) = head.ambient.as_ref().filter(|_| background.light(Up::Y).is_some()) {
            let problem = "this background lights the scene from everywhere: there is no other ambient light";
            return Err(text.error(ambient.span(), problem, "leave out ambient, or choose another background"));
        }
        scene.background = background;
    }
    scene.ground = match head.ground {
        None => scene.ground,
        Some(keys::Ground::Usual(there)) => there.then(Ground::default),
        Some(keys::Ground::Such(keys::SuchGround { height, color })) => {
            let color = color.map_or(Ground::default().color, |color| color.0);
            // Which axis is up may be known later: a point that is as high along each.
            Some(Ground { at: height.map(|height| place.put([height.0; 3]).into()), color })
        }
    };
    if let Some(keys::Fog { density, color }) = head.fog {
        let fog = Fog::new((density.0 / place.scale) as f32);
        scene.media.push(Arc::new(Fog { color: color.map_or(fog.color, |color| color.0), ..fog }));
    }
    let rendering = &mut scene.rendering;
    rendering.renderer = head.renderer.map(|Named(kind)| kind);
    rendering.sampler = head.sampler.map(|Named(kind)| kind);
    rendering.shadows = head.shadows;
    rendering.tone = head.tone.map(|Named(curve)| curve);
    rendering.exposure = head.exposure.map(|stops| stops.0 as f32);
    rendering.occlusion = head.occlusion.map(|reach| (reach.0 * place.scale) as f32);
    rendering.time = head.time.map(|keys::Time { step, repeat, show }| Time {
        step: step.map(|seconds| seconds.0),
        repeat,
        shown: show.map_or(0, |show| usize::try_from(show.0).unwrap_or(usize::MAX)),
    });
    if let Some(size) = &head.size {
        let [width, height] = size.get_ref().map(|side| usize::try_from(side.0).unwrap_or(usize::MAX));
        let checked = Size::new(width, height);
        let remedy = "write [width, height] in pixels, such as [1024, 768]";
        rendering.size = Some(checked.map_err(|error| text.error(size.span(), error.to_string(), remedy))?);
    }
    if let Some(camera) = &head.camera {
        look(text, camera, place, scene)?;
    }
    scene.up = head.up.map(|Named(axis)| axis).or(scene.up);
    Ok(())
}

fn look(
    text: &Text<'_>,
    camera: &Spanned<Camera>,
    place: &Place,
    scene: &mut SceneDescription,
) -> Result<(), LoadError> {
    let Camera { kind, eye, at, up, fov, aperture, focus } = *camera.get_ref();
    let put = |position: super::values::Point| Vec3::from(place.put(point(position)));
    let [eye, at] = [eye, at].map(|position| position.map(put));
    if eye.is_some() && eye == at {
        let remedy = "write different points behind eye and at";
        return Err(text.error(camera.span(), "the eye is where it looks at", remedy));
    }
    if let Some(up) = up {
        let up = vector(up);
        if up == Vec3::ZERO {
            return Err(text.error(camera.span(), "up leads nowhere", "write up = [0, 0, 1] or [0, 1, 0]"));
        }
        // The axis of the scene, for the sky and the usual lights, if it is one.
        let axis = [Up::Y, Up::Z].into_iter().find(|axis| up.normalize_or_zero() == axis.vector());
        scene.up = axis.or(scene.up);
        scene.rendering.up = Some(up);
    }
    let has_lens = aperture.is_some() || focus.is_some();
    let kind = kind.or(has_lens.then_some(Named(CameraKind::ThinLens)));
    let widest = kind.map_or(View::WIDEST, |Named(kind)| kind.widest());
    if fov.is_some_and(|angle| angle.0 > f64::from(widest)) {
        let problem = format!("this camera has a field of view of at most {widest} degrees");
        return Err(text.error(camera.span(), problem, "write a smaller fov, or kind = \"fisheye\""));
    }
    let rendering = &mut scene.rendering;
    let length = |length: f64| (length * place.scale) as f32;
    rendering.aperture = aperture.map(|radius| length(radius.0));
    rendering.focus = focus.map(|distance| length(distance.0));
    rendering.camera = kind.map(|Named(kind)| kind);
    (rendering.eye, rendering.at) = (eye, at);
    rendering.fov = fov.map(|angle| angle.0 as f32);
    Ok(())
}
