//! Files for tests of loaders.
#![allow(dead_code, reason = "no test needs all of it")]

use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use mobula::load::{LoadError, Loaded, load};

/// Tests of one process may give their folders the same name.
static NEXT: AtomicUsize = AtomicUsize::new(0);

/// A folder of its own for each test, removed at its end.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new(test: &str) -> Self {
        // In memory where there is such a file system: thousands of small files are written.
        let memory = PathBuf::from("/dev/shm");
        let base = if memory.is_dir() { memory } else { std::env::temp_dir() };
        let path = base.join(format!("mobula-load-{test}-{}-{}", std::process::id(), NEXT.fetch_add(1, Relaxed)));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
        path
    }

    pub(crate) fn load(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<Loaded, LoadError> {
        load(&self.write(name, bytes))
    }

    /// The error of a broken file, without its folder.
    pub(crate) fn complaint(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        let text = self.load(name, bytes).map(|loaded| loaded.report).expect_err("loaded").to_string();
        assert!(!text.contains('\n'), "more than a line: {text}");
        self.without(&text)
    }

    /// What people are told of a file that loads.
    pub(crate) fn warning(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        let warnings = self.load(name, bytes).unwrap().report.warnings;
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        self.without(warning)
    }

    /// A message without the folder that it begins with.
    fn without(&self, text: &str) -> String {
        text.strip_prefix(&format!("{}/", self.0.display())).expect("no path").to_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packer.write_all(bytes).unwrap();
    packer.finish().unwrap()
}
