//! What a distribution says of the libraries in it: their licences in full, and their list for programs (CycloneDX).

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::{tools, workspace};

/// Name of the file with the licences.
pub const NOTICES: &str = "THIRD-PARTY-NOTICES.txt";

/// The licences of all that the package (a folder from the root of the workspace) is linked with, those that `deny.toml` allows.
pub fn licences(package: &str, to: &Path) -> anyhow::Result<()> {
    let rules: toml::Table = fs::read_to_string(workspace::root().join("deny.toml"))?.parse()?;
    // A list of texts is the same in both notations.
    let allowed = serde_json::to_string(&rules["licenses"]["allow"])?;
    let settings = workspace::target().join("about.toml");
    fs::write(
        &settings,
        format!("accepted = {allowed}\nignore-dev-dependencies = true\nignore-build-dependencies = true\n"),
    )?;
    let mut about = tools::ABOUT.command()?;
    about
        .args(["generate", "--locked", "--fail", "--manifest-path", &format!("{package}/Cargo.toml"), "--config"])
        .arg(&settings);
    workspace::run(about.arg("--output-file").arg(to).arg("xtask/src/dist/notices.hbs"))
}

/// The list of components of the package.
pub fn components(package: &str, to: &Path) -> anyhow::Result<()> {
    const NAME: &str = "components-of-a-distribution";
    let mut list = tools::CYCLONEDX.command()?;
    list.args(["--format", "json", "--spec-version", "1.5", "--override-filename", NAME, "--manifest-path"]);
    let listed = workspace::run(list.arg(format!("{package}/Cargo.toml")));
    let made = workspace::root().join(package).join(format!("{NAME}.json"));
    let text = fs::read_to_string(&made);
    // It makes one for each member of the workspace.
    for folder in members()? {
        let other = folder.join(format!("{NAME}.json"));
        if other.exists() {
            fs::remove_file(&other)?;
        }
    }
    listed?;
    let text = text.with_context(|| made.display().to_string())?;
    // Where it was built is nobody's business.
    let here = format!("file://{}/", workspace::root().display());
    fs::write(to, text.replace(&here, "file:///")).with_context(|| to.display().to_string())
}

/// Folders of the members of the workspace.
fn members() -> anyhow::Result<Vec<PathBuf>> {
    let mut metadata = workspace::cargo();
    let output = metadata.args(["metadata", "--no-deps", "--format-version", "1"]).output()?;
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout)?;
    let packages = metadata["packages"].as_array().into_iter().flatten();
    let manifests = packages.filter_map(|package| package["manifest_path"].as_str());
    Ok(manifests.filter_map(|manifest| Path::new(manifest).parent().map(Path::to_path_buf)).collect())
}
