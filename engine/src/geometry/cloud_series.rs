//! Particles over time, ready for rays: a cloud for each step, in memory, or made when it is wanted.

use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::cloud::Cloud;

/// Makes the cloud of a step, from 0; an error is a line for people.
pub type Make = dyn Fn(usize) -> Result<Cloud, String> + Send + Sync;

/// A cloud for each step of time. Steps come and go while others are shown: what is shown stays in memory by itself.
pub struct CloudSeries {
    steps: Mutex<Vec<Option<Arc<Cloud>>>>,
    make: Option<Box<Make>>,
    limit: u64,
}

impl CloudSeries {
    /// Steps that stay in memory.
    ///
    /// # Panics
    /// If there are none.
    pub fn new(steps: Vec<Arc<Cloud>>) -> Self {
        assert!(!steps.is_empty(), "particles have a step of time");
        Self { steps: Mutex::new(steps.into_iter().map(Some).collect()), make: None, limit: u64::MAX }
    }

    /// Steps of which some are in memory. The others are made when they are wanted, so that all together take no more than `limit`
    /// bytes, or two steps if these are more.
    ///
    /// # Panics
    /// If there are none.
    pub fn made_when_wanted(steps: Vec<Option<Arc<Cloud>>>, make: Box<Make>, limit: u64) -> Self {
        assert!(!steps.is_empty(), "particles have a step of time");
        Self { steps: Mutex::new(steps), make: Some(make), limit }
    }

    fn steps(&self) -> MutexGuard<'_, Vec<Option<Arc<Cloud>>>> {
        self.steps.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// How many steps there are, in memory or not.
    pub fn len(&self) -> usize {
        self.steps().len()
    }

    /// There is always a step.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The cloud of a step, if it is in memory; behind the last step comes the first.
    pub fn get(&self, step: usize) -> Option<Arc<Cloud>> {
        let steps = self.steps();
        steps[step % steps.len()].clone()
    }

    /// The clouds that are in memory.
    pub fn in_memory(&self) -> Vec<Arc<Cloud>> {
        self.steps().iter().flatten().cloned().collect()
    }

    /// Can steps be made that are not in memory?
    pub fn makes_steps(&self) -> bool {
        self.make.is_some()
    }

    /// How many steps behind `shown` is the first that is not in memory, if it fits with those before it? It is to be made next while time
    /// goes on. `None`: nothing is to be done.
    pub fn wanted(&self, shown: usize) -> Option<usize> {
        self.make.as_ref()?;
        let steps = self.steps();
        let step = |ahead: usize| &steps[(shown + ahead) % steps.len()];
        let ahead = (0..steps.len()).find(|&ahead| step(ahead).is_none())?;
        let before: u64 = (0..ahead).map(|ahead| bytes(step(ahead))).sum();
        let largest = steps.iter().map(bytes).max().unwrap_or(0);
        (ahead < 2 || before + largest <= self.limit).then_some(ahead)
    }

    /// Makes room for one that is so many steps behind `shown`: forgets those that will be shown last.
    pub fn make_room(&self, shown: usize, ahead: usize) {
        let mut steps = self.steps();
        let count = steps.len();
        let largest = steps.iter().map(bytes).max().unwrap_or(0);
        let mut all: u64 = steps.iter().map(bytes).sum();
        for last in (ahead + 1..count).rev().map(|ahead| (shown + ahead) % count) {
            if all + largest <= self.limit {
                break;
            }
            all -= bytes(&steps[last].take());
        }
    }

    /// Makes a step.
    ///
    /// # Errors
    /// If it cannot be made; then the step is without particles from now on.
    ///
    /// # Panics
    /// If steps cannot be made.
    pub fn make(&self, step: usize) -> Result<(), String> {
        let make = self.make.as_ref().expect("a series that makes steps");
        let step = step % self.len();
        let made = make(step);
        let (cloud, told) = match made {
            Ok(cloud) => (cloud, Ok(())),
            Err(problem) => (Cloud::empty(), Err(problem)),
        };
        self.steps()[step] = Some(Arc::new(cloud));
        told
    }
}

fn bytes(step: &Option<Arc<Cloud>>) -> u64 {
    step.as_ref().map_or(0, |cloud| cloud.bytes() as u64)
}

impl fmt::Debug for CloudSeries {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let in_memory = self.in_memory().len();
        f.debug_struct("CloudSeries").field("steps", &self.len()).field("in_memory", &in_memory).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::AccelerationKind;
    use crate::particles::ParticleStep;

    /// A step with as many particles as its number says.
    fn cloud(step: usize) -> Result<Cloud, String> {
        let centers = vec![[step as f32; 3]; 64];
        let all = ParticleStep { centers, ..ParticleStep::default() };
        Cloud::new(all, 1.0, &AccelerationKind::Bvh.into()).map_err(|error| error.to_string())
    }

    fn there(series: &CloudSeries) -> Vec<usize> {
        (0..series.len()).filter(|&step| series.get(step).is_some()).collect()
    }

    /// Makes what is wanted while a step is shown.
    fn show(series: &CloudSeries, shown: usize) -> Vec<usize> {
        let mut made = Vec::new();
        while let Some(ahead) = series.wanted(shown) {
            series.make_room(shown, ahead);
            let _ = series.make(shown + ahead);
            made.push((shown + ahead) % series.len());
        }
        made
    }

    #[test]
    fn those_that_come_next_are_in_memory() {
        let size = cloud(0).unwrap().bytes() as u64;
        let make = |step| if step == 5 { Err("no 5".to_owned()) } else { cloud(step) };
        let series = CloudSeries::made_when_wanted(vec![None; 8], Box::new(make), 3 * size + 1);
        assert_eq!((show(&series, 1), there(&series)), (vec![1, 2, 3], vec![1, 2, 3]));
        assert_eq!((show(&series, 1), series.wanted(1)), (vec![], None));
        assert_eq!((show(&series, 2), there(&series)), (vec![4], vec![2, 3, 4]));
        // Step 5 has no particles, and takes next to no memory.
        assert_eq!(series.make(5), Err("no 5".to_owned()));
        assert_eq!(series.get(5).unwrap().census().count("particles"), 0);
        // Behind the last comes the first.
        show(&series, 7);
        assert_eq!(there(&series), [0, 1, 7]);
        assert!(Arc::ptr_eq(&series.get(8).unwrap(), &series.get(0).unwrap()));
    }

    #[test]
    fn two_steps_are_in_memory_whatever_the_limit() {
        let series = CloudSeries::made_when_wanted(vec![None; 4], Box::new(cloud), 0);
        for shown in [0, 1, 2, 3, 0, 2] {
            show(&series, shown);
            let mut expected = [shown, (shown + 1) % 4];
            expected.sort_unstable();
            assert_eq!(there(&series), expected);
        }
    }
}
