//! The doubts of a summary: of each its kind, its numbers, the sentence that `Display` makes of them, its cause, what to do about it, and where
//! the documentation says more.

use palpate::reconstruct::{Cause, Doubt};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

#[derive(Serialize)]
struct Written<'a> {
    #[serde(flatten)]
    doubt: &'a Doubt,
    /// `None` where the doubt is its sentence alone and has it already.
    #[serde(skip_serializing_if = "Option::is_none")]
    text: Option<String>,
    cause: Cause,
    /// Left out where only words are known.
    #[serde(skip_serializing_if = "String::is_empty")]
    next: String,
    docs: String,
}

/// A kind that this version does not know is read as its sentence.
#[derive(Deserialize)]
#[serde(untagged)]
enum Read {
    Known(Doubt),
    Unknown { text: String },
}

pub(crate) fn serialize<S: Serializer>(doubts: &[Doubt], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(doubts.iter().map(|doubt| {
        let has_text = matches!(doubt, Doubt::Reported { .. } | Doubt::ReportedOfCenterOfMass { .. });
        let text = (!has_text).then(|| doubt.to_string());
        Written { doubt, text, cause: doubt.cause(), next: doubt.next_step(), docs: doubt.docs() }
    }))
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Doubt>, D::Error> {
    let read = Vec::<Read>::deserialize(deserializer)?;
    Ok(read
        .into_iter()
        .map(|read| match read {
            Read::Known(doubt) => doubt,
            Read::Unknown { text } => Doubt::Reported { text },
        })
        .collect())
}
