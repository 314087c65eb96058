//! One row: a scene, a kind of ray, a level; everybody traces the same rays, turn by turn.

use mobula_benches::clock;
use mobula_benches::embree::{Device, Entry, Interface, Scene};
use mobula_benches::others::Other;
use mobula_benches::packets;
use mobula_benches::rays::{Found, Kind, RaySet};
use mobula_benches::report::{Row, Spread, Way};
use mobula_benches::scenes::{Primitives, View};
use mobula_benches::verdict::{self, Verdict};
use mobula_core::bvh::Bvh;
use mobula_core::leaf::Block;
use mobula_core::simd::AnyToken;

/// What results are compared with.
pub(crate) const ONE: Interface = Interface { entry: Entry::One, coherent: false };
/// Rays that are traced between two readings of the clock: few enough to be in the cache, as if a camera or a shader had just
/// made them.
const PART: usize = 4096;
/// Mobula's packet widths.
const WIDTHS: [usize; 3] = [16, 64, 256];

/// What one row compares.
pub(crate) struct Peers<'a, B> {
    pub(crate) view: &'a View,
    pub(crate) primitives: &'a Primitives,
    pub(crate) bvh: &'a Bvh<B>,
    pub(crate) token: AnyToken,
    pub(crate) device: &'a Device,
    pub(crate) isa: &'a str,
    pub(crate) embree: &'a Scene<'a>,
    pub(crate) others: &'a [Box<dyn Other>],
    pub(crate) kind: Kind,
    pub(crate) rays: RaySet,
}

impl<B: Block> Peers<'_, B> {
    fn by_embree(&self, interface: Interface, rays: &RaySet, found: &mut Found) {
        if self.kind.any_hit() {
            self.embree.occluded(interface, rays, found);
        } else {
            self.embree.intersect(interface, rays, found);
        }
    }

    fn by_mobula(&self, width: usize, rays: &RaySet, found: &mut Found) {
        let trace = match width {
            16 => packets::trace::<16, B>,
            64 => packets::trace::<64, B>,
            _ => packets::trace::<256, B>,
        };
        trace(self.bvh, self.token, self.kind, rays, found);
    }

    /// Measures, and compares what was found.
    pub(crate) fn row(&self, repeat: usize, frequency: f64) -> Row {
        let count = self.rays.len();
        let parts = self.rays.parts(PART);
        let mut found = Found::new(PART);
        let mut cycles = |work: &dyn Fn(&RaySet, &mut Found)| {
            let mut seconds = 0.0;
            for part in &parts {
                part.touch();
                seconds += clock::time(|| work(part, &mut found)).1.thread;
            }
            seconds * frequency / count.max(1) as f64
        };
        let mut tried: Vec<(Interface, f64)> = Interface::all()
            .filter(|&interface| self.device.is_native(interface))
            .map(|interface| (interface, cycles(&|rays, found| self.by_embree(interface, rays, found))))
            .collect();
        tried.sort_by(|a, b| a.1.total_cmp(&b.1));
        // Those that one trial cannot tell from the best.
        let close = tried.iter().filter(|(_, cycles)| *cycles < 1.25 * tried[0].1).take(3);
        let candidates: Vec<Interface> = close.map(|&(interface, _)| interface).collect();
        let mut by_embree: Vec<Vec<f64>> = vec![Vec::new(); candidates.len()];
        let mut by_mobula: [Vec<f64>; 3] = Default::default();
        let mut by_others: Vec<Vec<f64>> = vec![Vec::new(); self.others.len()];
        for _ in 0..repeat {
            for at in 0..candidates.len().max(WIDTHS.len()) {
                if let (Some(times), Some(&width)) = (by_mobula.get_mut(at), WIDTHS.get(at)) {
                    times.push(cycles(&|rays, found| self.by_mobula(width, rays, found)));
                }
                if let (Some(times), Some(&interface)) = (by_embree.get_mut(at), candidates.get(at)) {
                    times.push(cycles(&|rays, found| self.by_embree(interface, rays, found)));
                }
            }
            for (times, other) in by_others.iter_mut().zip(self.others) {
                times.push(cycles(&|rays, found| other.trace(self.kind, rays, found)));
            }
        }
        let median = |times: &Vec<f64>| Spread::of(times.iter().copied()).median;
        let best = by_embree.iter().min_by(|a, b| median(a).total_cmp(&median(b)));
        let best = best.cloned().unwrap_or_default();
        let way = |(name, times): (String, &Vec<f64>)| Way {
            name,
            cycles: Spread::of(times.iter().copied()),
            ratio: Spread::of(best.iter().zip(times).map(|(embree, other)| embree / other)),
        };
        let names = candidates.iter().map(Interface::to_string);
        let mut embree: Vec<Way> = names.zip(&by_embree).map(way).collect();
        embree.sort_by(|a, b| a.cycles.median.total_cmp(&b.cycles.median));
        Row {
            scene: self.view.name.into(),
            shape: self.primitives.shape(),
            primitives: self.primitives.len(),
            level: self.token.level().to_string(),
            isa: self.isa.into(),
            kind: self.kind,
            rays: count,
            mobula: WIDTHS.map(|width| width.to_string()).into_iter().zip(&by_mobula).map(way).collect(),
            embree,
            tried: tried.iter().map(|(interface, cycles)| (interface.to_string(), *cycles)).collect(),
            others: self.others.iter().map(|other| other.name().to_string()).zip(&by_others).map(way).collect(),
            verdict: self.verdict(),
        }
    }

    /// Compares Embree's single rays with Mobula's packets of 64, and these with its other widths, which must agree.
    fn verdict(&self) -> Verdict {
        let mut found = WIDTHS.map(|_| Found::new(self.rays.len()));
        for (found, width) in found.iter_mut().zip(WIDTHS) {
            self.by_mobula(width, &self.rays, found);
        }
        let [narrow, ours, wide] = &found;
        for other in [narrow, wide] {
            let same =
                |i: usize| ours.t[i].to_bits() == other.t[i].to_bits() && ours.primitive[i] == other.primitive[i];
            let different = (0..self.rays.len()).filter(|&i| !same(i)).count();
            assert!(different == 0, "{} {}: widths differ in {different} rays", self.view.name, self.kind.name());
        }
        self.beside_embree(ours, &|ray, found| {
            packets::trace::<1, B>(self.bvh, self.token, Kind::Diffuse, ray, found);
        })
    }

    /// Compares what one of the other peers finds with Embree's single rays.
    pub(crate) fn verdict_of(&self, other: &dyn Other) -> Verdict {
        let mut found = Found::new(self.rays.len());
        other.trace(self.kind, &self.rays, &mut found);
        self.beside_embree(&found, &|ray, found| other.trace(Kind::Diffuse, ray, found))
    }

    /// `closest` says what is in the way of a ray, if only that is known.
    fn beside_embree(&self, theirs: &Found, closest: &dyn Fn(&RaySet, &mut Found)) -> Verdict {
        let mut embree = Found::new(self.rays.len());
        self.by_embree(ONE, &self.rays, &mut embree);
        let blocker = |i: usize, trace: &dyn Fn(&RaySet, &mut Found)| {
            let ((origin, direction), mut ray, mut found) = (self.rays.ray(i), RaySet::default(), Found::new(1));
            ray.push(origin, direction, self.rays.t_max[i]);
            trace(&ray, &mut found);
            (found.primitive[0], found.t[0])
        };
        let embree_blocker = |i| blocker(i, &|ray, found| self.embree.intersect(ONE, ray, found));
        let their_blocker = |i| blocker(i, closest);
        let blockers: [verdict::Blocker<'_>; 2] = [&embree_blocker, &their_blocker];
        verdict::compare(self.primitives, &self.rays, [&embree, theirs], self.kind.any_hit(), blockers)
    }
}
