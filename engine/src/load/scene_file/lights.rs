//! The lights of a scene file.

use std::ops::Range;
use std::sync::Arc;

use glam::Vec3;
use toml::de::DeTable;

use super::keys::{
    CameraLight, DirectionalLight, DiskLight, PointLight, RectangleLight, SphereLight, SpotLight, SunLight,
};
use super::named::kind_of;
use super::objects::list;
use super::text::Text;
use super::values::{self, point};
use crate::light::{Directional, Disk, Head, Light, LightKind, Point, Rectangle, Sphere, Spot, Sun};
use crate::load::LoadError;
use crate::load::place::Place;

/// A light, with the numbers of the file.
pub(super) enum WantedLight {
    Point(PointLight),
    Spot(SpotLight),
    Directional(DirectionalLight),
    Sun(SunLight),
    Rectangle(RectangleLight),
    Disk(DiskLight),
    Sphere(SphereLight),
    Camera(CameraLight),
}

/// The lights of a file.
pub(super) fn lights(text: &Text<'_>, file: &mut DeTable<'_>) -> Result<Vec<WantedLight>, LoadError> {
    let leads = |span: &Range<usize>, way: values::Point| match point(way) {
        [0.0, 0.0, 0.0] => {
            Err(text.error(span.clone(), "this direction leads nowhere", "write where the light comes from"))
        }
        _ => Ok(()),
    };
    let shines = |span: &Range<usize>, at: values::Point, to: values::Point| match point(at) == point(to) {
        true => {
            Err(text.error(span.clone(), "the light is where it shines to", "write different points behind at and to"))
        }
        false => Ok(()),
    };
    let read = |value| {
        let (kind, value) = kind_of::<LightKind>(text, value, "light", LightKind::NAMES)?;
        let span = value.span();
        Ok(match kind {
            LightKind::Point => WantedLight::Point(text.read(value)?),
            LightKind::Spot => {
                let light: SpotLight = text.read(value)?;
                shines(&span, light.at, light.to)?;
                let [inner, outer] = cone(&light);
                if inner > outer {
                    let problem = format!("the bright cone, of {inner} degrees, is wider than the whole, of {outer}");
                    return Err(text.error(
                        span,
                        problem,
                        "write inner and outer, both from the axis, the lesser first",
                    ));
                }
                WantedLight::Spot(light)
            }
            LightKind::Directional => {
                let light: DirectionalLight = text.read(value)?;
                leads(&span, light.direction)?;
                WantedLight::Directional(light)
            }
            LightKind::Sun => {
                let light: SunLight = text.read(value)?;
                leads(&span, light.direction)?;
                WantedLight::Sun(light)
            }
            LightKind::Rectangle => {
                let light: RectangleLight = text.read(value)?;
                shines(&span, light.at, light.to)?;
                WantedLight::Rectangle(light)
            }
            LightKind::Disk => {
                let light: DiskLight = text.read(value)?;
                shines(&span, light.at, light.to)?;
                WantedLight::Disk(light)
            }
            LightKind::Sphere => WantedLight::Sphere(text.read(value)?),
            LightKind::Camera => WantedLight::Camera(text.read(value)?),
        })
    };
    list(text, file, "light")?.into_iter().map(read).collect()
}

/// The angles of a spot, inner and outer: those that are not said are two thirds and three halves of each other.
fn cone(light: &SpotLight) -> [f64; 2] {
    let usual = Spot::default();
    let [inner, outer] = [light.inner, light.outer].map(|angle| angle.map(|angle| angle.0));
    let outer = outer.or(inner.map(|inner| (inner * 1.5).min(180.0))).unwrap_or(usual.outer.into());
    [inner.unwrap_or(outer / 1.5), outer]
}

/// Makes a light where files were put.
pub(super) fn light(wanted: &WantedLight, place: &Place) -> Arc<dyn Light> {
    let put = |position: values::Point| Vec3::from(place.put(point(position)));
    // In the numbers of the file, which are not rounded yet.
    let way = |at: values::Point, to: values::Point| {
        let ([x0, y0, z0], [x1, y1, z1]) = (point(at), point(to));
        crate::math::normalize_or([x1 - x0, y1 - y0, z1 - z0], Vec3::NEG_Y)
    };
    let long = |length: values::Positive| (length.0 * place.scale) as f32;
    // At distance 1 of the file.
    let weight = |falloff: bool| if falloff { (place.scale * place.scale) as f32 } else { 1.0 };
    match *wanted {
        WantedLight::Point(PointLight { at, color, falloff }) => {
            let color = color.map_or(Point::default().color, |color| color.0);
            Arc::new(Point { position: put(at), color: color * weight(falloff), falloff })
        }
        WantedLight::Spot(spot) => {
            let SpotLight { at, to, color, falloff, .. } = spot;
            let color = color.map_or(Spot::default().color, |color| color.0) * weight(falloff);
            let [inner, outer] = cone(&spot).map(|angle| angle as f32);
            Arc::new(Spot { position: put(at), direction: way(at, to), color, inner, outer, falloff })
        }
        WantedLight::Directional(DirectionalLight { direction, color }) => {
            let color = color.map_or(Directional::default().color, |color| color.0);
            Arc::new(Directional { direction: vector(direction), color })
        }
        WantedLight::Sun(SunLight { direction, color, angle }) => {
            let color = color.map_or(Sun::default().color, |color| color.0);
            let angle = angle.map_or(Sun::ANGLE, |angle| angle.0 as f32);
            Arc::new(Sun { direction: vector(direction), color, angle })
        }
        WantedLight::Rectangle(RectangleLight { at, to, up, size, color }) => {
            let usual = Rectangle::default();
            Arc::new(Rectangle {
                position: put(at),
                direction: way(at, to),
                up: up.map_or(usual.up, vector),
                size: size.map(long),
                color: color.map_or(usual.color, |color| color.0),
            })
        }
        WantedLight::Disk(DiskLight { at, to, radius, color }) => {
            let color = color.map_or(Disk::default().color, |color| color.0);
            Arc::new(Disk { position: put(at), direction: way(at, to), radius: long(radius), color })
        }
        WantedLight::Sphere(SphereLight { at, radius, color }) => {
            let color = color.map_or(Sphere::default().color, |color| color.0);
            Arc::new(Sphere { position: put(at), radius: long(radius), color })
        }
        WantedLight::Camera(CameraLight { color }) => {
            Arc::new(Head { color: color.map_or(Head::default().color, |color| color.0) })
        }
    }
}

/// A direction.
pub(super) fn vector(numbers: values::Point) -> Vec3 {
    Vec3::from(point(numbers).map(|x| x as f32))
}
