//! Jobs from paths: the files to read, and what is stated about them.

use std::{
    cmp::Ordering,
    fs,
    path::{Path, PathBuf},
};

use super::{
    LoadOptions, ReadError,
    formats::femto,
    job::{Format, Job},
    manifest::{Entry, FILE_NAME, Manifest},
};

/// Jobs of all paths, in the order of the paths and of the files in them.
pub(super) fn jobs(paths: &[PathBuf], options: &LoadOptions) -> Result<Vec<Job>, ReadError> {
    let mut jobs = Vec::new();
    for (group, path) in paths.iter().enumerate() {
        for entry in entries(path)? {
            let format = Format::from_path(&entry.file)?;
            let variable = match format {
                Format::Mat => options.variable.clone().or_else(|| entry.variable.clone()),
                _ => None,
            };
            jobs.push(Job { entry, format, variable, group });
        }
    }
    Ok(jobs)
}

/// Files that [`load`](super::load()) reads for these paths, manifests included; of a path that cannot be read, itself.
pub fn sources(paths: &[PathBuf]) -> Vec<PathBuf> {
    let of = |path: &PathBuf| {
        let manifest = if path.is_dir() { path.join(FILE_NAME) } else { path.clone() };
        let entries = entries(path).unwrap_or_default().into_iter().map(|entry| entry.file);
        std::iter::once(manifest).chain(entries).collect::<Vec<_>>()
    };
    paths.iter().flat_map(of).collect()
}

fn entries(path: &Path) -> Result<Vec<Entry>, ReadError> {
    let metadata = fs::metadata(path).map_err(|source| ReadError::of(path, source))?;
    if !metadata.is_dir() {
        let is_manifest = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
        return if is_manifest { Ok(Manifest::read(path)?.entries) } else { Ok(vec![Entry::new(path.into())]) };
    }
    let manifest = path.join(FILE_NAME);
    if manifest.is_file() {
        return Ok(Manifest::read(&manifest)?.entries);
    }
    let files = list_files(path)?;
    let femto = |f: &&PathBuf| femto::is_named(f);
    let csv = |f: &&PathBuf| matches!(Format::from_path(f), Ok(Format::Csv));
    let any = |f: &&PathBuf| Format::from_path(f).is_ok();
    let kinds: [&dyn Fn(&&PathBuf) -> bool; 3] = [&femto, &csv, &any];
    for kind in kinds {
        let found: Vec<Entry> = files.iter().filter(kind).cloned().map(Entry::new).collect();
        if !found.is_empty() {
            return Ok(found);
        }
    }
    Err(ReadError::NoRecordings { path: path.into() })
}

/// Files of a folder in natural order: `r2` before `r10`.
fn list_files(folder: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let io = |source| ReadError::Io { path: folder.into(), source };
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        // Hidden files are editors' and file systems' own, such as `._r01.csv`.
        let is_hidden = path.file_name().is_some_and(|n| n.as_encoded_bytes().starts_with(b"."));
        if !is_hidden && path.is_file() {
            files.push(path);
        }
    }
    let name = |p: &PathBuf| p.file_name().unwrap_or_default().as_encoded_bytes().to_vec();
    files.sort_by(|a, b| natural(&name(a), &name(b)));
    Ok(files)
}

/// Natural order of names: text by bytes, numbers by value.
fn natural(mut a: &[u8], mut b: &[u8]) -> Ordering {
    fn take_number<'a>(text: &mut &'a [u8]) -> &'a [u8] {
        let digits = text.iter().take_while(|b| b.is_ascii_digit()).count();
        let (number, rest) = text.split_at(digits);
        *text = rest;
        let zeros = number.iter().take_while(|&&b| b == b'0').count();
        &number[zeros..]
    }
    let (all_a, all_b) = (a, b);
    while let (Some(x), Some(y)) = (a.first(), b.first()) {
        if x.is_ascii_digit() && y.is_ascii_digit() {
            let (x, y) = (take_number(&mut a), take_number(&mut b));
            let order = x.len().cmp(&y.len()).then_with(|| x.cmp(y));
            if order.is_ne() {
                return order;
            }
        } else if x != y {
            return x.cmp(y);
        } else {
            (a, b) = (&a[1..], &b[1..]);
        }
    }
    // The longer rest comes later; `r01` and `r1` differ by their bytes only.
    a.len().cmp(&b.len()).then_with(|| all_a.cmp(all_b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_order_by_value() {
        let mut names = ["r10", "r2", "r02", "a", "r1.csv", "r", "r2b", "r010"];
        names.sort_by(|a, b| natural(a.as_bytes(), b.as_bytes()));
        assert_eq!(names, ["a", "r", "r1.csv", "r02", "r2", "r2b", "r010", "r10"]);
    }
}
