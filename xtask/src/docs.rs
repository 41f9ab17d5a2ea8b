//! Tests of what the documentation says of the source: files that it names exist, layers are those of the imports, and constants have
//! the values given, tasks can be called.

use std::fs;
use std::path::{Path, PathBuf};

use clap::CommandFactory;

use crate::workspace;

/// Pages that name files of the source.
const PAGES: [&str; 4] = ["docs/architecture.md", "docs/constants.md", "docs/paper.md", "CONTRIBUTING.md"];

/// The source of the library, from which the pages name files.
const LIBRARY: &str = "crates/palpate/src";

fn page(name: &str) -> String {
    fs::read_to_string(workspace::root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// All Rust files below a folder, or the file itself.
fn sources(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_path_buf()];
    }
    let entries = fs::read_dir(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .filter(|path| path.is_dir() || path.extension().is_some_and(|end| end == "rs"))
        .flat_map(|path| sources(&path))
        .collect()
}

/// What stands between backticks, code blocks left out.
fn quoted(text: &str) -> Vec<&str> {
    let prose = text.split("```").step_by(2);
    prose.flat_map(|prose| prose.lines().flat_map(|line| line.split('`').skip(1).step_by(2))).collect()
}

#[test]
fn every_file_that_the_documentation_names_exists() {
    let root = workspace::root();
    let all: Vec<PathBuf> = ["crates", "xtask"].iter().flat_map(|folder| sources(&root.join(folder))).collect();
    for name in PAGES {
        let text = page(name);
        let plain = |quoted: &&str| quoted.chars().all(|c| c.is_ascii_alphanumeric() || "_./-".contains(c));
        let paths = quoted(&text).into_iter().filter(plain).filter(|path| path.ends_with(".rs") || path.ends_with('/'));
        let mut count = 0;
        for path in paths {
            let folders = [root.clone(), root.join(LIBRARY), root.join(LIBRARY).join("estimate")];
            let anywhere = !path.contains('/') && all.iter().any(|file| file.ends_with(path));
            let found = anywhere || folders.iter().any(|folder| folder.join(path).exists());
            assert!(found, "{name} names `{path}`, which does not exist");
            count += 1;
        }
        assert!(count > 2, "{name} names {count} files");
    }
}

/// The cells of the rows of the tables in a text.
fn rows(text: &str) -> impl Iterator<Item = Vec<&str>> {
    let lines = text.lines().filter(|line| line.starts_with("| `"));
    lines.map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
}

/// The layers of the architecture between two markers, in their order.
fn layers(marker: &str) -> Vec<String> {
    let text = page("docs/architecture.md");
    let (begin, end) = (format!("<!-- BEGIN {marker} -->"), format!("<!-- END {marker} -->"));
    let inside = text.split(&begin).nth(1).and_then(|rest| rest.split(&end).next()).expect("the markers are there");
    rows(inside).map(|row| row[0].trim_matches('`').to_owned()).collect()
}

/// Each layer uses, as `PREFIX::NAME`, only layers that stand before it.
fn check_layers(folder: &Path, prefix: &str, layers: &[String]) {
    let module = |layer: &str| layer.trim_end_matches('/').trim_end_matches(".rs").to_owned();
    let modules: Vec<String> = layers.iter().map(|layer| module(layer)).collect();
    for (place, layer) in layers.iter().enumerate() {
        let files = sources(&folder.join(layer)).into_iter().filter(|file| !file.ends_with("tests.rs"));
        for file in files {
            let text = fs::read_to_string(&file).expect("it can be read");
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
            for used in lines.flat_map(|line| line.split(prefix).skip(1)) {
                let used: String = used.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
                let of = modules.iter().position(|module| *module == used);
                assert!(of.is_none_or(|of| of <= place), "{} uses {prefix}{used}, a later layer", file.display());
            }
        }
    }
}

/// Everything in a folder is a layer, but for these.
fn check_complete(folder: &Path, layers: &[String], others: &[&str]) {
    for entry in fs::read_dir(folder).expect("the folder is there") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        let name = if path.is_dir() { name + "/" } else { name };
        let is_tests = path.is_dir() && sources(&path).iter().all(|file| file.ends_with("tests.rs"));
        assert!(layers.contains(&name) || others.contains(&name.as_str()) || is_tests, "{name} is no layer");
    }
}

#[test]
fn each_layer_of_the_library_uses_only_those_before_it() {
    let folder = workspace::root().join(LIBRARY);
    let layers = layers("layers");
    check_complete(&folder, &layers, &["lib.rs", "number_or_null.rs"]);
    check_layers(&folder, "crate::", &layers);
}

#[test]
fn each_layer_of_the_kernel_uses_only_those_before_it() {
    let folder = workspace::root().join(LIBRARY).join("estimate");
    let layers = layers("kernel");
    check_complete(&folder, &layers, &["mod.rs"]);
    check_layers(&folder, "crate::estimate::", &layers);
}

#[test]
fn every_constant_of_the_documentation_has_its_value() {
    let text = page("docs/constants.md");
    let named =
        |row: &Vec<&str>| row[0].chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || "`_".contains(c));
    let mut count = 0;
    for row in rows(&text).filter(named) {
        let [name, value, file, _] = row[..] else { panic!("four cells: {row:?}") };
        let (name, file) = (name.trim_matches('`'), file.trim_matches('`'));
        let source = page(&format!("{LIBRARY}/{file}"));
        let declared = source
            .split(&format!("const {name}:"))
            .nth(1)
            .and_then(|rest| rest.split_inclusive(';').find(|part| part.contains('=')));
        let declared = declared.unwrap_or_else(|| panic!("{file} has no constant {name}"));
        let given = declared.split_whitespace().collect::<Vec<_>>().join(" ");
        let given = given.split_once("= ").map_or("", |(_, given)| given.trim_end_matches(';'));
        let given = given.strip_prefix("Nats(").map_or(given, |nats| nats.trim_end_matches(')'));
        assert_eq!(given, value, "{name} in {file}");
        count += 1;
    }
    assert!(count > 60, "{count}");
}

#[test]
fn every_task_that_the_documentation_names_exists() {
    let pages = [
        "README.md",
        "docs/paper.md",
        "docs/monte-carlo.md",
        "docs/performance.md",
        "docs/rust-api.md",
        "fuzz/README.md",
    ];
    let mut count = 0;
    for name in pages.into_iter().chain(PAGES) {
        let text = page(name);
        let commands = text.lines().filter_map(|line| line.trim_start().strip_prefix("cargo xtask "));
        for command in commands.map(|command| command.split(['#', '[']).next().unwrap_or_default()) {
            // What is unknown is refused before help is given.
            let asked = ["cargo xtask"].into_iter().chain(command.split_whitespace()).chain(["--help"]);
            let answer = crate::Arguments::command().try_get_matches_from(asked).expect_err("help");
            assert_eq!(answer.kind(), clap::error::ErrorKind::DisplayHelp, "{name}: cargo xtask {command}: {answer}");
            count += 1;
        }
    }
    assert!(count > 15, "{count}");
}
