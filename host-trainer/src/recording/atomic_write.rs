//! Writes that leave nothing half done: a file appears under its name only once it is complete.
//!
//! A link is followed, so that the link stays and its target is replaced; a device or a pipe is written to; a file that
//! is replaced keeps its mode and owner.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Links followed before a path counts as a circle, as Linux does.
const MOST_LINKS: usize = 40;

/// Writes to a file without a name, or a temporary one, in the same folder, then gives it its name.
///
/// # Errors
/// Error of the operating system, or of `write`.
pub fn write_with(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    if is_stream(path) {
        let mut out = BufWriter::new(OpenOptions::new().write(true).open(path)?);
        write(&mut out)?;
        return out.flush();
    }
    let path = behind_links(path)?;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let old = replaced(&path)?;
    let file = match unnamed(folder) {
        Some(file) => {
            let mut out = BufWriter::new(file);
            write(&mut out)?;
            let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
            named(folder, &file)?
        }
        None => {
            let mut out = BufWriter::new(builder().tempfile_in(folder)?);
            write(&mut out)?;
            out.into_inner().map_err(io::IntoInnerError::into_error)?.into_temp_path()
        }
    };
    if let Some(old) = old {
        keep(&file, &old)?;
    }
    file.persist(path).map_err(|error| error.error)
}

/// Builder of temporary files with the mode of others: they are private by default.
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

/// File without a name, so that a killed process leaves nothing; `None` where the system has no such files.
#[cfg(target_os = "linux")]
fn unnamed(folder: &Path) -> Option<File> {
    use rustix::fs::{Mode, OFlags, open};
    let flags = OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC;
    // Naming such a file goes through /proc.
    Path::new("/proc/self/fd").is_dir().then(|| open(folder, flags, Mode::from_raw_mode(0o666)).ok().map(File::from))?
}

/// Gives a file without a name a temporary one.
#[cfg(target_os = "linux")]
fn named(folder: &Path, file: &File) -> io::Result<tempfile::TempPath> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use std::os::fd::AsRawFd;
    let open = format!("/proc/self/fd/{}", file.as_raw_fd());
    builder()
        .make_in(folder, |path| linkat(CWD, &open, CWD, path, AtFlags::SYMLINK_FOLLOW).map_err(io::Error::from))
        .map(tempfile::NamedTempFile::into_temp_path)
}

#[cfg(not(target_os = "linux"))]
fn unnamed(_: &Path) -> Option<File> {
    None
}

#[cfg(not(target_os = "linux"))]
fn named(_: &Path, _: &File) -> io::Result<tempfile::TempPath> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Writes bytes as [`write_with`].
///
/// # Errors
/// Error of the operating system.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_with(path, |out| out.write_all(bytes))
}

/// Moves a finished file to its name, as [`write_with`] does.
///
/// # Errors
/// Error of the operating system.
pub fn install(made: &Path, path: &Path) -> io::Result<()> {
    if is_stream(path) || path.is_symlink() {
        // The target can be on another disk, to which nothing can be renamed.
        return write_with(path, |out| io::copy(&mut File::open(made)?, out).map(|_| ()));
    }
    if let Some(old) = replaced(path)? {
        keep(made, &old)?;
    }
    fs::rename(made, path)
}

/// Whether a path leads to a device, a pipe or a socket, which is written to instead of replaced.
fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir())
}

/// File that a path leads to behind its links; it need not exist.
fn behind_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&path) {
            Ok(target) => path = path.parent().unwrap_or(Path::new("")).join(target),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("a circle of links"))
}

/// Metadata of the file that will be replaced, if any; an error if it may not be written.
fn replaced(path: &Path) -> io::Result<Option<Metadata>> {
    match OpenOptions::new().write(true).open(path) {
        Ok(file) => file.metadata().map(Some),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// Gives a new file the mode and, where this is allowed, the owner of the file that it replaces.
fn keep(made: &Path, old: &Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, chown};
        // Only root may give a file away; another user's file then becomes the writer's.
        let _ = chown(made, Some(old.uid()), Some(old.gid()));
    }
    fs::set_permissions(made, old.permissions())
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};

    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn a_half_written_file_has_no_name() {
        let folder = tempfile::tempdir().unwrap();
        let names = || fs::read_dir(folder.path()).unwrap().count();
        write_with(&folder.path().join("made"), |out| {
            out.write_all(&[b'x'; 100_000])?;
            assert_eq!(names(), 0);
            Ok(())
        })
        .unwrap();
        assert_eq!((names(), fs::read(folder.path().join("made")).unwrap().len()), (1, 100_000));
    }

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    #[test]
    fn a_link_stays_and_its_target_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let [target, link, hanging] = ["target", "link", "hanging"].map(|n| folder.path().join(n));
        fs::write(&target, "old").unwrap();
        symlink("target", &link).unwrap();
        symlink("made", &hanging).unwrap();
        let made = folder.path().join("elsewhere");
        fs::write(&made, "moved").unwrap();
        write_atomically(&link, b"new").unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
        install(&made, &link).unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"moved");
        write_atomically(&hanging, b"made").unwrap();
        assert_eq!(fs::read(folder.path().join("made")).unwrap(), b"made");
        assert!(link.is_symlink() && hanging.is_symlink());
        symlink("circle", folder.path().join("circle")).unwrap();
        assert!(write_atomically(&folder.path().join("circle"), b"x").is_err());
    }

    #[test]
    fn a_replaced_file_keeps_its_mode_and_a_new_one_has_the_usual() {
        let folder = tempfile::tempdir().unwrap();
        let [old, new, usual] = ["old", "new", "usual"].map(|n| folder.path().join(n));
        fs::write(&old, "old").unwrap();
        fs::set_permissions(&old, fs::Permissions::from_mode(0o640)).unwrap();
        write_atomically(&old, b"new").unwrap();
        write_atomically(&new, b"new").unwrap();
        fs::write(&usual, "usual").unwrap();
        assert_eq!(mode(&old), 0o640);
        assert_eq!(mode(&new), mode(&usual));
    }

    #[test]
    fn a_pipe_is_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read(pipe).unwrap()
        });
        write_atomically(&pipe, b"through").unwrap();
        assert_eq!(reader.join().unwrap(), b"through");
        assert!(fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
    }
}
