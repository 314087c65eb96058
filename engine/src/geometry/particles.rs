//! Particles over time: spheres, of which those are shown whose attributes have certain values, in colours that go by an attribute.
//!
//! Steps of time, crops and colours may change with each frame; nothing is built for it.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::cloud::{Crop, Crops};
use mobula_core::simd::AnyToken;
use mobula_core::sink;
use mobula_core::traverse::{self, Paths};
use mobula_core::{AnyHitPacket, RayPacket};

use super::ball;
use super::cloud::Cloud;
use super::cloud_series::CloudSeries;
use super::opacity::{Opacity, OpacityCurve};
use super::{Census, Geometry, Structure, shift_material};
use crate::accel::{AccelerationKind, Build};
use crate::packet::{Hits, Intersect, Surface, set_vec3, vec3};
use crate::particles::{Attribute, ParticleStep, Values};
use crate::volume::{ColorMap, Preset};

/// Particles, of which one step of time is shown.
#[derive(Clone, Debug)]
pub struct Particles {
    /// What people call them.
    pub name: String,
    /// The index of their material.
    pub material: u32,
    /// What is shown: only what all of these leave.
    pub crops: Vec<Cropping>,
    /// Their colours, by which those of the material are multiplied.
    pub coloring: Option<Coloring>,
    /// How opaque they are, by which the opacity of the material is multiplied.
    pub opacity: Opacity,
    series: Arc<CloudSeries>,
    /// Some particles of all steps, with their radii.
    reach: Arc<[(Vec3, f32)]>,
    step: usize,
    cloud: Arc<Cloud>,
}

/// Which particles are shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Cropping {
    /// The name of the attribute that it goes by; where there is none, no particle is shown.
    pub attribute: String,
    /// From the least to the greatest value that is shown, both included; any number of times.
    pub ranges: Vec<[f32; 2]>,
}

/// Colours by an attribute.
#[derive(Clone, Debug)]
pub struct Coloring {
    /// The name of the attribute; where there is none, particles are grey.
    pub attribute: String,
    /// The colours of its values.
    pub map: Arc<ColorMap>,
}

impl Particles {
    /// These steps, the first of them shown.
    ///
    /// # Panics
    /// If there are none.
    pub fn new(name: impl Into<String>, steps: Vec<Arc<Cloud>>, material: u32) -> Self {
        let series = Arc::new(CloudSeries::new(steps));
        Self::of_series(name, series, 0, material).expect("all steps are in memory")
    }

    /// Those of a series, of which a step is shown, if it is in memory.
    pub fn of_series(name: impl Into<String>, series: Arc<CloudSeries>, step: usize, material: u32) -> Option<Self> {
        let (cloud, step) = (series.get(step)?, step % series.len());
        let (name, opacity) = (name.into(), Opacity::All(1.0));
        let reach = reach(&series.in_memory()).into();
        Some(Self { name, material, crops: Vec::new(), coloring: None, opacity, series, reach, step, cloud })
    }

    /// With other particles that show how far those of all steps reach, with their radii: otherwise these are some of each step in
    /// memory.
    pub fn reaching(self, reach: Vec<(Vec3, f32)>) -> Self {
        Self { reach: reach.into(), ..self }
    }

    /// A spiral that is coloured along its way, and more and more opaque, with a part of it left out.
    pub fn example(material: u32) -> Self {
        let count = 40;
        let part = |i: usize| i as f32 / count as f32;
        let center = |i: usize| {
            let angle = 9.0 * part(i);
            [0.6 * angle.cos() * (1.0 - part(i)), 1.4 * part(i) - 0.7, 0.6 * angle.sin() * (1.0 - part(i))]
        };
        let values = Values::F32((0..count).map(part).collect());
        let step = ParticleStep {
            centers: (0..count).map(center).collect(),
            radii: (0..count).map(|i| 0.05 + 0.1 * part(i)).collect(),
            attributes: vec![Attribute { name: "way".to_owned(), values }],
            ..ParticleStep::default()
        };
        let cloud = Cloud::new(step, 0.1, &AccelerationKind::Bvh.into()).expect("few particles");
        let map = ColorMap::new(&Preset::Viridis.function([0.0, 1.0]), [0.0, 1.0]);
        Self {
            crops: vec![Cropping { attribute: "way".to_owned(), ranges: vec![[0.0, 0.4], [0.5, 1.0]] }],
            coloring: Some(Coloring { attribute: "way".to_owned(), map: Arc::new(map) }),
            opacity: Opacity::By {
                attribute: "way".to_owned(),
                curve: OpacityCurve::new(vec![[0.0, 0.3], [0.9, 1.0]]).expect("opacities"),
            },
            ..Self::new("spiral", vec![Arc::new(cloud)], material)
        }
    }

    /// With this step shown, if it is in memory; behind the last comes the first.
    pub fn at(&self, step: usize) -> Option<Self> {
        let cloud = self.series.get(step)?;
        Some(Self { step: step % self.series.len(), cloud, ..self.clone() })
    }

    /// With only those shown whose value of an attribute is in a range, beside what other attributes say.
    pub fn cropped(&self, attribute: &str, range: [f32; 2]) -> Self {
        let mut cropped = self.clone();
        cropped.crops.retain(|crop| crop.attribute != attribute);
        cropped.crops.push(Cropping { attribute: attribute.to_owned(), ranges: vec![range] });
        cropped
    }

    /// What is shown.
    pub fn cloud(&self) -> &Arc<Cloud> {
        &self.cloud
    }

    /// Which step is shown, from 0.
    pub fn step(&self) -> usize {
        self.step
    }

    /// All steps.
    pub fn series(&self) -> &Arc<CloudSeries> {
        &self.series
    }

    /// The least and the greatest value of an attribute in all steps that are in memory.
    pub fn range(&self, attribute: &str) -> Option<[f32; 2]> {
        let of = |cloud: &Arc<Cloud>| cloud.range(cloud.attribute(attribute)?);
        self.series.in_memory().iter().filter_map(of).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    /// Which values an attribute of whole numbers has in the step that is shown; `None` if it is of another type.
    pub fn kinds(&self, attribute: &str) -> Option<Vec<u8>> {
        let number = self.cloud().attribute(attribute)?;
        self.cloud().spheres.kinds(number)
    }

    /// What finds the hits.
    fn finder(&self) -> Finder {
        let cloud = self.cloud().clone();
        let crop = |Cropping { attribute, ranges }: &Cropping| Crop {
            attribute: cloud.attribute(attribute).unwrap_or(usize::MAX),
            ranges: ranges.clone(),
        };
        let mut crops: Vec<Crop> = self.crops.iter().map(crop).collect();
        if let Opacity::By { attribute, curve } = &self.opacity {
            // What is wholly transparent is not there.
            crops.push(crop(&Cropping { attribute: attribute.clone(), ranges: curve.visible() }));
        }
        let crops = cloud.spheres.crops(&crops);
        Finder { crops, cloud }
    }
}

impl Geometry for Particles {
    fn name(&self) -> &str {
        &self.name
    }

    /// At least one: a step without particles may be followed by others.
    fn primitives(&self) -> usize {
        self.cloud.spheres.places().max(1)
    }

    fn census(&self) -> Census {
        let mut census = self.cloud().census().clone();
        // A step outwards, as those of each step are.
        for &(center, radius) in &*self.reach {
            census.include((center - radius).map(f32::next_down), 0.0);
            census.include((center + radius).map(f32::next_up), 0.0);
        }
        census
    }

    /// Of all steps: what is seen of the first is not to leave the picture with the second.
    fn extremes(&self, visit: &mut dyn FnMut(Vec3)) {
        for &(center, radius) in &*self.reach {
            for axis in Vec3::AXES {
                visit(center + axis * radius);
                visit(center - axis * radius);
            }
        }
    }

    fn materials(&self, _: &[u32], _: &mut [u32]) -> Option<u32> {
        Some(self.material)
    }

    fn is_translucent(&self) -> bool {
        self.opacity.is_translucent()
    }

    fn opacity(&self, primitive: u32) -> f32 {
        match &self.opacity {
            Opacity::All(opacity) => *opacity,
            Opacity::By { attribute, curve } => {
                let attribute = self.cloud().attribute(attribute).unwrap_or(usize::MAX);
                curve.opacity(self.cloud().spheres.value(attribute, primitive as usize))
            }
        }
    }

    fn shift_materials(mut self: Arc<Self>, shift: u32) -> Arc<dyn Geometry> {
        shift_material(&mut Arc::make_mut(&mut self).material, shift);
        self
    }

    fn shares_structure(&self) -> bool {
        false
    }

    fn structure(&self, _members: &[Arc<dyn Geometry>], _build: &Build) -> Box<dyn Structure> {
        Box::new(self.finder())
    }
}

impl Surface for Particles {
    fn geometric_normals(&self, hits: &Hits<'_>, out: [&mut [f32]; 3], error_scales: &mut [f32]) {
        ball::normals(hits, out, error_scales, |place| self.cloud().sphere(place));
    }

    fn texture_coordinates(&self, hits: &Hits<'_>, out: [&mut [f32]; 3]) {
        ball::texture_coordinates(hits, out, |place| self.cloud().sphere(place));
    }

    fn derivatives(&self, hits: &Hits<'_>, out: [[&mut [f32]; 3]; 2]) {
        ball::derivatives(hits, out, |place| self.cloud().sphere(place));
    }

    fn colors(&self, hits: &Hits<'_>, mut out: [&mut [f32]; 3]) -> bool {
        let Some(Coloring { attribute, map }) = &self.coloring else { return false };
        let attribute = self.cloud().attribute(attribute).unwrap_or(usize::MAX);
        for (i, &place) in hits.primitives.iter().enumerate() {
            set_vec3(&mut out, i, map.color(self.cloud().spheres.value(attribute, place as usize)).into());
        }
        true
    }

    /// A sphere that is not opaque counts once, where rays enter it, as it does for those to lights.
    fn opacities(&self, hits: &Hits<'_>, out: &mut [f32]) -> bool {
        if !self.is_translucent() {
            return false;
        }
        for (i, (&place, out)) in hits.primitives.iter().zip(out).enumerate() {
            let (center, _) = self.cloud().sphere(place as usize).unwrap_or_default();
            let leaves = (hits.position(i) - center).dot(vec3(&hits.directions, i)) > 0.0;
            let opacity = self.opacity(place);
            *out = if leaves && opacity < 1.0 { 0.0 } else { opacity };
        }
        true
    }
}

/// Some particles of steps, with their radii.
fn reach(steps: &[Arc<Cloud>]) -> Vec<(Vec3, f32)> {
    /// So many at most of each step.
    const MANY: usize = 1000;
    let of = |cloud: &Arc<Cloud>| {
        let places = cloud.spheres.places();
        let (low, high) = cloud.census().bounds;
        let ends = if low.cmple(high).all() { vec![(low, 0.0), (high, 0.0)] } else { Vec::new() };
        let some = (0..places).step_by(places.div_ceil(MANY).max(1)).filter_map(|place| cloud.sphere(place));
        some.chain(ends).collect::<Vec<_>>()
    };
    steps.iter().flat_map(of).collect()
}

/// Finds the hits of particles.
#[derive(Debug)]
struct Finder {
    cloud: Arc<Cloud>,
    crops: Crops,
}

impl<const N: usize> Intersect<N> for Finder {
    fn intersect(&self, token: AnyToken, packet: &mut RayPacket<N>) -> Paths {
        let tree = self.cloud.spheres.shown(&self.crops);
        let walk = if self.cloud.all { traverse::intersect_all } else { traverse::intersect };
        walk(&tree, token, packet)
    }

    fn occlude(&self, token: AnyToken, packet: &mut AnyHitPacket<N>, opacity: Option<&dyn sink::Opacity>) -> Paths {
        let tree = self.cloud.spheres.shown(&self.crops);
        let walk = if self.cloud.all { traverse::occlude_all } else { traverse::occlude };
        walk(&tree, token, packet, opacity)
    }
}

impl Structure for Finder {
    fn primitives(&self) -> usize {
        self.cloud.spheres.len()
    }

    fn bytes(&self) -> usize {
        self.cloud.bytes()
    }

    fn can_refit(&self, members: &[Arc<dyn Geometry>]) -> bool {
        members.len() == 1 && members[0].downcast_ref::<Particles>().is_some()
    }

    /// Another step of time, other crops, other colours: nothing has to be built.
    fn refit(&mut self, members: &[Arc<dyn Geometry>]) {
        if let Some(new) = members.first().and_then(|member| member.downcast_ref::<Particles>()) {
            *self = new.finder();
        }
    }
}
