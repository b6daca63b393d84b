//! Guard of what a command would replace: the files that it reads, and measurements of anybody.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::Failure;
use crate::diagnose::write::is_foreign;
use crate::model;
use crate::recording::{owned, sources};

/// Permission to replace what is read.
#[derive(clap::Args, Debug, Clone, Copy, Default)]
pub struct Force {
    /// Replace a file that this command reads, if ballrace itself wrote it; measurements are never replaced
    #[arg(long)]
    force: bool,
}

/// Outputs of a command, checked before its work against what it reads and what is there.
#[derive(Debug)]
pub struct Outputs {
    force: bool,
    inputs: HashSet<Place>,
    /// Options of the outputs checked so far, and where they lead.
    taken: Vec<(&'static str, Place)>,
}

impl Outputs {
    /// Outputs of a command that reads these files.
    pub fn new<'a>(force: Force, files: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        Self {
            force: force.force,
            inputs: files.into_iter().filter_map(|path| Place::of(path)).collect(),
            taken: Vec::new(),
        }
    }

    /// The same for a command that also reads these recordings.
    pub fn beside(mut self, recordings: &[PathBuf]) -> Self {
        self.inputs.extend(sources(recordings).iter().filter_map(|path| Place::of(path)));
        self
    }

    /// Checks an output that is one file, and no recording or rig.
    pub fn file(&mut self, option: &'static str, path: &Path) -> Result<(), Failure> {
        self.place(option, path)?;
        self.check(option, path)?;
        let is_settings = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
        if path.is_file() && (is_settings || owned::is_recording(path) && !owned::is_own(path)) {
            let expected = "the name of a new file, or of one of its own kind";
            return Err(Failure::option(option, path.display(), expected));
        }
        Ok(())
    }

    /// Checks an output that is a rig, which may be the one that is read: it keeps what was not fitted.
    pub fn rig(&mut self, option: &'static str, path: &Path, read: &Path) -> Result<(), Failure> {
        self.place(option, path)?;
        if Place::of(path) != Place::of(read) {
            self.check(option, path)?;
        }
        if path.is_file() && owned::is_recording(path) {
            return Err(Failure::option(option, path.display(), "the name of a new file, or of a rig"));
        }
        Ok(())
    }

    /// Checks that a file can be written there, and that no other output goes there.
    fn place(&mut self, option: &'static str, path: &Path) -> Result<(), Failure> {
        let refuse = |found: String, expected: &str| Err(Failure::option(option, found, expected));
        if path.as_os_str().is_empty() {
            return refuse("nothing".into(), "the name of a file");
        }
        if path.is_dir() {
            return refuse(format!("the folder {}", path.display()), "the name of a file");
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            return refuse(folder.display().to_string(), "a folder that exists");
        }
        if let Some(place) = Place::of(path) {
            if let Some((other, _)) = self.taken.iter().find(|(_, taken)| *taken == place) {
                return refuse(format!("the file of --{other}"), "another file");
            }
            self.taken.push((option, place));
        }
        Ok(())
    }

    /// Checks an output that is a folder, and the files that will be written into it.
    pub fn folder(&self, option: &'static str, folder: &Path, files: &[PathBuf]) -> Result<(), Failure> {
        if folder.as_os_str().is_empty() {
            return Err(Failure::option(option, "nothing", "the name of a folder"));
        }
        if folder.exists() && !folder.is_dir() {
            return Err(Failure::option(option, format!("the file {}", folder.display()), "a folder"));
        }
        files.iter().try_for_each(|path| self.check(option, path))
    }

    /// Checks an output that is a folder of recordings.
    pub fn recordings(&self, option: &'static str, folder: &Path, files: &[PathBuf]) -> Result<(), Failure> {
        self.folder(option, folder, files)?;
        refuse_foreign(option, files, |path| !owned::is_own(path))
    }

    /// Checks the output of a diagnosis, of whose held-out recordings the names can be these.
    pub fn diagnosis(
        &self,
        option: &'static str,
        folder: &Path,
        files: &[PathBuf],
        held_out: &[PathBuf],
    ) -> Result<(), Failure> {
        self.folder(option, folder, &[files, held_out].concat())?;
        refuse_foreign(option, held_out, is_foreign)
    }

    /// Refuses a file that the command reads.
    fn check(&self, option: &str, path: &Path) -> Result<(), Failure> {
        if !path.exists() || !Place::of(path).is_some_and(|place| self.inputs.contains(&place)) {
            return Ok(());
        }
        let own = owned::is_own(path) || model::file::read(path).is_ok();
        if own && self.force {
            return Ok(());
        }
        let hint = if own { ", or --force, since ballrace wrote it" } else { "" };
        let found = format!("{}, which this command reads", path.display());
        Err(Failure::option(option, found, format!("another place{hint}")))
    }
}

fn refuse_foreign(option: &str, files: &[PathBuf], is_foreign: impl Fn(&Path) -> bool) -> Result<(), Failure> {
    match files.iter().find(|path| path.exists() && is_foreign(path)) {
        None => Ok(()),
        Some(path) => {
            let found = format!("{}, which ballrace did not write or which was changed since", path.display());
            Err(Failure::option(option, found, "a folder without it"))
        }
    }
}

/// Where a path leads, behind links: the same for two names of one file.
#[derive(Debug, PartialEq, Eq, Hash)]
enum Place {
    #[cfg(unix)]
    Node(u64, u64),
    Path(PathBuf),
}

impl Place {
    /// Place of a file, which need not exist; `None` for a device or a pipe, which loses nothing.
    fn of(path: &Path) -> Option<Self> {
        match fs::metadata(path) {
            Ok(metadata) if !metadata.is_file() => None,
            #[cfg(unix)]
            Ok(metadata) => {
                use std::os::unix::fs::MetadataExt;
                Some(Self::Node(metadata.dev(), metadata.ino()))
            }
            #[cfg(not(unix))]
            Ok(_) => path.canonicalize().ok().map(Self::Path),
            Err(_) => {
                let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
                Some(Self::Path(folder.canonicalize().ok()?.join(path.file_name()?)))
            }
        }
    }
}
