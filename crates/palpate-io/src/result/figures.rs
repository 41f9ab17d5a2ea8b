//! A folder of figures with a page that shows them, there as a whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use crate::folder::FolderKind;
use crate::write_error::WriteError;

/// The page of a folder of figures.
const PAGE_FILE: &str = "index.html";
/// What our pages say of themselves.
const MARK: &str = "<meta name=\"generator\" content=\"palpate paper\">";

fn kind<'a>(files: &'a [&'a str]) -> FolderKind<'a> {
    FolderKind {
        kind: "set of figures",
        files,
        numbered: None,
        mark: PAGE_FILE,
        is_mark: |path| fs::read_to_string(path).is_ok_and(|text| text.contains(MARK)),
    }
}

/// Whether [`write_figures`] could write files of these names to `dir`, asked before a long computation. Nothing is left behind.
///
/// # Errors
/// `dir` is a file, the current folder, or holds anything but an earlier set of these figures; or no folder can be made there.
pub fn check_figures_target(dir: &Path, names: &[&str]) -> Result<(), WriteError> {
    kind(names).check(dir)
}

/// Writes a folder of files, `index.html` among them, in place of an earlier one: aside first, and renamed.
///
/// # Errors
/// As [`check_figures_target`], or the disk is full. What was there before is then untouched.
pub fn write_figures(dir: &Path, files: &[(&str, &[u8])]) -> Result<(), WriteError> {
    let names: Vec<&str> = files.iter().map(|(name, _)| *name).collect();
    let files: Vec<(PathBuf, &[u8])> = files.iter().map(|(name, content)| (PathBuf::from(name), *content)).collect();
    kind(&names).write(dir, &files)
}
