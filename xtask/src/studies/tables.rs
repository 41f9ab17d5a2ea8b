//! The tables of the documentation, each written by the command that made it.
//!
//! A table stands between two comments that no reader sees:
//!
//! ```text
//! <!-- BEGIN table: NAME (COMMAND) -->
//! <!-- END table -->
//! ```
//!
//! What stands between them is replaced, and COMMAND becomes the command that was run, so that it never says anything else.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use crate::workspace;

const END: &str = "<!-- END table -->";

/// Option of every task that makes tables of the documentation.
#[derive(clap::Args)]
pub struct Write {
    /// Write the tables into the documentation as well; with DIR, into a copy of it there
    #[arg(long, value_name = "DIR", num_args = 0..=1, default_missing_value = "")]
    write: Option<OsString>,
}

/// Where a table stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The file, from the root of the workspace.
    file: &'static str,
    /// The name in the markers.
    name: &'static str,
}

/// `cargo xtask monte-carlo`, in short.
pub const ACCURACY: Place = Place { file: "README.md", name: "accuracy" };
/// `cargo xtask monte-carlo`.
pub const MONTE_CARLO: Place = Place { file: "docs/monte-carlo.md", name: "monte-carlo" };
/// `cargo xtask monte-carlo --jumps`.
pub const MONTE_CARLO_JUMPS: Place = Place { file: "docs/monte-carlo.md", name: "monte-carlo-jumps" };
/// `cargo xtask monte-carlo --jumps` from several seeds.
pub const MONTE_CARLO_SETS: Place = Place { file: "docs/monte-carlo.md", name: "monte-carlo-sets" };
/// `cargo xtask monte-carlo --jumps --varied`.
pub const MONTE_CARLO_VARIED: Place = Place { file: "docs/monte-carlo.md", name: "monte-carlo-varied" };
/// `cargo xtask monte-carlo --jumps --varied --well-felt`.
pub const MONTE_CARLO_WELL_FELT: Place = Place { file: "docs/monte-carlo.md", name: "monte-carlo-well-felt" };
/// `cargo xtask monte-carlo --jumps --symmetric`.
pub const MONTE_CARLO_SYMMETRIC: Place = Place { file: "docs/monte-carlo.md", name: "monte-carlo-symmetric" };
/// `cargo xtask monte-carlo --jumps --rig`.
pub const MONTE_CARLO_RIG: Place = Place { file: "docs/monte-carlo.md", name: "monte-carlo-rig" };
/// `cargo xtask monte-carlo --friction`.
pub const MONTE_CARLO_FRICTION: Place = Place { file: "docs/monte-carlo.md", name: "monte-carlo-friction" };
/// `cargo xtask monte-carlo --fast`.
pub const MONTE_CARLO_FAST: Place = Place { file: "docs/monte-carlo.md", name: "monte-carlo-fast" };
/// `cargo xtask monte-carlo-pivot`.
pub const MONTE_CARLO_PIVOT: Place = Place { file: "docs/monte-carlo.md", name: "monte-carlo-pivot" };
/// `cargo xtask monte-carlo-pivot --mujoco`.
pub const MONTE_CARLO_PIVOT_MUJOCO: Place = Place { file: "docs/monte-carlo.md", name: "monte-carlo-pivot-mujoco" };
/// `cargo xtask limits --jumps`.
pub const LIMITS: Place = Place { file: "docs/constants.md", name: "limits" };
/// `cargo xtask methods`.
pub const METHODS: Place = Place { file: "docs/paper.md", name: "methods" };
/// `cargo xtask methods --logs`.
pub const METHODS_LOGS: Place = Place { file: "docs/paper.md", name: "methods-logs" };
/// `cargo xtask methods --exact`, convergence.
pub const METHODS_STEPS: Place = Place { file: "docs/paper.md", name: "methods-steps" };
/// `cargo xtask methods --exact`, places where the equations are ill-conditioned.
pub const METHODS_CROSSINGS: Place = Place { file: "docs/paper.md", name: "methods-crossings" };
/// `cargo xtask slips`.
pub const SLIPS: Place = Place { file: "docs/verdict.md", name: "slips" };
/// `cargo xtask paper`.
pub const PAPER: Place = Place { file: "docs/paper.md", name: "paper" };
/// `cargo xtask bench-peers`, smoothing.
pub const PEERS_SMOOTHING: Place = Place { file: "docs/performance.md", name: "peers-smoothing" };
/// `cargo xtask bench-peers`, all but smoothing.
pub const PEERS: Place = Place { file: "docs/performance.md", name: "peers" };

/// `cargo xtask bench-live`, time and memory.
pub const LIVE_SPEED: Place = Place { file: "docs/live.md", name: "live-speed" };
/// `cargo xtask bench-live`, against the batch estimator.
pub const LIVE_DISTANCE: Place = Place { file: "docs/live.md", name: "live-distance" };

/// A table of the documentation, with the lines that belong to it, and where it stands.
pub type Table = (Place, String);

impl Write {
    /// Fails where a table that is to be written has no place: better before a study than after it.
    pub fn check(&self, places: &[Place]) -> anyhow::Result<()> {
        if self.write.is_some() && places.is_empty() {
            bail!("no table of the documentation is made with these options; leave --write out");
        }
        let tables: Vec<Table> = places.iter().map(|place| (*place, String::new())).collect();
        self.replaced(&tables, "").map(drop)
    }

    /// Puts the tables where they belong, if that was asked for: all of them, or none where a marker is missing.
    pub fn tables(&self, tables: &[Table], command: &str) -> anyhow::Result<()> {
        for (path, text) in self.replaced(tables, command)? {
            palpate_io::write_whole(&path, text.as_bytes())?;
            eprintln!("tables written: {}", path.display());
        }
        Ok(())
    }

    /// The root of the documentation that is written; `None` where nothing is.
    pub fn root(&self) -> Option<PathBuf> {
        let root = self.write.as_ref()?;
        Some(if root.is_empty() { workspace::root() } else { PathBuf::from(root) })
    }

    /// The files with these tables in them; none where nothing is to be written.
    fn replaced(&self, tables: &[Table], command: &str) -> anyhow::Result<BTreeMap<PathBuf, String>> {
        let mut files = BTreeMap::new();
        let Some(root) = self.root() else { return Ok(files) };
        for (place, table) in tables {
            let path = root.join(place.file);
            let text = match files.remove(&path) {
                Some(text) => text,
                None => read(&path)?,
            };
            let text = replaced(&text, place.name, table, command).with_context(|| path.display().to_string())?;
            files.insert(path, text);
        }
        Ok(files)
    }
}

fn read(path: &Path) -> anyhow::Result<String> {
    fs::read_to_string(path).with_context(|| path.display().to_string())
}

/// The text with this table between its markers.
fn replaced(text: &str, name: &str, table: &str, command: &str) -> anyhow::Result<String> {
    let begin = format!("<!-- BEGIN table: {name} (");
    let mut places = text.match_indices(&begin).map(|(place, _)| place);
    let start = match (places.next(), places.next()) {
        (Some(start), None) => start,
        (None, _) => bail!("the marker `{begin}COMMAND) -->` is missing; put it where the table is to stand"),
        (Some(_), Some(_)) => bail!("the marker of the table {name} stands there more than once"),
    };
    let inside = &text[start + begin.len()..];
    let length = inside.find(END).with_context(|| format!("the marker `{END}` of the table {name} is missing"))?;
    if inside[..length].contains("<!-- BEGIN table:") {
        bail!("the marker `{END}` of the table {name} is missing before the next table begins");
    }
    let (before, after) = (&text[..start], &inside[length..]);
    Ok(format!("{before}{begin}{command}) -->\n{}\n{after}", table.trim_end()))
}

/// The documentation has all rows of this table; numbers may be off by a share of themselves, as another processor rounds otherwise.
#[cfg(test)]
pub fn assert_documented(place: Place, table: &str, share: f64) {
    let page = read(&workspace::root().join(place.file)).expect("the page is there");
    let begin = format!("<!-- BEGIN table: {} (", place.name);
    let inside = page.split(&begin).nth(1).and_then(|rest| rest.split(END).next()).expect("the markers are there");
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let documented: Vec<Vec<String>> = inside.lines().filter(|line| line.starts_with('|')).map(cells).collect();
    let is_same = |(found, told): (&String, &String)| match (found.parse::<f64>(), told.parse::<f64>()) {
        // The last digit is rounded.
        (Ok(found), Ok(told)) => (found - told).abs() <= share * told.abs() + 1e-5,
        _ => found == told,
    };
    for row in table.lines().filter(|line| line.starts_with('|')).map(cells) {
        let found = documented.iter().any(|told| told.len() == row.len() && row.iter().zip(told).all(is_same));
        assert!(found, "{} has no such row in the table {}; make it again: {row:?}", place.file, place.name);
    }
}

#[cfg(test)]
mod tests {
    use clap::{Args as _, FromArgMatches as _};

    use super::*;

    const PAGE: &str = "Before.\n\n<!-- BEGIN table: one (old) -->\n| 1 |\n<!-- END table -->\n\n\
                        <!-- BEGIN table: one-more (older) -->\n<!-- END table -->\nAfter.\n";

    const TABLE: &str = "| a |\n|---|\n| 2 |\n";

    #[test]
    fn a_table_is_replaced_and_nothing_else() {
        let once = replaced(PAGE, "one", TABLE, "cargo xtask new").expect("the markers are there");
        let expected = PAGE.replace("(old) -->\n| 1 |\n", "(cargo xtask new) -->\n| a |\n|---|\n| 2 |\n");
        assert_eq!(once, expected);
        assert_eq!(replaced(&once, "one", TABLE, "cargo xtask new").expect("the markers are there"), once);
    }

    #[test]
    fn an_empty_place_is_filled() {
        let page = replaced(PAGE, "one-more", TABLE, "new").expect("the markers are there");
        assert!(
            page.ends_with("<!-- BEGIN table: one-more (new) -->\n| a |\n|---|\n| 2 |\n<!-- END table -->\nAfter.\n")
        );
        assert!(page.contains("| 1 |"));
    }

    #[test]
    fn a_missing_marker_is_named() {
        let said = |page: &str, name| replaced(page, name, TABLE, "new").expect_err("a marker is missing").to_string();
        assert!(said(PAGE, "two").contains("`<!-- BEGIN table: two (COMMAND) -->` is missing"));
        let open = PAGE.replacen("<!-- END table -->\n", "", 1);
        assert!(said(&open, "one").contains("table one is missing before the next table begins"));
        let open = PAGE.replace("<!-- END table -->\n", "");
        assert!(said(&open, "one-more").contains("of the table one-more is missing"));
        assert!(said(&PAGE.replace("one-more", "one"), "one").contains("more than once"));
    }

    #[test]
    fn nothing_is_written_where_a_marker_is_missing() {
        const ONE: Place = Place { file: "page.md", name: "one" };
        const MORE: Place = Place { file: "page.md", name: "one-more" };
        const NOWHERE: Place = Place { file: "page.md", name: "two" };
        let folder = std::env::temp_dir().join(format!("palpate-tables-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        fs::write(folder.join("page.md"), PAGE).expect("it can be written");
        let write = Write { write: Some(folder.clone().into()) };
        let checked = [&[ONE, MORE][..], &[ONE, NOWHERE], &[]].map(|places| write.check(places).is_ok());
        let half = write.tables(&[(ONE, TABLE.to_owned()), (NOWHERE, TABLE.to_owned())], "new");
        let untouched = read(&folder.join("page.md"));
        let whole = write.tables(&[(ONE, TABLE.to_owned()), (MORE, TABLE.to_owned())], "new");
        let written = read(&folder.join("page.md"));
        fs::remove_dir_all(&folder).expect("it can be removed");
        assert_eq!(checked, [true, false, false]);
        assert!(half.is_err() && whole.is_ok());
        assert_eq!(untouched.expect("it is there"), PAGE);
        let written = written.expect("it is there");
        assert_eq!(written.matches("(new) -->\n| a |\n|---|\n| 2 |\n<!-- END table -->").count(), 2);
    }

    #[test]
    fn the_documentation_has_a_place_for_every_table() {
        let places = [
            ACCURACY,
            MONTE_CARLO,
            MONTE_CARLO_JUMPS,
            MONTE_CARLO_SETS,
            LIMITS,
            METHODS,
            METHODS_LOGS,
            METHODS_STEPS,
            METHODS_CROSSINGS,
            PAPER,
        ];
        let write = Write { write: Some(OsString::new()) };
        write.check(&places).expect("the markers are there");
        write.check(&[PEERS_SMOOTHING, PEERS]).expect("the markers are there");
    }

    #[test]
    fn the_folder_of_the_copy_may_be_left_out() {
        let given = |arguments: &[&str]| {
            let command = Write::augment_args(clap::Command::new("task"));
            let matches = command.try_get_matches_from([&["task"], arguments].concat()).expect("it is understood");
            Write::from_arg_matches(&matches).expect("it is understood").write
        };
        assert_eq!(given(&[]), None);
        assert_eq!(given(&["--write"]), Some(OsString::new()));
        assert_eq!(given(&["--write", "copy"]), Some("copy".into()));
    }
}
