//! `cargo xtask dist`: everything that is handed to others, in one folder: the program as an archive and as a Debian package, the Python package
//! as a wheel and as source, the crates, the licences and lists of the libraries in them, and checksums.

pub mod crates;
mod notices;
mod program;
mod python_package;
mod try_out;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::Context;

use crate::workspace;

/// Name of the file with the checksums.
const CHECKSUMS: &str = "SHA256SUMS";

/// Options of `cargo xtask dist`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Install and use each in a place of its own without Rust, and run the tests of the crates as they are packed
    #[arg(long = "try")]
    try_out: bool,
    /// Only these
    #[arg(value_enum, default_values_t = [Part::Program, Part::Python, Part::Crates])]
    parts: Vec<Part>,
}

/// What is handed out.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Part {
    /// The program: archive, Debian package, list of components
    Program,
    /// The Python package: wheel and source
    Python,
    /// The crates
    Crates,
}

/// Makes all of it.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let out = workspace::target().join("distribution");
    fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
    let version = &workspace::version()?;
    let is_asked = |part| arguments.parts.contains(&part);
    if is_asked(Part::Program) {
        let program = program::build(version, &out)?;
        let archive = program::archive(&program, &format!("palpate-{version}-{}", host()?), &out)?;
        if cfg!(target_os = "linux") {
            program::debian_package(&out)?;
        }
        if arguments.try_out {
            try_out::program(&archive)?;
        }
    }
    if is_asked(Part::Python) {
        let wheel = python_package::make(&out)?;
        if arguments.try_out {
            try_out::wheel(&wheel)?;
        }
    }
    if is_asked(Part::Crates) {
        let packed = crates::pack(&out)?;
        if arguments.try_out {
            crates::test(&packed)?;
        }
    }
    write_checksums(&out)?;
    println!("{}", out.display());
    Ok(())
}

/// What the compiler calls this kind of machine.
fn host() -> anyhow::Result<String> {
    let output = Command::new("rustc").arg("-vV").output().context("could not start rustc")?;
    let text = String::from_utf8(output.stdout)?;
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    Ok(host.context("rustc does not name its host")?.to_owned())
}

/// Compiles without the paths of this machine in what comes out.
fn without_paths(command: &mut Command) -> &mut Command {
    let home = std::env::var_os("CARGO_HOME").map(std::path::PathBuf::from);
    let home = home.or_else(|| std::env::home_dir().map(|home| home.join(".cargo"))).unwrap_or_default();
    let remap = |from: &Path, to: &str| format!("--remap-path-prefix={}={to}", from.display());
    let flags = [remap(&home, "cargo"), remap(&workspace::root(), "palpate")].join("\u{1f}");
    command.env("CARGO_ENCODED_RUSTFLAGS", flags)
}

/// Writes the checksums of all files in the folder, as `sha256sum --check` reads them.
fn write_checksums(out: &Path) -> anyhow::Result<()> {
    let files = fs::read_dir(out)?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>()?;
    let mut files: Vec<_> = files.into_iter().filter(|path| path.is_file()).collect();
    files.sort();
    let mut text = String::new();
    for file in files {
        let sum = hmac_sha256::Hash::hash(&fs::read(&file).with_context(|| file.display().to_string())?);
        let sum = sum.iter().fold(String::new(), |sum, byte| sum + &format!("{byte:02x}"));
        writeln!(text, "{sum}  {}", file.file_name().unwrap_or_default().display())?;
    }
    Ok(fs::write(out.join(CHECKSUMS), text)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_those_of_the_files() {
        let folder = workspace::empty(&workspace::target().join("tests/checksums")).expect("a folder");
        fs::write(folder.join("b"), "").expect("a file");
        fs::write(folder.join("a"), "abc").expect("a file");
        write_checksums(&folder).expect("sums");
        assert_eq!(
            fs::read_to_string(folder.join(CHECKSUMS)).expect("sums"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  a\n\
             e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855  b\n"
        );
    }
}
