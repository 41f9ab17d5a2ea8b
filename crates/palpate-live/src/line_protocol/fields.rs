//! What every line of the protocol has: fields of whole numbers, and a check.

use crc::{CRC_8_SMBUS, Crc};

/// Polynomial 0x07, initial 0.
const CHECK: Crc<u8> = Crc::<u8>::new(&CRC_8_SMBUS);
/// Longest line: seven fields of at most eleven characters with their separators make 87.
pub(crate) const LONGEST_LINE: usize = 96;

/// Why a line says nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PacketError {
    /// No `*` with two hexadecimal digits at the end.
    #[error("the line does not end in * and two hexadecimal digits")]
    NoCheck,
    /// The digits are not the CRC-8 of the line.
    #[error("the check of the line fails")]
    WrongCheck,
    /// More or fewer fields than such a line has.
    #[error("the line has {fields} fields instead of {needed}")]
    Fields {
        /// As many.
        fields: usize,
        /// As many as it should have.
        needed: &'static str,
    },
    /// A field that is no whole number in its range.
    #[error("field {field} is no whole number in its range")]
    Number {
        /// From 1.
        field: usize,
    },
}

/// The fields of a line whose check is right.
pub(super) struct Fields<'a>(Vec<&'a [u8]>);

impl<'a> Fields<'a> {
    /// Of a line without its line feed; a carriage return before that is allowed.
    pub(super) fn checked(line: &'a [u8]) -> Result<Self, PacketError> {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let Some((body, [b'*', digits @ ..])) = line.len().checked_sub(3).map(|end| line.split_at(end)) else {
            return Err(PacketError::NoCheck);
        };
        let hexadecimal = |digit: &u8| char::from(*digit).to_digit(16);
        let check = digits.iter().try_fold(0, |check, digit| Some(16 * check + hexadecimal(digit)?));
        if check.ok_or(PacketError::NoCheck)? != u32::from(CHECK.checksum(body)) {
            return Err(PacketError::WrongCheck);
        }
        Ok(Self(body.split(|&byte| byte == b',').collect()))
    }

    pub(super) fn require(&self, needed: &'static str, is_right: impl Fn(usize) -> bool) -> Result<(), PacketError> {
        let fields = self.0.len();
        if is_right(fields) { Ok(()) } else { Err(PacketError::Fields { fields, needed }) }
    }

    pub(super) fn unsigned(&self, field: usize) -> Result<u32, PacketError> {
        let wrong = PacketError::Number { field: field + 1 };
        u32::try_from(self.0.get(field).copied().and_then(whole).ok_or(wrong)?).map_err(|_| wrong)
    }

    pub(super) fn signed(&self, field: usize) -> Result<i32, PacketError> {
        let wrong = PacketError::Number { field: field + 1 };
        i32::try_from(self.0.get(field).copied().and_then(whole).ok_or(wrong)?).map_err(|_| wrong)
    }

    /// `None` where the field is empty or missing.
    pub(super) fn or_empty(&self, field: usize) -> Result<Option<i32>, PacketError> {
        match self.0.get(field) {
            Some(text) if !text.is_empty() => self.signed(field).map(Some),
            _ => Ok(None),
        }
    }
}

/// A line with its check and line feed.
pub(super) fn with_check(mut line: String) -> String {
    let check = CHECK.checksum(line.as_bytes());
    line.push_str(&format!("*{check:02X}\n"));
    line
}

/// Microseconds as the counter of a board has them; times before 0 and beyond 2³² microseconds wrap.
pub(super) fn wrapped_us(time_s: f64) -> u32 {
    (1e6 * time_s).round().rem_euclid(f64::from(u32::MAX) + 1.0) as u32
}

/// Decimal digits with at most a minus sign before them, no more than a 32-bit number has.
fn whole(text: &[u8]) -> Option<i64> {
    let digits = text.strip_prefix(b"-").unwrap_or(text);
    if digits.is_empty() || digits.len() > 10 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    std::str::from_utf8(text).ok()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_is_that_of_the_standard() {
        assert_eq!(CHECK.checksum(b"123456789"), 0xf4);
    }

    #[test]
    fn lines_without_their_check_say_nothing() {
        for line in ["", "*", "*00x", "1,2,3,4,5", "1,2,3,4,5*", "1,2,3,4,5*0", "1,2,3,4,5*0g", "1,2,3,4,5#00"] {
            assert_eq!(Fields::checked(line.as_bytes()).err(), Some(PacketError::NoCheck), "{line}");
        }
        assert_eq!(Fields::checked(b"1,2,3,4,5*00").err(), Some(PacketError::WrongCheck));
    }

    #[test]
    fn fields_are_whole_numbers_in_their_range() {
        let line = with_check("4294967295,-1,4294967296,-2147483648,2147483648,,1.5".to_owned());
        let fields = Fields::checked(line.trim_end().as_bytes()).expect("its check");
        assert_eq!((fields.unsigned(0), fields.signed(3)), (Ok(u32::MAX), Ok(i32::MIN)));
        for field in [1, 2, 5, 6, 7] {
            assert_eq!(fields.unsigned(field), Err(PacketError::Number { field: field + 1 }), "{field}");
        }
        assert_eq!(fields.signed(4), Err(PacketError::Number { field: 5 }));
        assert_eq!((fields.or_empty(5), fields.or_empty(7)), (Ok(None), Ok(None)));
    }
}
