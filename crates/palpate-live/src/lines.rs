//! Lines out of a stream of bytes, none longer than a limit.

/// Collects bytes until a line is whole.
#[derive(Clone, Debug)]
pub(crate) struct Lines {
    limit: usize,
    line: Vec<u8>,
    /// The line is over the limit: the rest of it is passed over.
    too_long: bool,
}

/// A line that ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Line<'a> {
    /// Without its line break.
    Whole(&'a [u8]),
    /// It was longer than the limit.
    TooLong,
}

impl Lines {
    pub(crate) fn new(limit: usize) -> Self {
        Self { limit, line: Vec::with_capacity(limit), too_long: false }
    }

    /// Takes bytes in, and hands on every line that they end.
    pub(crate) fn push(&mut self, bytes: &[u8], mut take: impl FnMut(Line)) {
        let mut rest = bytes;
        while let Some(end) = rest.iter().position(|&byte| byte == b'\n') {
            self.extend(&rest[..end]);
            take(if self.too_long { Line::TooLong } else { Line::Whole(&self.line) });
            self.clear();
            rest = &rest[end + 1..];
        }
        self.extend(rest);
    }

    /// Hands on the last line, where it has no line break.
    pub(crate) fn finish(&mut self, take: impl FnMut(Line)) {
        if !self.line.is_empty() || self.too_long {
            self.push(b"\n", take);
        }
    }

    /// Forgets a line that has only begun.
    pub(crate) fn clear(&mut self) {
        self.line.clear();
        self.too_long = false;
    }

    fn extend(&mut self, bytes: &[u8]) {
        self.too_long |= self.line.len() + bytes.len() > self.limit;
        if self.too_long {
            self.line.clear();
        } else {
            self.line.extend_from_slice(bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_whole_however_the_bytes_come_and_long_ones_are_passed_over() {
        let bytes = b"one\n\ntoo long\nfour\nto\nlast";
        for size in 1..bytes.len() {
            let (mut lines, mut found) = (Lines::new(4), Vec::new());
            let mut take = |line: Line| match line {
                Line::Whole(text) => found.push(String::from_utf8_lossy(text).into_owned()),
                Line::TooLong => found.push("?".to_owned()),
            };
            bytes.chunks(size).for_each(|part| lines.push(part, &mut take));
            lines.finish(&mut take);
            assert_eq!(found, ["one", "", "?", "four", "to", "last"], "{size}");
            assert!(lines.line.capacity() <= 8);
        }
    }
}
