//! Files that are whole or not there: written beside their place under another name, and given their name when they are
//! complete, so that nobody ever sees half of one.
//!
//! Links are followed. A file that was there keeps its mode, its owner and its other names (hard links); where only
//! writing into it can do that, it is written into, once all of the new content is on the disk. Devices and pipes are
//! written to directly.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Files that are being written, under the names that they have until they are complete.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// So many links in a row are followed: as many as Linux follows.
const MOST_LINKS: usize = 40;

/// Writes a file with `content`. Either the whole file is there afterwards, or what was there before.
///
/// # Errors
/// What the system says, or `content`.
pub fn write(file: &Path, content: impl FnOnce(File) -> io::Result<()>) -> io::Result<()> {
    let (target, there) = match fs::metadata(file) {
        Ok(there) if there.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(there) if !there.is_file() => return content(OpenOptions::new().write(true).open(file)?),
        Ok(there) => (fs::canonicalize(file)?, Some(there)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => (behind_links(file)?, None),
        Err(error) => return Err(error),
    };
    let (unfinished, handle) = match Unfinished::beside(&target) {
        // The folder takes no other file, but the file itself may be written.
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied && there.is_some() => {
            return content(OpenOptions::new().write(true).truncate(true).open(&target).map_err(|_| error)?);
        }
        made => made?,
    };
    let same = there.as_ref().is_none_or(|there| resembles(&handle, there));
    content(handle)?;
    if same { unfinished.rename_to(&target) } else { unfinished.copy_into(&target) }
}

/// Removes the files that are being written, and ends the process: for signals.
pub fn exit(status: i32) -> ! {
    // The lock is held to the end, so that no further file is begun.
    let unfinished = unfinished();
    unfinished.iter().for_each(|file| drop(fs::remove_file(file)));
    std::process::exit(status)
}

/// Where a file is made that is named by a link to nothing, or by none.
fn behind_links(file: &Path) -> io::Result<PathBuf> {
    let mut file = file.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&file) {
            Ok(to) => file = file.parent().unwrap_or(Path::new("")).join(to),
            Err(_) => return Ok(file),
        }
    }
    Err(io::Error::other("too many links"))
}

/// Gives a new file the owner and the mode of the one whose place it takes. False if it cannot stand for that one: its owner
/// cannot be given, or it has other names.
#[cfg(unix)]
fn resembles(new: &File, there: &Metadata) -> bool {
    use std::os::unix::fs::{MetadataExt, fchown};
    let same = |new: &Metadata| (new.uid(), new.gid()) == (there.uid(), there.gid());
    let owned = new.metadata().is_ok_and(|new| same(&new)) || fchown(new, Some(there.uid()), Some(there.gid())).is_ok();
    // After the owner: giving a file away takes some bits of its mode.
    let mode = new.set_permissions(there.permissions()).is_ok();
    owned && mode && there.nlink() == 1
}

#[cfg(not(unix))]
fn resembles(_: &File, there: &Metadata) -> bool {
    !there.permissions().readonly()
}

/// A file that is being written; removed when dropped.
struct Unfinished(PathBuf);

impl Unfinished {
    /// A new file in the folder of `target`, with a name of its own, which is short: that of `target` may be as long as names
    /// may be.
    fn beside(target: &Path) -> io::Result<(Self, File)> {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        if target.file_name().is_none() {
            return Err(io::ErrorKind::InvalidFilename.into());
        }
        let mut all = unfinished();
        loop {
            // Relaxed: only the numbers must differ.
            let number = NEXT.fetch_add(1, Ordering::Relaxed);
            let path = target.with_file_name(format!(".mobula-{}-{number}.tmp", std::process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
                Ok(handle) => {
                    all.push(path.clone());
                    return Ok((Self(path), handle));
                }
            }
        }
    }

    fn rename_to(self, target: &Path) -> io::Result<()> {
        fs::rename(&self.0, target)
    }

    fn copy_into(self, target: &Path) -> io::Result<()> {
        let mut to = OpenOptions::new().write(true).truncate(true).open(target)?;
        io::copy(&mut File::open(&self.0)?, &mut to).map(drop)
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        let mut all = unfinished();
        // It is not there any more if it was renamed.
        let _ = fs::remove_file(&self.0);
        all.retain(|file| *file != self.0);
    }
}

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    struct Folder(PathBuf);

    impl Folder {
        fn new(test: &str) -> Self {
            let path = std::env::temp_dir().join(format!("mobula-output-{test}-{}", std::process::id()));
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }

        fn write(&self, name: &str, text: &str) -> io::Result<()> {
            write(&self.0.join(name), |mut file| file.write_all(text.as_bytes()))
        }

        fn read(&self, name: &str) -> String {
            fs::read_to_string(self.0.join(name)).unwrap()
        }

        fn files(&self) -> Vec<String> {
            let entries = fs::read_dir(&self.0).unwrap();
            let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn names_may_be_as_long_as_the_system_allows() {
        let folder = Folder::new("long");
        let longest = "n".repeat(251) + ".png";
        folder.write(&longest, "long").unwrap();
        assert_eq!(folder.files(), [longest]);
        assert!(folder.write(&"n".repeat(1000), "too long").is_err());
    }

    #[test]
    fn what_fails_leaves_what_was_there() {
        let folder = Folder::new("fails");
        folder.write("a", "before").unwrap();
        let failed = write(&folder.0.join("a"), |mut file| {
            file.write_all(b"half")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert_eq!(failed.unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!((folder.read("a").as_str(), folder.files()), ("before", vec!["a".to_owned()]));
        assert!(folder.write(".", "a folder").is_err() && folder.write("none/a", "no folder").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn mode_and_other_names_are_kept() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt};
        let folder = Folder::new("mode");
        folder.write("a", "one, which is longer").unwrap();
        for mode in [0o600, 0o640, 0o755] {
            fs::set_permissions(folder.0.join("a"), PermissionsExt::from_mode(mode)).unwrap();
            folder.write("a", "two").unwrap();
            let there = fs::metadata(folder.0.join("a")).unwrap();
            assert_eq!((there.mode() & 0o7777, folder.read("a").as_str()), (mode, "two"));
        }
        fs::hard_link(folder.0.join("a"), folder.0.join("b")).unwrap();
        folder.write("a", "3").unwrap();
        assert_eq!((folder.read("a").as_str(), folder.read("b").as_str()), ("3", "3"));
        assert_eq!(folder.files(), ["a", "b"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_to_what_is_there_and_to_what_is_not() {
        use std::os::unix::fs::symlink;
        let folder = Folder::new("links");
        fs::create_dir(folder.0.join("deep")).unwrap();
        symlink("deep/second", folder.0.join("first")).unwrap();
        symlink("../real", folder.0.join("deep/second")).unwrap();
        for text in ["made", "replaced"] {
            folder.write("first", text).unwrap();
            assert_eq!(folder.read("real"), text);
            assert!(folder.0.join("first").is_symlink() && folder.0.join("deep/second").is_symlink());
        }
        symlink("none/file", folder.0.join("lost")).unwrap();
        assert_eq!(folder.write("lost", "").unwrap_err().kind(), io::ErrorKind::NotFound);
        symlink("round", folder.0.join("round")).unwrap();
        assert!(folder.write("round", "").is_err() && folder.0.join("round").is_symlink());
        assert_eq!(folder.files(), ["deep", "first", "lost", "real", "round"]);
    }
}
