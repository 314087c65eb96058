//! The frame buffers: one for each stage and channel, handed on from stage to stage at the barrier.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.2 ("one frame buffer is associated with each stage").

use std::time::Duration;

use super::channel::Channel;
use super::stage::{StageBuffer, View};
use crate::image::Size;

/// Which frame a stage works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stamp {
    pub(super) number: u64,
    pub(super) time: Duration,
    pub(super) changed: bool,
}

struct Slot<B> {
    size: Size,
    /// The last frame that was rendered into the buffer.
    holds: Option<u64>,
    /// None before the first frame: there may be no memory for it, which ends a run.
    buffer: Option<B>,
}

/// All buffers of a pipeline. Stage 0 gets the buffer that the last stage is done with.
pub(super) struct Buffers<B> {
    /// By stage, then by channel.
    slots: Vec<Vec<Slot<B>>>,
    /// The frame of each stage; none before the first frame has come through, and when there is none to render.
    stamps: Vec<Option<Stamp>>,
    /// For each channel, the stage that has the picture before the one in stage 0.
    previous: Vec<Option<usize>>,
}

impl<B: StageBuffer> Buffers<B> {
    pub(super) fn new() -> Self {
        Self { slots: Vec::new(), stamps: Vec::new(), previous: Vec::new() }
    }

    pub(super) fn add_stage(&mut self, channels: &[Channel]) {
        self.slots.push(channels.iter().map(|_| Slot::new()).collect());
        self.stamps.push(None);
    }

    pub(super) fn add_channel(&mut self) {
        self.slots.iter_mut().for_each(|stage| stage.push(Slot::new()));
    }

    pub(super) fn stamp(&self, stage: usize) -> Option<Stamp> {
        self.stamps.get(stage).copied().flatten()
    }

    /// Whether frames are on their way through the later stages.
    pub(super) fn in_flight(&self) -> bool {
        self.stamps.iter().skip(1).any(Option::is_some)
    }

    /// Hands each buffer on to the next stage. Stage 0 has no frame then.
    pub(super) fn rotate(&mut self) {
        if !self.slots.is_empty() {
            self.slots.rotate_right(1);
            self.stamps.rotate_right(1);
            self.stamps[0] = None;
        }
    }

    /// Forgets the frames on their way, after a run that ended early. What stage 0 has is not finished: it is no picture.
    pub(super) fn forget(&mut self) {
        if let (Some(Some(_)), Some(slots)) = (self.stamps.first(), self.slots.first_mut()) {
            slots.iter_mut().for_each(|slot| slot.holds = None);
        }
        self.stamps.fill(None);
    }

    /// Makes stage 0 ready for a new frame.
    pub(super) fn begin(&mut self, stamp: Stamp, channels: &[Channel]) {
        if self.slots.is_empty() {
            return;
        }
        self.stamps[0] = Some(stamp);
        self.previous.clear();
        for (index, channel) in channels.iter().enumerate() {
            // The newest picture of this size, wherever it is.
            let newest = (0..self.slots.len())
                .filter(|&stage| self.slots[stage][index].size == channel.size)
                .filter_map(|stage| self.slots[stage][index].holds.map(|frame| (frame, stage)))
                .max();
            self.previous.push(newest.map(|(_, stage)| stage));
            let slot = &mut self.slots[0][index];
            // A channel that was removed keeps no more memory than it must.
            let size = if channel.open { channel.size } else { Size::SMALLEST };
            if slot.size != size || slot.buffer.is_none() {
                // The old one first: there may be no room for both.
                *slot = Slot::new();
                (slot.buffer, slot.size) = (Some(B::for_size(size)), size);
            }
            slot.holds = channel.open.then_some(stamp.number);
        }
    }

    /// What a stage sees of the frame it works on: the channels that took part in it.
    pub(super) fn views<'a>(&'a self, stage: usize, channels: &'a [Channel]) -> Vec<View<'a, B>> {
        let Some(stamp) = self.stamp(stage) else { return Vec::new() };
        let takes_part = |slot: &&Slot<B>| slot.holds == Some(stamp.number);
        let slots = self.slots[stage].iter().zip(channels).enumerate();
        let view = |(index, (slot, channel)): (usize, (&'a Slot<B>, &'a Channel))| {
            let buffer = Some(slot).filter(takes_part)?.buffer.as_ref()?;
            Some(View { index, channel, size: slot.size, buffer, previous: self.previous_of(stage, index) })
        };
        slots.filter_map(view).collect()
    }

    fn previous_of(&self, stage: usize, channel: usize) -> Option<&B> {
        let source = if stage == 0 { *self.previous.get(channel)? } else { None };
        self.slots[source?][channel].buffer.as_ref()
    }

    /// The newest picture of a channel and its frame.
    pub(super) fn newest(&self, channel: usize) -> Option<(u64, &B)> {
        let slots = self.slots.iter().filter_map(|stage| stage.get(channel));
        slots.filter_map(|slot| Some((slot.holds?, slot.buffer.as_ref()?))).max_by_key(|newest| newest.0)
    }
}

impl<B> Slot<B> {
    fn new() -> Self {
        Self { size: Size::SMALLEST, holds: None, buffer: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl StageBuffer for Size {
        fn for_size(size: Size) -> Self {
            size
        }
    }

    fn stamp(number: u64) -> Stamp {
        Stamp { number, time: Duration::ZERO, changed: true }
    }

    #[test]
    fn a_frame_passes_through_all_stages() {
        let small = Size::new(2, 2).unwrap();
        let channels = [Channel { name: "one".into(), size: small, open: true }];
        let mut buffers = Buffers::<Size>::new();
        (0..3).for_each(|_| buffers.add_stage(&channels));
        for number in 0..5 {
            buffers.begin(stamp(number), &channels);
            for stage in 0..3_u64 {
                let expected = number.checked_sub(stage);
                assert_eq!(buffers.stamp(stage as usize).map(|stamp| stamp.number), expected);
                assert_eq!(buffers.views(stage as usize, &channels).len(), usize::from(expected.is_some()));
            }
            buffers.rotate();
        }
        assert!(buffers.in_flight());
        buffers.rotate();
        buffers.rotate();
        assert!(!buffers.in_flight());
        assert_eq!(buffers.newest(0).unwrap().0, 4);
    }

    #[test]
    fn a_resized_channel_gets_a_new_buffer_and_keeps_the_old_one_on_its_way() {
        let (small, large) = (Size::new(2, 2).unwrap(), Size::new(9, 9).unwrap());
        let mut channels = [Channel { name: "one".into(), size: small, open: true }];
        let mut buffers = Buffers::<Size>::new();
        (0..2).for_each(|_| buffers.add_stage(&channels));
        buffers.begin(stamp(0), &channels);
        assert!(buffers.views(0, &channels)[0].previous.is_none());
        buffers.rotate();
        channels[0].size = large;
        buffers.begin(stamp(1), &channels);
        assert_eq!((*buffers.views(0, &channels)[0].buffer, buffers.views(1, &channels)[0].size), (large, small));
        assert!(buffers.views(0, &channels)[0].previous.is_none());
        buffers.rotate();
        buffers.begin(stamp(2), &channels);
        assert!(buffers.views(0, &channels)[0].previous.is_some());
    }
}
