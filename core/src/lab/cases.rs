//! The cases of a kernel: drawn ones, that keep what it needs to know of the rays, and the one that is timed.

use alloc::vec::Vec;

use super::{Dice, Draft, DraftRay, Kernel, Style};
use crate::Properties;

/// Draws a case of `width` rays that keeps the promises of `K`: of every style, most rays aimed at something.
pub(super) fn draw<K: Kernel>(dice: &mut Dice<'_>, width: usize) -> Draft<K::Primitive> {
    dice.draw_style();
    let count = 1 + dice.below(5);
    let mut primitives: Vec<K::Primitive> = (0..count).map(|_| K::draw(dice)).collect();
    K::number(&mut primitives);
    if dice.one_in(2) {
        dice.draw_style();
    }
    let range = if dice.one_in(2) {
        let begin = dice.below(width + 1);
        begin..begin + dice.below(width - begin + 1)
    } else {
        0..width
    };
    let common = dice.point();
    let limited = dice.one_in(3);
    let rays = (0..width).map(|_| {
        let origin = if K::PROMISES.contains(Properties::COMMON_ORIGIN) { common } else { dice.point() };
        let mut direction = dice.point();
        if !dice.one_in(4) {
            let at = dice.below(count);
            let target = K::aim(dice, &primitives[at]);
            for axis in 0..3 {
                direction[axis] = target[axis] - origin[axis];
            }
        }
        let (t_min, t_max) = if limited { (dice.value(), dice.value()) } else { (0.0, f32::INFINITY) };
        DraftRay { origin, direction, t_min, t_max }
    });
    let mut draft = Draft { rays: rays.collect(), range, primitives, promises: K::PROMISES };
    draft.keep_promises(K::PARALLEL);
    draft
}

/// What kernels are timed on: the packet of a pinhole camera, and small primitives of which it misses most.
pub(super) fn timed<K: Kernel>(width: usize) -> Draft<K::Primitive> {
    let mut dice = Dice::from_seed(2006);
    dice.set_style(Style::Ordinary);
    let mut primitives: Vec<K::Primitive> = (0..K::PRIMITIVES).map(|_| K::draw(&mut dice)).collect();
    K::number(&mut primitives);
    let side = (1..=width).find(|side| side * side >= width).unwrap_or(1);
    let ray = |i| {
        let (x, y) = ((i % side) as f32, (i / side) as f32);
        let direction = [-0.25 + 0.01 * x, -0.2 + 0.01 * y, -1.0];
        DraftRay { origin: [0.1, 0.2, 3.0], direction, t_min: 0.0, t_max: f32::INFINITY }
    };
    let rays = (0..width).map(ray).collect();
    let mut draft = Draft { rays, range: 0..width, primitives, promises: K::PROMISES };
    K::timed(&mut draft);
    draft.keep_promises(K::PARALLEL);
    draft
}
