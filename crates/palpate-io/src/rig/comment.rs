//! The rig in a log: a comment `# rig: …` above its header, as `palpate simulate` writes it.

use palpate::sensor::Rig;

use crate::rig::parse::parse_rig;
use crate::rig::rig_error::RigError;
use crate::rig::to_toml::rig_to_toml;
use crate::rig::{RigFile, conventions::Conventions};

/// The key of the comment.
pub(crate) const KEY: &str = "rig";

/// Its value where readings are to be taken as they are.
pub(crate) const EXACT: &str = "exact";

/// The value of a comment `# rig: …`, which says in one line what a rig file says; [`read_log_with_rig`](crate::read_log_with_rig) reads it.
///
/// ```
/// assert_eq!(palpate_io::rig_comment(&palpate_io::RigFile::exact()), "exact");
/// assert!(palpate_io::rig_comment(&palpate_io::RigFile::default()).starts_with("[palm1] zero_m = 0; zero_sd_m = 0.0005; "));
/// ```
pub fn rig_comment(rig: &RigFile) -> String {
    if rig.rig == Rig::default() && rig.conventions == Conventions::default() {
        return EXACT.to_owned();
    }
    on_one_line(&rig_to_toml(rig))
}

/// The lines of a rig file as one: a space behind the name of a table, a semicolon behind a value.
pub(crate) fn on_one_line(toml: &str) -> String {
    let lines = toml.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    let line = lines.map(|line| if line.starts_with('[') { format!("{line} ") } else { format!("{line}; ") });
    line.collect::<String>().trim_end_matches("; ").to_owned()
}

/// The lines that such a line stands for.
pub(crate) fn on_lines(comment: &str) -> String {
    comment.replace("] ", "]\n").replace("; ", "\n")
}

/// What such a comment says; `file` is what messages call the log.
///
/// # Errors
/// As of [`parse_rig`].
pub fn parse_rig_comment(file: &str, value: &str) -> Result<RigFile, RigError> {
    if value == EXACT {
        return Ok(RigFile::exact());
    }
    parse_rig(file, &on_lines(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rig_comes_back_from_its_comment() {
        let mut rigs = vec![RigFile::default(), RigFile::exact()];
        let text = "[palm1]\nzero_mm = 0.3\ndirection = \"to_base\"\nlength_mm = 55.5\n[angles]\nsign2 = -1\n[clock]\noffset_ms = 3\n";
        rigs.push(parse_rig("rig.toml", text).expect("a rig"));
        for rig in rigs {
            let comment = rig_comment(&rig);
            assert!(!comment.contains('\n'));
            assert_eq!(parse_rig_comment("log.csv", &comment), Ok(rig));
        }
        assert!(parse_rig_comment("log.csv", "left hand").is_err());
    }
}
