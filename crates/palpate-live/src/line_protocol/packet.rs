//! One line of the protocol: its fields and its check.

use crc::{CRC_8_SMBUS, Crc};
use palpate::palms::PalmPair;
use palpate::{Log, Sample};

/// Polynomial 0x07, initial 0.
const CHECK: Crc<u8> = Crc::<u8>::new(&CRC_8_SMBUS);
/// Longest line: seven fields of at most eleven characters with their separators make 87.
pub(crate) const LONGEST_LINE: usize = 96;

/// What a line says, in the units of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Time in microseconds; 0 follows 2³² − 1.
    pub time_us: u32,
    /// Palm angles φ₁ and φ₂, microradians.
    pub phi_urad: [i32; 2],
    /// Contact positions, micrometres; `None` without contact.
    pub s_um: [Option<i32>; 2],
    /// Normal forces, millinewtons; `None` where not measured.
    pub force_mn: [Option<i32>; 2],
}

/// Why a line says nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PacketError {
    /// No `*` with two hexadecimal digits at the end.
    #[error("the line does not end in * and two hexadecimal digits")]
    NoCheck,
    /// The digits are not the CRC-8 of the line.
    #[error("the check of the line fails")]
    WrongCheck,
    /// Neither five nor seven fields.
    #[error("the line has {fields} fields instead of 5 or 7")]
    Fields {
        /// As many.
        fields: usize,
    },
    /// A field that is no whole number in its range.
    #[error("field {field} is no whole number in its range")]
    Number {
        /// From 1.
        field: usize,
    },
}

impl Packet {
    /// Reads a line without its line feed; a carriage return before that is allowed.
    ///
    /// ```
    /// use palpate_live::protocol::Packet;
    /// let packet = Packet::parse(b"1000000,1047198,1308997,29700,*9B")?;
    /// assert_eq!((packet.time_us, packet.s_um), (1_000_000, [Some(29_700), None]));
    /// assert_eq!(packet.to_line(), "1000000,1047198,1308997,29700,*9B\n");
    /// # Ok::<(), palpate_live::protocol::PacketError>(())
    /// ```
    ///
    /// # Errors
    /// The check fails, or the fields are not as the protocol has them.
    pub fn parse(line: &[u8]) -> Result<Self, PacketError> {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let Some((body, [b'*', digits @ ..])) = line.len().checked_sub(3).map(|end| line.split_at(end)) else {
            return Err(PacketError::NoCheck);
        };
        let hexadecimal = |digit: &u8| char::from(*digit).to_digit(16);
        let check = digits.iter().try_fold(0, |check, digit| Some(16 * check + hexadecimal(digit)?));
        if check.ok_or(PacketError::NoCheck)? != u32::from(CHECK.checksum(body)) {
            return Err(PacketError::WrongCheck);
        }
        let fields: Vec<&[u8]> = body.split(|&byte| byte == b',').collect();
        if !matches!(fields.len(), 5 | 7) {
            return Err(PacketError::Fields { fields: fields.len() });
        }
        let integer = |field: usize| whole(fields[field]).ok_or(PacketError::Number { field: field + 1 });
        let signed =
            |field: usize| i32::try_from(integer(field)?).map_err(|_| PacketError::Number { field: field + 1 });
        let or_empty = |field: usize| match fields.get(field) {
            Some(text) if !text.is_empty() => signed(field).map(Some),
            _ => Ok(None),
        };
        Ok(Self {
            time_us: u32::try_from(integer(0)?).map_err(|_| PacketError::Number { field: 1 })?,
            phi_urad: [signed(1)?, signed(2)?],
            s_um: [or_empty(3)?, or_empty(4)?],
            force_mn: [or_empty(5)?, or_empty(6)?],
        })
    }

    /// The line that says so, with its check and line feed; without the fields of the forces where there are none.
    pub fn to_line(&self) -> String {
        let or_empty = |value: Option<i32>| value.map_or_else(String::new, |value| value.to_string());
        let ([phi1, phi2], [s1, s2]) = (self.phi_urad, self.s_um.map(or_empty));
        let mut line = format!("{},{phi1},{phi2},{s1},{s2}", self.time_us);
        if self.force_mn != [None; 2] {
            let [force1, force2] = self.force_mn.map(or_empty);
            line.push_str(&format!(",{force1},{force2}"));
        }
        let check = CHECK.checksum(line.as_bytes());
        line.push_str(&format!("*{check:02X}\n"));
        line
    }

    /// The packet of a sample, rounded; times before 0 and beyond 2³² microseconds wrap.
    pub fn of_sample(sample: &Sample) -> Self {
        let rounded = |value: f64| (1e6 * value).round() as i32;
        Self {
            time_us: (1e6 * sample.time_s).round().rem_euclid(f64::from(u32::MAX) + 1.0) as u32,
            phi_urad: [rounded(sample.palms.phi1_rad), rounded(sample.palms.phi2_rad)],
            s_um: [sample.s1_m.map(rounded), sample.s2_m.map(rounded)],
            force_mn: [sample.force1_n, sample.force2_n].map(|force_n| force_n.map(|n| rounded(1e-3 * n))),
        }
    }

    /// The sample at a time that the caller has unwrapped.
    pub(crate) fn sample(&self, time_s: f64) -> Sample {
        let [phi1_rad, phi2_rad] = self.phi_urad.map(|value| f64::from(value) / 1e6);
        let [s1_m, s2_m] = self.s_um.map(|value| value.map(|value| f64::from(value) / 1e6));
        let [force1_n, force2_n] = self.force_mn.map(|value| value.map(|value| f64::from(value) / 1e3));
        Sample { s1_m, s2_m, force1_n, force2_n, ..Sample::new(time_s, PalmPair::hinged(phi1_rad, phi2_rad), 0.0, 0.0) }
    }
}

/// The lines that a board would send of a log.
pub fn lines_of(log: &Log) -> impl Iterator<Item = String> {
    log.samples.iter().map(|sample| Packet::of_sample(sample).to_line())
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
    use proptest::prelude::*;

    fn with_check(body: &str) -> Vec<u8> {
        format!("{body}*{:02x}", CHECK.checksum(body.as_bytes())).into_bytes()
    }

    #[test]
    fn the_check_is_that_of_the_standard() {
        assert_eq!(CHECK.checksum(b"123456789"), 0xf4);
    }

    #[test]
    fn lines_that_are_not_as_the_protocol_has_them_are_told_apart() {
        let faults = [
            ("1,2,3,4", PacketError::Fields { fields: 4 }),
            ("1,2,3,4,5,6", PacketError::Fields { fields: 6 }),
            ("-1,2,3,4,5", PacketError::Number { field: 1 }),
            ("4294967296,2,3,4,5", PacketError::Number { field: 1 }),
            ("1,,3,4,5", PacketError::Number { field: 2 }),
            ("1,2,+3,4,5", PacketError::Number { field: 3 }),
            ("1,2,3,4.5,5", PacketError::Number { field: 4 }),
            ("1,2,3,4,2147483648", PacketError::Number { field: 5 }),
            ("1,2,3,4,5,6,-", PacketError::Number { field: 7 }),
        ];
        for (body, fault) in faults {
            assert_eq!(Packet::parse(&with_check(body)), Err(fault), "{body}");
        }
        for line in ["", "*", "*00x", "1,2,3,4,5", "1,2,3,4,5*", "1,2,3,4,5*0", "1,2,3,4,5*0g", "1,2,3,4,5#00"] {
            assert_eq!(Packet::parse(line.as_bytes()), Err(PacketError::NoCheck), "{line}");
        }
        assert_eq!(Packet::parse(b"1,2,3,4,5*00"), Err(PacketError::WrongCheck));
        assert!(Packet::parse(&[with_check("1,2,3,,"), b"\r".to_vec()].concat()).is_ok());
    }

    proptest! {
        #[test]
        fn packets_come_back_from_their_lines(
            time_us in any::<u32>(),
            phi_urad in any::<[i32; 2]>(),
            s_um in any::<[Option<i32>; 2]>(),
            force_mn in any::<[Option<i32>; 2]>(),
        ) {
            let packet = Packet { time_us, phi_urad, s_um, force_mn };
            let line = packet.to_line();
            prop_assert!(line.len() <= LONGEST_LINE);
            prop_assert_eq!(Packet::parse(line.trim_end_matches('\n').as_bytes()), Ok(packet));
        }

        #[test]
        fn a_byte_that_changed_never_goes_unnoticed(s1 in 0..100_000, at in 0usize..33, byte in any::<u8>()) {
            let packet = Packet { time_us: 123_456_789, phi_urad: [1_047_198, 1_308_997], s_um: [Some(s1), None], force_mn: [None; 2] };
            let line = packet.to_line();
            let mut bytes = line.trim_end_matches('\n').as_bytes().to_vec();
            let at = at.min(bytes.len() - 1);
            bytes[at] = byte;
            if let Ok(found) = Packet::parse(&bytes) {
                prop_assert_eq!(found, packet);
            }
        }
    }
}
