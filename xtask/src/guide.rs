//! `cargo xtask guide`: the documentation as a site, with search and the references of Python and Rust in it. It needs no network to be
//! read, and no server.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;

use crate::python::Environment;
use crate::{doc, workspace};

/// How the pages are made, from the root of the workspace.
const SETTINGS: &str = "docs/guide";

/// Options of `cargo xtask guide`.
#[derive(Args)]
pub struct Arguments {
    /// Leave the reference of the Rust crates out, which takes longest
    #[arg(long)]
    no_rust: bool,
}

/// Makes the whole site and says where it is.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let environment = Environment::provide()?;
    environment.install_wheel("dev")?;
    let site = pages(&environment)?;
    if !arguments.no_rust {
        // Not what was documented before.
        workspace::empty(&doc::folder())?;
        let reference = doc::make(&doc::LIBRARIES)?;
        workspace::copy_all(&reference, &site.join("rust"))?;
        check_links(&site)?;
    }
    println!("{}", site.join("index.html").display());
    Ok(())
}

/// Makes the site without the reference of the Rust crates, from the Python package that is installed in the environment. A link into
/// nowhere is an error.
pub fn pages(environment: &Environment) -> anyhow::Result<PathBuf> {
    let site = workspace::empty(&workspace::target().join("guide"))?;
    let folder = site.to_string_lossy();
    environment.run(&[
        "sphinx",
        "--quiet",
        "--fail-on-warning",
        "--keep-going",
        "--fresh-env",
        "--doctree-dir",
        &environment.path("doctrees"),
        "--conf-dir",
        SETTINGS,
        ".",
        &folder,
    ])?;
    Ok(site)
}

/// Fails for a link from the pages, those of the crates left out, to a file that is not there.
fn check_links(site: &Path) -> anyhow::Result<()> {
    let mut dead = Vec::new();
    for page in pages_in(site, &["rust", "_static"])? {
        let text = fs::read_to_string(&page).with_context(|| page.display().to_string())?;
        let folder = page.parent().unwrap_or(site);
        for link in links(&text).filter(|link| !folder.join(link).exists()) {
            dead.push(format!("{}: {link}", page.display()));
        }
    }
    if !dead.is_empty() {
        bail!("links into nowhere:\n{}", dead.join("\n"));
    }
    Ok(())
}

/// Pages in a folder and the folders in it, but for some.
fn pages_in(folder: &Path, but: &[&str]) -> anyhow::Result<Vec<PathBuf>> {
    let mut pages = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() && !but.iter().any(|name| path.ends_with(name)) {
            pages.extend(pages_in(&path, but)?);
        } else if path.extension().is_some_and(|end| end == "html") {
            pages.push(path);
        }
    }
    Ok(pages)
}

/// Files that a page refers to, each as a path from its folder. Links to elsewhere and within the page are none.
fn links(page: &str) -> impl Iterator<Item = &str> {
    let quoted = ["href=\"", "src=\""].into_iter().flat_map(|before| page.split(before).skip(1));
    let targets = quoted.filter_map(|rest| rest.split('"').next());
    let files = targets.filter(|target| !target.contains(':'));
    files.filter_map(|target| target.split(['#', '?']).next()).filter(|path| !path.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_to_files_are_found() {
        let page = r##"<a href="../rust/palpate/index.html#x"><img src="a.png?v=1"><a href="#here"><a href="mailto:x"><a href="">"##;
        assert_eq!(links(page).collect::<Vec<_>>(), ["../rust/palpate/index.html", "a.png"]);
    }
}
