//! Tests of what is published: complete packages, dependencies of known licences, and a minimal program without heavy libraries.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::dist::crates::PUBLISHED;
use crate::workspace;

/// What a command prints.
fn printed(command: &mut Command) -> String {
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// All packages that the workspace needs, on any machine and with any feature, and itself.
fn packages() -> Vec<Value> {
    let json = printed(workspace::cargo().args(["metadata", "--format-version", "1", "--all-features", "--locked"]));
    let metadata: Value = serde_json::from_str(&json).expect("JSON");
    metadata["packages"].as_array().expect("a list").clone()
}

/// The files of a package.
fn listed(package: &str) -> String {
    printed(workspace::cargo().args(["package", "--list", "--allow-dirty", "--package", package]))
}

fn folder(package: &str) -> PathBuf {
    workspace::root().join("crates").join(package)
}

/// Rust files of a package.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let inside = |path: PathBuf| if path.is_dir() { sources(&path) } else { vec![path] };
    entries.flat_map(inside).filter(|path| path.extension().is_some_and(|end| end == "rs")).collect()
}

#[test]
fn packages_have_what_a_registry_asks_for() {
    let all = packages();
    for name in PUBLISHED {
        let package = all.iter().find(|package| package["name"] == name).expect(name);
        assert!(package["description"].as_str().is_some_and(|text| text.len() > 40), "{name}");
        assert_eq!(package["license"], "MIT OR Apache-2.0", "{name}");
        for list in ["keywords", "categories"] {
            assert!((1..=5).contains(&package[list].as_array().expect("a list").len()), "{name}: {list}");
        }
        // Both are filled in at one place, the workspace.
        assert!(package["repository"].is_string() && package["documentation"].is_string(), "{name}");
        let listed = listed(name);
        for file in ["README.md", "LICENSE-MIT", "LICENSE-APACHE"] {
            assert!(listed.lines().any(|line| line == file), "{name} has no {file}");
        }
    }
}

#[test]
fn no_package_reads_what_is_not_in_it() {
    for name in PUBLISHED {
        let root = folder(name);
        let listed = listed(name);
        let packed =
            |path: &Path| listed.lines().any(|line| path.strip_prefix(&root).is_ok_and(|path| path == Path::new(line)));
        for file in sources(&root).into_iter().filter(|path| packed(path)) {
            let text = fs::read_to_string(&file).expect("text");
            let included = text.split("include_str!(\"").skip(1).filter_map(|rest| rest.split('"').next());
            let beside = file.parent().expect("a folder");
            for path in included {
                // Not what a link leads to: cargo packs the file itself.
                let path = beside.join(path).components().fold(PathBuf::new(), |path, part| match part {
                    std::path::Component::ParentDir => path.parent().map(Path::to_path_buf).unwrap_or_default(),
                    part => path.join(part),
                });
                assert!(path.starts_with(&root), "{} includes {}", file.display(), path.display());
            }
            assert!(!text.contains("join(\"../.."), "{} reads what is beside its package", file.display());
        }
    }
}

#[test]
fn a_minimal_program_needs_no_heavy_library() {
    let tree = |arguments: &[&str]| {
        let mut tree = workspace::cargo();
        tree.args(["tree", "--locked", "--package", "palpate-cli", "--edges", "normal", "--prefix", "none"]);
        printed(tree.args(arguments))
    };
    let (whole, minimal) = (tree(&[]), tree(&["--no-default-features"]));
    for heavy in ["parquet v", "resvg v", "dejavu v"] {
        assert!(whole.contains(heavy) && !minimal.contains(heavy), "{heavy}");
    }
}

#[test]
fn licences_of_all_dependencies_are_allowed() {
    let rules = fs::read_to_string(workspace::root().join("deny.toml")).expect("rules");
    let rules: toml::Table = rules.parse().expect("TOML");
    let allowed = rules["licenses"]["allow"].as_array().expect("a list");
    let allowed: Vec<spdx::Licensee> =
        allowed.iter().map(|name| spdx::Licensee::parse(name.as_str().expect("a name")).expect("a licence")).collect();
    let all = packages();
    assert!(all.len() > 100, "{}", all.len());
    for package in all {
        let licence = package["license"].as_str().unwrap_or_default();
        let expression = spdx::Expression::parse_mode(licence, spdx::ParseMode::LAX);
        let expression = expression.unwrap_or_else(|error| panic!("{}: {error}", package["name"]));
        let is_allowed = expression.evaluate(|asked| allowed.iter().any(|licence| licence.satisfies(asked)));
        assert!(is_allowed, "{}: {licence}", package["name"]);
    }
}
