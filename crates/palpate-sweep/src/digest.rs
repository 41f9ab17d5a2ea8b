//! A 64-bit digest (FNV-1a) that tells whether two things are the same; no defence against someone who wants them to look so.

/// Digest of bytes that come in parts. Where a part ends does not count.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Digest(u64);

impl Digest {
    pub(crate) fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    #[must_use]
    pub(crate) fn with(self, bytes: &[u8]) -> Self {
        Self(bytes.iter().fold(self.0, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)))
    }

    /// As sixteen hexadecimal digits.
    pub(crate) fn hex(self) -> String {
        format!("{:016x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::Digest;

    /// Test vectors of Fowler, Noll and Vo.
    #[test]
    fn digests_are_those_of_fnv_1a() {
        assert_eq!(Digest::new().hex(), "cbf29ce484222325");
        assert_eq!(Digest::new().with(b"foobar").hex(), "85944171f73967e8");
        assert_eq!(Digest::new().with(b"foo").with(b"bar").hex(), "85944171f73967e8");
    }
}
