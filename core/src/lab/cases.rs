//! The cases of a kernel: drawn ones, that keep what it needs to know of the rays, and the one that is timed.

use alloc::vec::Vec;

use super::table::Table;
use super::{Dice, Draft, DraftRay, Style};
use crate::Properties;

/// Draws a case of `width` rays that keeps the promises of a kernel: of every style, most rays aimed at something.
pub(super) fn draw<P>(kernel: &Table<P>, dice: &mut Dice<'_>, width: usize) -> Draft<P> {
    dice.draw_style();
    let count = 1 + dice.below(5);
    let mut primitives: Vec<P> = (0..count).map(|_| (kernel.draw)(dice)).collect();
    (kernel.number)(&mut primitives);
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
        let origin = if kernel.promises.contains(Properties::COMMON_ORIGIN) { common } else { dice.point() };
        let mut direction = dice.point();
        if !dice.one_in(4) {
            let at = dice.below(count);
            let target = (kernel.aim)(dice, &primitives[at]);
            for axis in 0..3 {
                direction[axis] = target[axis] - origin[axis];
            }
        }
        let (t_min, t_max) = if limited { (dice.value(), dice.value()) } else { (0.0, f32::INFINITY) };
        DraftRay { origin, direction, t_min, t_max }
    });
    let mut draft = Draft { rays: rays.collect(), range, primitives, promises: kernel.promises };
    draft.keep_promises(kernel.parallel);
    draft
}

/// What kernels are timed on: the packet of a pinhole camera, and small primitives of which it misses most.
pub(super) fn timed<P>(kernel: &Table<P>, width: usize) -> Draft<P> {
    let mut dice = Dice::from_seed(2006);
    dice.set_style(Style::Ordinary);
    let mut primitives: Vec<P> = (0..kernel.count).map(|_| (kernel.draw)(&mut dice)).collect();
    (kernel.number)(&mut primitives);
    let side = (1..=width).find(|side| side * side >= width).unwrap_or(1);
    let ray = |i| {
        let (x, y) = ((i % side) as f32, (i / side) as f32);
        let direction = [-0.25 + 0.01 * x, -0.2 + 0.01 * y, -1.0];
        DraftRay { origin: [0.1, 0.2, 3.0], direction, t_min: 0.0, t_max: f32::INFINITY }
    };
    let rays = (0..width).map(ray).collect();
    let mut draft = Draft { rays, range: 0..width, primitives, promises: kernel.promises };
    (kernel.timed)(&mut draft);
    draft.keep_promises(kernel.parallel);
    draft
}
