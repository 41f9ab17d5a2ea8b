//! Lines `# key: value` above the header of a table.

/// Each pair on a line of its own, whatever the value holds.
pub(crate) fn push_metadata(text: &mut String, metadata: &[(impl AsRef<str>, String)]) {
    for (key, value) in metadata {
        *text += &format!("# {}: {}\n", key.as_ref(), value.replace(['\n', '\r'], " "));
    }
}
