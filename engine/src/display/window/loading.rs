//! Scenes that come into a window: loaded on a thread of their own, once more when their files change, or in place of another.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use super::news::{News, Ready};
use super::screen::Screen;

/// Files are looked at no more often than this.
const LOOK: Duration = Duration::from_secs(1);

/// Who loads scenes for a window.
pub trait Loader: Send + Sync {
    /// Loads these files; without any, the scene that the window was opened for. Called on a thread of its own. Errors are for people.
    fn load(&self, files: &[PathBuf]) -> Result<Ready, String>;

    /// What is being done, and which part of that is done, if anybody knows.
    fn progress(&self) -> Option<(String, Option<f64>)>;
}

/// As much as the first thread of a process has, which loads scenes where there is no window.
const STACK: usize = 8 << 20;

/// Scenes on their way, and files that are watched.
pub(super) struct Loading {
    loader: Option<Arc<dyn Loader>>,
    /// Counts what was begun: what is not the newest is not wanted any more.
    newest: u64,
    /// Is the newest one on its way, since when, and does it take the place of the same scene?
    underway: Option<(Instant, bool)>,
    /// The files that were dropped on the window, if it shows those.
    files: Vec<PathBuf>,
    watched: Vec<(PathBuf, Option<SystemTime>)>,
    looked: Instant,
}

impl Loading {
    pub(super) fn new(loader: Option<Arc<dyn Loader>>) -> Self {
        let (watched, looked) = (Vec::new(), Instant::now());
        Self { loader, newest: 0, underway: None, files: Vec::new(), watched, looked }
    }

    /// Can anything be loaded?
    pub(super) fn is_possible(&self) -> bool {
        self.loader.is_some()
    }

    /// Loads files in place of what is shown, or without any the same once more.
    pub(super) fn begin(&mut self, files: Vec<PathBuf>, screen: &Screen) {
        let Some(loader) = self.loader.clone() else { return };
        self.newest += 1;
        let (number, screen) = (self.newest, screen.clone());
        let again = files.is_empty();
        let files = if again { self.files.clone() } else { files };
        self.underway = Some((Instant::now(), again));
        let wanted = files.clone();
        let builder = thread::Builder::new().name("mobula-load".to_owned()).stack_size(STACK);
        let spawned = builder.spawn({
            let screen = screen.clone();
            move || {
                let load = || loader.load(&files);
                let loaded = std::panic::catch_unwind(std::panic::AssertUnwindSafe(load));
                let loaded =
                    loaded.unwrap_or_else(|_| Err("loading has failed for a reason that was told above".to_owned()));
                screen.tell(News::Loaded(number, wanted, loaded.map(Box::new)));
            }
        });
        if let Err(error) = spawned {
            let problem = format!("no thread to load with: {error}");
            screen.tell(News::Loaded(number, Vec::new(), Err(problem)));
        }
    }

    /// Something was loaded, or not. Is it still wanted, and does it take the place of the same scene?
    pub(super) fn end(&mut self, number: u64) -> Option<bool> {
        let (_, again) = self.underway.take_if(|_| number == self.newest)?;
        Some(again)
    }

    /// What was on its way is not wanted any more. Says whether there was anything.
    pub(super) fn cancel(&mut self) -> bool {
        self.newest += 1;
        self.underway.take().is_some()
    }

    /// These are shown now, and watched.
    pub(super) fn shows(&mut self, files: Vec<PathBuf>, watched: &[PathBuf]) {
        self.files = files;
        self.watched = watched.iter().map(|file| (file.clone(), changed(file))).collect();
    }

    /// Have files changed? Looks at them once a second. What changes while it is written counts when it has come to rest for that long.
    pub(super) fn have_changed(&mut self) -> bool {
        if self.looked.elapsed() < LOOK || self.underway.is_some() {
            return false;
        }
        self.looked = Instant::now();
        let mut any = false;
        for (file, before) in &mut self.watched {
            let now = changed(file);
            let rests = now.is_some_and(|time| time.elapsed().map_or(true, |age| age >= LOOK));
            if now != *before && rests {
                (*before, any) = (now, true);
            }
        }
        any
    }

    /// When it should be looked again, at files or at how far loading has come.
    pub(super) fn due(&self) -> Option<Instant> {
        match self.underway {
            Some(_) => Some(Instant::now() + Duration::from_millis(100)),
            None if !self.watched.is_empty() => Some(self.looked + LOOK),
            None => None,
        }
    }

    /// Is something being loaded?
    pub(super) fn is_underway(&self) -> bool {
        self.underway.is_some()
    }

    /// What people are told while something is loaded: text, and how much of it is done. Nothing at first, as most is loaded soon.
    pub(super) fn progress(&self, patience: Duration) -> Option<(String, Option<f64>)> {
        let (since, _) = self.underway?;
        if since.elapsed() < patience {
            return None;
        }
        let seconds = since.elapsed().as_secs();
        let (what, share) = self.loader.as_ref()?.progress().unwrap_or_else(|| ("loading".to_owned(), None));
        let text = match share {
            Some(share) => format!("{what}: {:.0} %, {seconds} s", share * 100.0),
            None => format!("{what}, {seconds} s"),
        };
        Some((text, share))
    }
}

/// When a file was changed last; `None` if it is not there.
fn changed(file: &PathBuf) -> Option<SystemTime> {
    std::fs::metadata(file).and_then(|known| known.modified()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_change_and_come_to_rest_are_noticed_once() {
        let file = std::env::temp_dir().join(format!("mobula-watched-{}", std::process::id()));
        std::fs::write(&file, "1").unwrap();
        let mut loading = Loading::new(None);
        loading.shows(Vec::new(), &[file.clone(), "not-there".into()]);
        let mut look = || {
            loading.looked = Instant::now() - 2 * LOOK;
            loading.have_changed()
        };
        assert!(!look());
        let handle = std::fs::File::options().write(true).open(&file).unwrap();
        handle.set_modified(SystemTime::now() - Duration::from_secs(60)).unwrap();
        assert!(look() && !look());
        handle.set_modified(SystemTime::now()).unwrap();
        assert!(!look(), "it may still be written");
        std::fs::remove_file(&file).unwrap();
        assert!(!look(), "it may come again");
    }

    #[test]
    fn what_is_not_the_newest_is_not_wanted() {
        let mut loading = Loading::new(None);
        assert_eq!(loading.end(0), None);
        loading.underway = Some((Instant::now(), true));
        loading.newest = 3;
        assert_eq!((loading.end(2), loading.end(3), loading.end(3)), (None, Some(true), None));
        assert!(!loading.cancel());
    }
}
