//! Files and folders that are written whole or not at all: aside first, then renamed.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::text;
use crate::write_error::{WriteError, WriteProblem};

/// What operating systems leave in every folder that someone looks at.
const CLUTTER: [&str; 3] = [".DS_Store", "Thumbs.db", "desktop.ini"];

/// A kind of folder that may replace an earlier one of its kind, and nothing else.
pub(crate) struct FolderKind {
    /// In words.
    pub(crate) kind: &'static str,
    /// The files that it has.
    pub(crate) files: &'static [&'static str],
    /// The file that tells such a folder from others.
    pub(crate) mark: &'static str,
    /// Whether the content of that file does.
    pub(crate) is_mark: fn(&Path) -> bool,
}

impl FolderKind {
    /// Whether a folder of this kind could be written to `dir`; changes nothing.
    pub(crate) fn check(&self, dir: &Path) -> Result<(), WriteError> {
        let target = self.target(dir)?;
        // The nearest folder that exists is where new ones will be made, the first of them beside the target if it exists.
        let place = existing_ancestor(&parent(&target))?;
        let probe = make_aside(&place, "probe").map_err(|error| WriteError::io(&place, &error))?;
        fs::remove_dir(&probe).map_err(|error| WriteError::io(&probe, &error))
    }

    /// Writes a folder with these files in place of an earlier one, making parents as needed.
    pub(crate) fn write(&self, dir: &Path, files: &[(&str, &str)]) -> Result<(), WriteError> {
        let target = self.target(dir)?;
        let place = parent(&target);
        make_parents(&place)?;
        let failed = |error: io::Error| WriteError::io(dir, &error);
        let staging = Aside(make_aside(&place, "partial").map_err(failed)?);
        for (name, content) in files {
            write_synced(&staging.0.join(name), content.as_bytes()).map_err(failed)?;
        }
        // Looked at again: the computation may have taken hours.
        self.check_content(&target, dir)?;
        if !target.exists() {
            return fs::rename(&staging.0, &target).map_err(failed);
        }
        let aside = Aside(make_aside(&place, "earlier").map_err(failed)?);
        let earlier = aside.0.join("folder");
        fs::rename(&target, &earlier).map_err(failed)?;
        if let Err(error) = fs::rename(&staging.0, &target) {
            fs::rename(&earlier, &target).map_err(failed)?;
            return Err(failed(error));
        }
        // The new folder is in place. What cannot be removed of the earlier one, or came to it in the meantime, stays aside:
        // no reason to call the work a failure.
        for name in self.files.iter().chain(&CLUTTER) {
            let _ = fs::remove_file(earlier.join(name));
        }
        let _ = fs::remove_dir(&earlier);
        Ok(())
    }

    /// The folder to write: links resolved, content checked.
    fn target(&self, dir: &Path) -> Result<PathBuf, WriteError> {
        let failed = |error| WriteError::io(dir, &error);
        let target = match fs::canonicalize(dir) {
            Ok(target) => target,
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
                // No name, or a link to nowhere.
                if dir.file_name().is_none() || fs::symlink_metadata(dir).is_ok() {
                    return Err(WriteError::new(dir, WriteProblem::NoName));
                }
                return std::path::absolute(dir).map_err(failed);
            }
            Err(error) => return Err(failed(error)),
        };
        if !target.is_dir() {
            return Err(WriteError::new(dir, WriteProblem::IsFile));
        }
        if std::env::current_dir().and_then(fs::canonicalize).is_ok_and(|current| current == target) {
            return Err(WriteError::new(dir, WriteProblem::CurrentFolder { kind: self.kind }));
        }
        if target.file_name().is_none() {
            return Err(WriteError::new(dir, WriteProblem::NoName));
        }
        self.check_content(&target, dir)?;
        Ok(target)
    }

    /// Refuses a folder in which a file would be lost.
    fn check_content(&self, target: &Path, dir: &Path) -> Result<(), WriteError> {
        if !target.exists() {
            return Ok(());
        }
        let failed = |error| WriteError::io(dir, &error);
        let mut names: Vec<OsString> = Vec::new();
        for entry in fs::read_dir(target).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            if CLUTTER.iter().any(|clutter| entry.file_name() == *clutter) {
                continue;
            }
            names.push(entry.file_name());
        }
        names.sort();
        let is_file = |name: &OsStr| fs::symlink_metadata(target.join(name)).is_ok_and(|found| found.is_file());
        let is_ours = |name: &OsStr| self.files.iter().any(|file| name == *file) && is_file(name);
        let foreign = names.iter().find(|name| !is_ours(name)).or_else(|| {
            // All names are ours; so must be the file that tells.
            let first = names.first()?;
            (!(self.is_mark)(&target.join(self.mark))).then_some(first)
        });
        match foreign {
            None => Ok(()),
            Some(name) => {
                let found = text::quoted(&name.to_string_lossy());
                Err(WriteError::new(dir, WriteProblem::Foreign { kind: self.kind, found }))
            }
        }
    }
}

/// Writes one file whole or not at all, making parents as needed. A device or pipe is written to directly.
pub(crate) fn write_file(path: &Path, content: &[u8]) -> Result<(), WriteError> {
    let failed = |error: io::Error| WriteError::io(path, &error);
    let target = match fs::canonicalize(path) {
        Ok(target) if target.is_dir() => return Err(WriteError::new(path, WriteProblem::IsFolder)),
        Ok(target) if !target.is_file() => return fs::write(target, content).map_err(failed),
        Ok(target) => target,
        Err(_) if path.file_name().is_none() => return Err(WriteError::new(path, WriteProblem::IsFolder)),
        Err(_) => std::path::absolute(path).map_err(failed)?,
    };
    let place = parent(&target);
    make_parents(&place)?;
    let staging = Aside(make_aside(&place, "partial").map_err(failed)?);
    let partial = staging.0.join("file");
    write_synced(&partial, content).map_err(failed)?;
    fs::rename(&partial, &target).map_err(failed)
}

/// A folder of ours that goes with its files when this does, unless it was renamed before. A folder inside it stays.
struct Aside(PathBuf);

impl Drop for Aside {
    fn drop(&mut self) {
        // Best effort: there is no one left to tell.
        if let Ok(entries) = fs::read_dir(&self.0) {
            for entry in entries.flatten() {
                let _ = fs::remove_file(entry.path());
            }
        }
        let _ = fs::remove_dir(&self.0);
    }
}

/// Makes a new hidden folder in `place`.
fn make_aside(place: &Path, purpose: &str) -> io::Result<PathBuf> {
    let mut attempt = 0;
    loop {
        let path = place.join(format!(".palpate-{purpose}-{}-{attempt}", std::process::id()));
        match fs::create_dir(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < 1000 => attempt += 1,
            outcome => return outcome.map(|()| path),
        }
    }
}

fn make_parents(place: &Path) -> Result<(), WriteError> {
    existing_ancestor(place)?;
    fs::create_dir_all(place).map_err(|error| WriteError::io(place, &error))
}

/// The nearest folder on the way to `place` that is there already.
fn existing_ancestor(place: &Path) -> Result<PathBuf, WriteError> {
    let found = place.ancestors().find(|ancestor| ancestor.exists()).unwrap_or(place);
    if found.is_dir() { Ok(found.to_path_buf()) } else { Err(WriteError::new(found, WriteProblem::IsFile)) }
}

fn write_synced(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut file = File::create_new(path)?;
    file.write_all(content)?;
    file.sync_all()
}

/// The folder that holds an absolute path; the root holds itself.
fn parent(path: &Path) -> PathBuf {
    path.parent().unwrap_or(path).to_path_buf()
}
