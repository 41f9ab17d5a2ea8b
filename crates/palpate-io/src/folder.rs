//! Files and folders that are written whole or not at all: aside first, then renamed.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::csv::text;
use crate::write_error::{WriteError, WriteProblem};

/// What operating systems leave in every folder that someone looks at.
const CLUTTER: [&str; 3] = [".DS_Store", "Thumbs.db", "desktop.ini"];

/// A kind of folder that may replace an earlier one of its kind, and nothing else.
pub(crate) struct FolderKind<'a> {
    /// In words.
    pub(crate) kind: &'static str,
    /// The files that it has.
    pub(crate) files: &'a [&'a str],
    /// A folder of numbered folders that it may have, and the files of each of those.
    pub(crate) numbered: Option<Numbered>,
    /// Folders that it may have, and the files of all of them.
    pub(crate) folders: (&'a [&'a str], &'static [&'static str]),
    /// The file that tells such a folder from others.
    pub(crate) mark: &'static str,
    /// Whether the content of that file does.
    pub(crate) is_mark: fn(&Path) -> bool,
}

/// A folder that holds folders named 1, 2, 3 ...
#[derive(Clone, Copy)]
pub(crate) struct Numbered {
    /// Its name.
    pub(crate) name: &'static str,
    /// The files of each numbered folder.
    pub(crate) files: &'static [&'static str],
}

impl FolderKind<'_> {
    /// Whether a folder of this kind could be written to `dir`; changes nothing.
    pub(crate) fn check(&self, dir: &Path) -> Result<(), WriteError> {
        let target = self.target(dir)?;
        // The nearest folder that exists is where new ones will be made, the first of them beside the target if it exists.
        let place = existing_ancestor(&parent(&target))?;
        let probe = make_aside(&place, "probe").map_err(|error| WriteError::io(&place, &error))?;
        fs::remove_dir(&probe).map_err(|error| WriteError::io(&probe, &error))
    }

    /// Writes a folder with these files (paths inside it) in place of an earlier one, making parents as needed.
    pub(crate) fn write(&self, dir: &Path, files: &[(PathBuf, &[u8])]) -> Result<(), WriteError> {
        let target = self.target(dir)?;
        let place = parent(&target);
        make_parents(&place)?;
        let failed = |error: io::Error| WriteError::io(dir, &error);
        let staging = Staging(make_aside(&place, "partial").map_err(failed)?);
        for (path, content) in files {
            let file = staging.0.join(path);
            fs::create_dir_all(parent(&file)).map_err(failed)?;
            write_synced(&file, content).map_err(failed)?;
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
        self.remove(&earlier);
        Ok(())
    }

    /// Removes an earlier folder of this kind. What cannot be removed, or came to it in the meantime, stays: no reason to call
    /// the work a failure.
    fn remove(&self, earlier: &Path) {
        let remove = |dir: &Path, files: &[&str]| {
            for name in files.iter().chain(&CLUTTER) {
                let _ = fs::remove_file(dir.join(name));
            }
            let _ = fs::remove_dir(dir);
        };
        if let Some(Numbered { name, files }) = self.numbered {
            let folder = earlier.join(name);
            for number in content(&folder).unwrap_or_default().iter().filter(|name| is_number(name)) {
                remove(&folder.join(number), files);
            }
            remove(&folder, &[]);
        }
        let (folders, files) = self.folders;
        folders.iter().for_each(|name| remove(&earlier.join(name), files));
        remove(earlier, self.files);
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
        let mut names = content(target).map_err(failed)?;
        let mut foreign = None;
        if let Some(numbered) = self.numbered {
            names.retain(|name| name != numbered.name);
            foreign = numbered.foreign(&target.join(numbered.name)).map_err(failed)?;
        }
        let (folders, files) = self.folders;
        for name in folders {
            let folder = target.join(name);
            if fs::symlink_metadata(&folder).is_ok_and(|found| found.is_dir()) {
                names.retain(|other| other != name);
                let file = foreign_file(&folder, &content(&folder).map_err(failed)?, files);
                foreign = foreign.or_else(|| file.map(|file| Path::new(name).join(file)));
            }
        }
        let foreign = foreign.or_else(|| foreign_file(target, &names, self.files)).or_else(|| {
            // All names are ours; so must be the file that tells.
            let first = names.first()?;
            (!(self.is_mark)(&target.join(self.mark))).then(|| PathBuf::from(first))
        });
        match foreign {
            None => Ok(()),
            Some(path) => {
                let found = text::quoted(&path.to_string_lossy());
                Err(WriteError::new(dir, WriteProblem::Foreign { kind: self.kind, found }))
            }
        }
    }
}

impl Numbered {
    /// The first thing in the folder `dir` that is not ours, as a path from the folder around it.
    fn foreign(&self, dir: &Path) -> io::Result<Option<PathBuf>> {
        let found = match fs::symlink_metadata(dir) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            found => found?,
        };
        if !found.is_dir() {
            return Ok(Some(PathBuf::from(self.name)));
        }
        for name in content(dir)? {
            let (folder, path) = (dir.join(&name), Path::new(self.name).join(&name));
            if !is_number(&name) || !fs::symlink_metadata(&folder)?.is_dir() {
                return Ok(Some(path));
            }
            if let Some(file) = foreign_file(&folder, &content(&folder)?, self.files) {
                return Ok(Some(path.join(file)));
            }
        }
        Ok(None)
    }
}

/// Names in a folder but for the clutter, in order.
fn content(dir: &Path) -> io::Result<Vec<OsString>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(dir)? {
        let name = entry?.file_name();
        if !CLUTTER.iter().any(|clutter| name == *clutter) {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

/// The first of the names in `dir` that is none of the files.
fn foreign_file(dir: &Path, names: &[OsString], files: &[&str]) -> Option<PathBuf> {
    let is_file = |name: &OsStr| fs::symlink_metadata(dir.join(name)).is_ok_and(|found| found.is_file());
    let is_ours = |name: &OsString| files.iter().any(|file| name == *file) && is_file(name);
    names.iter().find(|name| !is_ours(name)).map(PathBuf::from)
}

/// Whether a folder is one of those named 1, 2, 3 ...
fn is_number(name: &OsStr) -> bool {
    name.to_str().is_some_and(|name| name.parse::<usize>().is_ok_and(|number| number > 0 && number.to_string() == name))
}

/// Writes one file whole or not at all: aside first, then renamed. Makes parents as needed; a device or pipe is written to directly.
///
/// # Errors
/// `path` is a folder, or cannot be written.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), WriteError> {
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
    let staging = Staging(make_aside(&place, "partial").map_err(failed)?);
    let partial = staging.0.join("file");
    write_synced(&partial, content).map_err(failed)?;
    fs::rename(&partial, &target).map_err(failed)
}

/// A folder that we fill, and that goes with all that is in it when this does, unless it was renamed before.
struct Staging(PathBuf);

impl Drop for Staging {
    fn drop(&mut self) {
        // Best effort: there is no one left to tell.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A folder that goes when this does, unless there is something left in it.
struct Aside(PathBuf);

impl Drop for Aside {
    fn drop(&mut self) {
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
