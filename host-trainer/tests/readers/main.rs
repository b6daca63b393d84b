//! The readers from outside, in three kinds of test.

/// Asserts that an error is of a variant of `ReadError`.
macro_rules! assert_variant {
    ($error:expr, $variant:ident) => {
        let error = $error;
        assert!(matches!(error, ReadError::$variant { .. }), "{error:?}");
    };
}

mod binary;
mod error;
mod golden;
mod invariant;

use std::{fs, path::PathBuf};

use ballrace::recording::{LoadOptions, Loaded, ReadError, load};

/// A folder of files that goes away with the test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        files.iter().for_each(|(name, text)| folder.write(name, text.as_bytes()));
        folder
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Loads a file of the folder; `""` is the folder itself.
    fn load(&self, name: &str, options: &LoadOptions) -> Result<Loaded, ReadError> {
        load(&[if name.is_empty() { self.0.path().into() } else { self.path(name) }], options)
    }
}
