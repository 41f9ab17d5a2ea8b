//! A folder of figures with a page that shows them, there as a whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use palpate::Truth;

use crate::folder::FolderKind;
use crate::truth::{TRUTH_FILES, truth_csv};
use crate::write_error::WriteError;

/// The page of a folder of figures.
const PAGE_FILE: &str = "index.html";
/// What our pages say of themselves.
const MARK: &str = "<meta name=\"generator\" content=\"palpate paper\">";

fn kind<'a>(files: &'a [&'a str], truths: &'a [&'a str]) -> FolderKind<'a> {
    FolderKind {
        kind: "set of figures",
        files,
        numbered: None,
        folders: (truths, TRUTH_FILES),
        mark: PAGE_FILE,
        is_mark: |path| fs::read_to_string(path).is_ok_and(|text| text.contains(MARK)),
    }
}

/// Whether [`write_figures`] could write files and truth folders of these names to `dir`, asked before a long computation. Nothing is
/// left behind.
///
/// # Errors
/// `dir` is a file, the current folder, or holds anything but an earlier set of these figures; or no folder can be made there.
pub fn check_figures_target(dir: &Path, files: &[&str], truths: &[&str]) -> Result<(), WriteError> {
    kind(files, truths).check(dir)
}

/// Writes a folder of files, `index.html` among them, and of truth folders, in place of an earlier one: aside first, and renamed.
///
/// # Errors
/// As [`check_figures_target`], or the disk is full. What was there before is then untouched.
pub fn write_figures(dir: &Path, files: &[(&str, &[u8])], truths: &[(&str, &Truth)]) -> Result<(), WriteError> {
    let names: Vec<&str> = files.iter().map(|(name, _)| *name).collect();
    let folders: Vec<&str> = truths.iter().map(|(name, _)| *name).collect();
    let tables: Vec<[String; 2]> = truths.iter().map(|(_, truth)| truth_csv(truth)).collect();
    let of_truths = folders.iter().zip(&tables).flat_map(|(folder, tables)| {
        TRUTH_FILES.iter().zip(tables).map(move |(file, text)| (Path::new(folder).join(file), text.as_bytes()))
    });
    let files = files.iter().map(|(name, content)| (PathBuf::from(name), *content));
    kind(&names, &folders).write(dir, &files.chain(of_truths).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use palpate::truth::TruePose;

    use super::*;
    use crate::truth::read_truth;

    #[test]
    fn figures_with_truths_are_made_again_and_nothing_foreign_is_lost() {
        let folder = tempfile::tempdir().expect("a folder");
        let dir = folder.path().join("figures");
        let pose = TruePose { time_s: 0.0, psi_rad: 0.5, com_x_m: 0.0, com_y_m: 0.1 };
        let support = (0..8).map(|step| (0.5 * f64::from(step), 0.03)).collect();
        let truth = Truth { support, motion: vec![pose, TruePose { time_s: 1.0, ..pose }] };
        let write = |page: &str| {
            write_figures(&dir, &[(PAGE_FILE, format!("{MARK}{page}").as_bytes())], &[("one.truth", &truth)])
        };
        write("first").expect("it can be written");
        check_figures_target(&dir, &[PAGE_FILE], &["one.truth"]).expect("it may be replaced");
        write("second").expect("it is replaced");
        assert!(fs::read_to_string(dir.join(PAGE_FILE)).expect("a page").ends_with("second"));
        assert_eq!(read_truth(&dir.join("one.truth")).expect("a truth"), truth);
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);

        // As a file in it, in a truth, or a folder that is none of them.
        for foreign in ["thesis.tex", "one.truth/notes.txt", "two.truth/shape.csv"] {
            let path = dir.join(foreign);
            fs::create_dir_all(path.parent().expect("a folder")).expect("it can be made");
            fs::write(&path, "years of work").expect("it can be written");
            let told = [write("third"), check_figures_target(&dir, &[PAGE_FILE], &["one.truth"])]
                .map(|refused| refused.expect_err("it would be lost").to_string());
            let name = if foreign.starts_with("two") { "two.truth" } else { foreign };
            assert!(told.iter().all(|told| told.contains(name)), "{told:?}");
            fs::remove_file(&path).expect("it is there");
            let _ = fs::remove_dir(dir.join("two.truth"));
        }
    }
}
