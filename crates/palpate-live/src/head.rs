//! What CSV lines begin with: it tells which rig they are of.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, BufRead, Read};
use std::time::Duration;

use palpate_io::is_strokes_log;

use crate::rigs::RigSample;
use crate::source::address::Address;
use crate::source::text::CsvDecoder;

/// Pause before a file that has not grown is looked at again.
const PAUSE: Duration = Duration::from_millis(20);
/// Most bytes above the first row.
const LONGEST_HEAD: u64 = 64 * 1024;

/// What CSV lines begin with, up to their header: it tells which rig they are of. Waits until it is there.
#[derive(Clone, Debug, Default)]
pub struct Head {
    bytes: Vec<u8>,
}

impl Head {
    /// Of a source; empty where it is none of CSV lines, or cannot be opened. Takes it from standard input: hand it to
    /// [`Address::open_after`].
    pub fn of(address: &Address) -> Self {
        match address {
            Address::StandardInput => Self::read(&mut io::stdin().lock(), || false),
            Address::File(path) => {
                let Ok(file) = File::open(path) else { return Self::default() };
                let grows = || {
                    std::thread::sleep(PAUSE);
                    true
                };
                Self::read(&mut io::BufReader::new(file), grows)
            }
            _ => Self::default(),
        }
    }

    /// Reads up to the first line that is no comment; `goes_on` says at an end whether more may come.
    fn read(input: &mut impl BufRead, goes_on: impl Fn() -> bool) -> Self {
        let mut bytes = Vec::new();
        let mut begins = 0;
        while (bytes.len() as u64) < LONGEST_HEAD {
            match input.take(LONGEST_HEAD - bytes.len() as u64).read_until(b'\n', &mut bytes) {
                Err(error) if error.kind() != io::ErrorKind::Interrupted => break,
                Ok(0) if !goes_on() => break,
                _ => {}
            }
            if !bytes.ends_with(b"\n") {
                continue;
            }
            let line = String::from_utf8_lossy(&bytes[begins..]);
            if !line.trim().is_empty() && !line.trim_start().starts_with('#') {
                break;
            }
            begins = bytes.len();
        }
        Self { bytes }
    }

    /// Whether the lines below it are of strokes and not of two palms.
    pub fn is_of_strokes(&self) -> bool {
        is_strokes_log(&self.bytes)
    }

    /// What its comments say of the rig, where that can be understood; whoever reads on says why not.
    pub fn rig<S: RigSample>(&self) -> Option<S::Rig> {
        let mut decoder = CsvDecoder::<S>::new("the head", None);
        decoder.push(&self.bytes, &mut VecDeque::new()).ok()?;
        decoder.rig()
    }

    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::Sample;

    #[test]
    fn the_first_line_that_is_no_comment_tells_the_rig() {
        let address: Address = "serial:/dev/null".parse().expect("an address");
        assert!(!Head::of(&address).is_of_strokes());
        assert!(!Head::of(&Address::File("missing.csv".into())).is_of_strokes());
        let palms = Head::read(&mut &b"# a\ntime_s,phi1_rad,phi2_rad,s1_m,s2_m\n1,"[..], || false);
        assert!(!palms.is_of_strokes() && palms.bytes.ends_with(b"s2_m\n"));
        assert_eq!(palms.rig::<Sample>(), None);
        let exact = Head::read(&mut &b"# rig: exact\ntime_s,phi1_rad,phi2_rad,s1_m,s2_m\n1,"[..], || false);
        assert_eq!(exact.rig::<Sample>(), Some(palpate_io::RigFile::exact()));
        let strokes = Head::read(&mut &b"# a\n\ntime_s,pivot_x_m,pivot_y_m,s_m\n1,"[..], || false);
        assert!(strokes.is_of_strokes() && strokes.bytes.ends_with(b",s_m\n"));
    }
}
