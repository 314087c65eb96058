//! What transactions change of how volumes and particles are shown.

use std::sync::Arc;

use super::State;
use crate::geometry::{Geometry, IsoSurfaces, MeshSequence, Particles};
use crate::medium::{Between, Volume};
use crate::volume::TransferFunction;

/// How the volumes and particles of a scene are shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Volumes {
    /// The values of the iso-surfaces, and the range that they are in; none if there are none, or those of several volumes differ.
    pub iso: Option<(Vec<f64>, [f64; 2])>,
    /// Level and width of the media, and the range of their values; none if there are none, or those of several volumes differ.
    pub window: Option<([f64; 2], [f64; 2])>,
    /// The step of time, from 0.
    pub step: usize,
    /// The steps of that volume, mesh, or those particles, that have most of them; 0 if there are none.
    pub steps: usize,
}

impl State {
    /// How the volumes are shown.
    pub fn volumes(&self) -> Volumes {
        let scene = &self.stack.scene;
        let surfaces = || scene.geometry.list().iter().filter_map(|one| one.downcast_ref::<IsoSurfaces>());
        let media = || scene.media.iter().filter_map(|one| one.downcast_ref::<Volume>());
        let iso = surfaces().next().filter(|first| surfaces().all(|other| other.values == first.values));
        let window = media().next().filter(|first| media().all(|other| other.window() == first.window()));
        let series = surfaces().map(|one| &one.series).chain(media().map(Volume::series));
        let particles = || scene.geometry.list().iter().filter_map(|one| one.downcast_ref::<Particles>());
        let steps = series.map(|series| (series.steps(), series.step()));
        let meshes = scene.geometry.list().iter().filter_map(|one| one.downcast_ref::<MeshSequence>());
        let (steps, step) = steps
            .chain(particles().map(|one| (one.series().len(), one.step())))
            .chain(meshes.map(|one| (one.steps().len(), one.step())))
            .max()
            .unwrap_or_default();
        Volumes {
            iso: iso.map(|first| (first.values.clone(), first.series.range())),
            window: window.map(|first| (first.window(), first.series().range())),
            step,
            steps,
        }
    }

    /// Gives all iso-surfaces these values, where there are as many. Nothing has to be built.
    pub fn set_iso_values(&mut self, values: &[f64]) {
        self.change_geometry(|surfaces: &IsoSurfaces| {
            let as_many = surfaces.values.len() == values.len();
            as_many.then(|| IsoSurfaces { values: values.to_vec(), ..surfaces.clone() })
        });
    }

    /// Gives all media of volumes this level and width: see [`Volume::with_window`].
    pub fn set_window(&mut self, window: [f64; 2]) {
        self.change_media(|volume| volume.with_window(window));
    }

    /// Gives all media of volumes a transfer function for their range.
    pub fn set_transfer(&mut self, function: impl Fn([f64; 2]) -> TransferFunction, lit: bool) {
        self.change_media(|volume| {
            let mut changed = volume.with_function(Arc::new(function(volume.series().range())));
            (changed.lit, changed.between) = (lit, Between::Linear);
            changed
        });
    }

    /// Shows all volumes, particles and meshes at a step of time; behind the last comes the first. Structures over meshes that change with
    /// time are refitted, for all else nothing has to be built. Particles whose step is not in memory stay as they are: see
    /// [`Streamer`](super::Streamer).
    pub fn set_step(&mut self, step: usize) {
        self.change_geometry(|surfaces: &IsoSurfaces| {
            Some(IsoSurfaces { series: surfaces.series.at(step), ..surfaces.clone() })
        });
        self.change_geometry(|particles: &Particles| particles.at(step));
        self.change_geometry(|meshes: &MeshSequence| Some(meshes.at(step)));
        self.change_media(|volume| volume.at(step));
    }

    /// Shows only particles whose value of an attribute is in a range. Nothing has to be built.
    pub fn set_crop(&mut self, attribute: &str, range: [f32; 2]) {
        self.change_geometry(|particles: &Particles| {
            particles.cloud().attribute(attribute).map(|_| particles.cropped(attribute, range))
        });
    }

    pub(super) fn change_geometry<G: Geometry>(&mut self, change: impl Fn(&G) -> Option<G>) {
        let geometry = &mut self.stack.scene.geometry;
        if !geometry.list().iter().any(|one| one.downcast_ref::<G>().is_some()) {
            return;
        }
        let changed = |one: &Arc<dyn Geometry>| match one.downcast_ref::<G>().and_then(&change) {
            Some(changed) => Arc::new(changed),
            None => Arc::clone(one),
        };
        let list = geometry.list().iter().map(changed).collect();
        let refitted = geometry.follow(list);
        debug_assert!(refitted.is_ok(), "the primitives are the same");
    }

    fn change_media(&mut self, change: impl Fn(&Volume) -> Volume) {
        for medium in &mut self.stack.scene.media {
            if let Some(volume) = medium.downcast_ref::<Volume>() {
                *medium = Arc::new(change(volume));
            }
        }
    }
}
