//! How a viewer changes which particles are shown, and in which colours.

use super::news::Titles;
use super::screen::Screen;
use super::volumes::rounded;
use crate::app::{ShownAttribute, ShownParticles, State};
use crate::display::{Sheet, legend};
use crate::load::Changes;
use crate::pipeline::Handle;
use crate::scene::Map;
use crate::volume::Preset;

/// What was asked for, which the state has or is about to have.
pub(super) struct ParticleControls {
    shown: Option<ShownParticles>,
    first: Option<ShownParticles>,
    /// What decided about colours at first, in words of the command line.
    coloring: String,
    /// Has that been changed, and to which map?
    recolored: bool,
    map: Option<Preset>,
    /// Do the keys for values move particles where there are media, too?
    pub(super) in_hand: bool,
}

impl ParticleControls {
    /// For the particles of a state.
    pub(super) fn new(state: &State, titles: &Titles) -> Self {
        let shown = state.particles();
        let (first, coloring) = (shown.clone(), titles.coloring.clone());
        Self { shown, first, coloring, recolored: false, map: None, in_hand: false }
    }

    /// The attribute that decides about colours.
    fn attribute(&mut self) -> Option<&mut ShownAttribute> {
        let shown = self.shown.as_mut()?;
        shown.attributes.get_mut(shown.color_by?)
    }

    /// Moves the middle and the width of the values that are shown by so many steps, each a 64th: of the range, and of the width. Says
    /// whether there are any.
    pub(super) fn move_crop(&mut self, [level_by, width_by]: [f64; 2], handle: &Handle<State>) -> bool {
        let Some(ShownAttribute { name, range, shown: Some(shown) }) = self.attribute() else { return false };
        let [low, high] = range.map(f64::from);
        let [from, to] = shown.map(|end| f64::from(end).clamp(low, high));
        let (whole, precise) = (high - low, (high - low) / 10_000.0);
        let half = (((to - from) * (1.0 + 1.0 / 64.0_f64).powf(width_by * 2.0)).clamp(precise, 1.1 * whole)) / 2.0;
        let middle = ((from + to) / 2.0 + level_by * whole / 64.0).clamp(low, high);
        *shown = [middle - half, middle + half].map(|end| rounded(end, precise) as f32);
        let (name, shown) = (name.clone(), *shown);
        handle.send("crop", move |state| state.set_crop(&name, shown));
        true
    }

    /// Colours by the next attribute, as goes with it.
    pub(super) fn next_attribute(&mut self, handle: &Handle<State>, screen: &Screen) {
        let Some(shown) = self.shown.as_mut().filter(|shown| !shown.attributes.is_empty()) else { return };
        shown.color_by = Some(shown.color_by.map_or(0, |at| (at + 1) % shown.attributes.len()));
        self.map = None;
        self.recolor(handle, screen);
    }

    /// The next colour map by name.
    pub(super) fn next_map(&mut self, handle: &Handle<State>, screen: &Screen) {
        if self.attribute().is_none() {
            return;
        }
        let all: Vec<Preset> = Preset::ALL.iter().copied().filter(|preset| !preset.is_lit()).collect();
        let at = all.iter().position(|preset| Some(*preset) == self.map);
        self.map = Some(all[at.map_or(0, |at| (at + 1) % all.len())]);
        self.recolor(handle, screen);
    }

    fn recolor(&mut self, handle: &Handle<State>, screen: &Screen) {
        self.recolored = true;
        let map = self.map.map(Map::Preset);
        let (Some(name), screen) = (self.attribute().map(|attribute| attribute.name.clone()), screen.clone()) else {
            return;
        };
        handle.send("colours", move |state| {
            state.color_particles(&name, map.as_ref());
            screen.lock().legend = legend_of(state);
        });
    }

    /// Attributes whose shown values were changed, with these.
    fn cropped(&self) -> impl Iterator<Item = (&ShownAttribute, [f32; 2])> {
        let both =
            self.shown.iter().zip(&self.first).flat_map(|(now, first)| now.attributes.iter().zip(&first.attributes));
        both.filter(|(now, first)| now.shown != first.shown).filter_map(|(now, _)| Some((now, now.shown?)))
    }

    /// The attribute that decides about colours, and the name of the map if it has another than goes with it; if that was changed.
    fn color(&self) -> Option<(String, Option<String>)> {
        let shown = self.shown.as_ref().filter(|_| self.recolored)?;
        let name = shown.attributes[shown.color_by?].name.clone();
        Some((name, self.map.map(|map| map.name().to_owned())))
    }

    /// What the title says.
    pub(super) fn title(&self) -> String {
        let mut text = String::new();
        if let Some((name, map)) = self.color() {
            text += &format!(", coloured by {name}");
            text.extend(map.map(|map| format!(" ({map})")));
        }
        for (ShownAttribute { name, range, .. }, shown) in self.cropped() {
            let [low, high] = shown.map(|end| rounded(f64::from(end), f64::from(range[1] - range[0]) / 1000.0));
            text += &format!(", {name} {low} to {high}");
        }
        if self.in_hand {
            text += ", keys move particles";
        }
        text
    }

    /// Says what is not as at first.
    pub(super) fn tell(&self, changes: &mut Changes) {
        changes.crops = self.cropped().map(|(attribute, shown)| (attribute.name.clone(), shown)).collect();
        changes.color = self.color();
    }

    /// What makes the same on the command line.
    pub(super) fn options(&self, quoted: impl Fn(&str) -> String) -> String {
        let mut text = match self.color() {
            None => self.coloring.clone(),
            Some((name, map)) => {
                let map = map.map(|map| format!(" --map {}", quoted(&map)));
                format!(" --color-by {}{}", quoted(&name), map.unwrap_or_default())
            }
        };
        for (ShownAttribute { name, .. }, [low, high]) in self.cropped() {
            text += &format!(" --crop {}", quoted(&format!("{name}={low},{high}")));
        }
        text
    }
}

/// What colours mean, if they mean something.
pub(super) fn legend_of(state: &State) -> Option<Sheet> {
    let list = state.stack.scene.geometry.list();
    list.iter().filter_map(|one| one.downcast_ref()).find_map(legend)
}
