//! What the documentation tells people to type: the program understands it, and the tutorial's output is what it prints.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{folder, palpate};

/// Pages with commands, from the root of the repository.
const PAGES: [&str; 10] = [
    "README.md",
    "examples/README.md",
    "docs/tutorial.md",
    "docs/how-to-own-sensor.md",
    "docs/hardware.md",
    "docs/live.md",
    "docs/sweeps.md",
    "docs/formats.md",
    "docs/paper.md",
    "docs/performance.md",
];

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn page(name: &str) -> String {
    fs::read_to_string(repository().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The arguments of a line that calls the program, installed or from a clone.
fn arguments(line: &str) -> Option<Vec<String>> {
    let line = line.strip_prefix("    ").unwrap_or(line);
    let (start, rest) = line.split_once(' ')?;
    let rest = match start {
        "palpate" => rest,
        "cargo" if !rest.contains("xtask") => rest.strip_prefix("run ")?.split_once("-- ")?.1,
        _ => return None,
    };
    let command = [" #", " | ", " > "].iter().fold(rest, |rest, end| rest.split(end).next().unwrap_or_default());
    Some(command.split_whitespace().map(str::to_owned).collect())
}

/// The blocks of a page between fences: their language, their text, and the paragraph before.
fn blocks(page: &str) -> Vec<(&str, &str, &str)> {
    let parts: Vec<&str> = page.split("```").collect();
    let pairs = parts.chunks_exact(2).filter_map(|pair| Some((pair[0], pair[1].split_once('\n')?)));
    pairs.map(|(before, (language, text))| (language, text, before.trim())).collect()
}

/// All commands of a page, in blocks between fences or set off by blanks.
fn commands(page: &str) -> Vec<Vec<String>> {
    let fenced =
        blocks(page).into_iter().filter(|(language, ..)| *language == "sh").flat_map(|(_, text, _)| text.lines());
    let indented = page.lines().filter(|line| line.starts_with("    "));
    fenced.chain(indented).filter_map(arguments).collect()
}

#[test]
fn every_command_of_the_documentation_is_understood() {
    let dir = folder();
    let mut count = 0;
    for name in PAGES {
        for command in commands(&page(name)) {
            // What is unknown is refused before help is given.
            let mut asked: Vec<&str> = command.iter().map(String::as_str).collect();
            asked.push("--help");
            let ran = palpate(dir.path(), &asked);
            assert_eq!(ran.code, Some(0), "{name}: palpate {}\n{}", command.join(" "), ran.stderr);
            count += 1;
        }
    }
    assert!(count > 20, "{count}");
}

/// Whether two outputs say the same, their figures to a fifth or to next to nothing: rounding, and what it does to small errors, differs
/// between machines.
fn agree(printed: &str, documented: &str) -> bool {
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let (printed, documented) = (words(printed), words(documented));
    let number = |word: &str| word.trim_matches(|c: char| "(),;".contains(c)).parse::<f64>().ok();
    let alike = |(a, b): (&String, &String)| match (number(a), number(b)) {
        (Some(a), Some(b)) => (a - b).abs() <= (0.2 * a.abs().max(b.abs())).max(3e-5),
        _ => a == b,
    };
    printed.len() == documented.len() && printed.iter().zip(&documented).all(alike)
}

#[test]
fn the_tutorial_shows_what_is_printed() {
    let dir = folder();
    let text = page("docs/tutorial.md");
    let mut printed: Option<String> = None;
    let (mut ran, mut shown) = (0, 0);
    for (language, block, before) in blocks(&text) {
        if language == "sh" {
            let command = block.lines().find_map(arguments).expect("a command of the program");
            // The last one is about a log of the reader's.
            if command.contains(&"trial.csv".to_owned()) {
                continue;
            }
            let examples = |argument: &String| match argument.strip_prefix("examples/") {
                Some(path) => repository().join("examples").join(path).display().to_string(),
                None => argument.clone(),
            };
            let command: Vec<String> = command.iter().map(examples).collect();
            let output = palpate(dir.path(), &command.iter().map(String::as_str).collect::<Vec<_>>());
            assert_eq!(output.code, Some(0), "{command:?}: {}", output.stderr);
            printed = Some(output.stdout);
            ran += 1;
        } else if before.is_empty() {
            let printed = printed.take().expect("output follows a command");
            assert!(agree(&printed, block), "printed:\n{printed}\nin the tutorial:\n{block}");
            shown += 1;
        } else if let Some(file) = before.rsplit('\n').next().and_then(|line| line.strip_prefix('`')?.split('`').next())
        {
            let Ok(content) = fs::read_to_string(dir.path().join(file)) else { continue };
            let first: String = content.lines().take(block.lines().count()).collect::<Vec<_>>().join("\n");
            assert!(
                agree(&first.replace(',', " "), &block.replace(',', " ")),
                "{file}:\n{first}\nin the tutorial:\n{block}"
            );
            shown += 1;
        }
    }
    assert!(ran > 4 && shown > 4, "{ran} commands, {shown} outputs");
}

/// Errors in millimetres and degrees as documented; on other processors, rounding may differ.
#[test]
fn the_errors_on_the_logs_of_the_paper_are_as_documented() {
    let dir = folder();
    let ran = palpate(dir.path(), &["paper", "--quiet", "-o", "out"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let errors = fs::read_to_string(dir.path().join("out/errors.csv")).expect("there is a table");
    let page = page("docs/paper.md");
    for row in errors.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let begin = format!("| {} | {} | ", cells[0], cells[1]);
        let told = page.lines().find_map(|line| line.strip_prefix(&begin)).unwrap_or_else(|| panic!("{begin}"));
        let units = [1e3, 1e3, 1f64.to_degrees(), 1e3, 1e3];
        for ((found, told), unit) in cells[2..7].iter().zip(told.split(" | ")).zip(units) {
            let [found, told] = [found, told].map(|number| number.parse::<f64>().expect("a number"));
            // Errors of exact readings are those of rounding.
            let off = (unit * found - told).abs();
            assert!(off < 0.1 * told.abs() || off < 1e-4, "{row}: {told} in docs/paper.md; cargo xtask paper --write");
        }
        assert!(told.ends_with(&format!("| {} |", cells[7])), "{row} in docs/paper.md: {told}");
    }
}
