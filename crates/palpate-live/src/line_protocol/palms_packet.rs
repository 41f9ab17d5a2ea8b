//! A line of two palms: `T,phi1,phi2,s1,s2[,f1,f2]*CC`.

use std::f64::consts::{PI, TAU};

use palpate::palms::PalmPair;
use palpate::{Log, Sample};

use crate::line_protocol::LinePacket;
use crate::line_protocol::fields::{Fields, PacketError, with_check, wrapped_us};

/// Palms turn slower than this, radians per second: eight turns a second, beyond any drive that carries an object.
const FASTEST_TURN_RAD_PER_S: f64 = 50.0;
/// And the readings of their angles err by less than this, radians.
const LARGEST_ANGLE_ERROR_RAD: f64 = 0.2;

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
        let fields = Fields::checked(line)?;
        fields.require("5 or 7", |count| matches!(count, 5 | 7))?;
        Ok(Self {
            time_us: fields.unsigned(0)?,
            phi_urad: [fields.signed(1)?, fields.signed(2)?],
            s_um: [fields.or_empty(3)?, fields.or_empty(4)?],
            force_mn: [fields.or_empty(5)?, fields.or_empty(6)?],
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
        with_check(line)
    }

    /// The packet of a sample, rounded; times before 0 and beyond 2³² microseconds wrap.
    pub fn of_sample(sample: &Sample) -> Self {
        let rounded = |value: f64| (1e6 * value).round() as i32;
        Self {
            time_us: wrapped_us(sample.time_s),
            phi_urad: [rounded(sample.palms.phi1_rad), rounded(sample.palms.phi2_rad)],
            s_um: [sample.s1_m.map(rounded), sample.s2_m.map(rounded)],
            force_mn: [sample.force1_n, sample.force2_n].map(|force_n| force_n.map(|n| rounded(1e-3 * n))),
        }
    }
}

impl LinePacket for Packet {
    type Sample = Sample;

    /// Of a million lines with one byte in ten changed, 3399 wrong samples get through if each line counts by itself, 20 with two, none with three
    /// (`tests/noisy_line.rs`).
    const CONFIRMED: usize = 3;

    fn parse(line: &[u8]) -> Result<Self, PacketError> {
        Self::parse(line)
    }

    fn time_us(&self) -> u32 {
        self.time_us
    }

    fn sample(&self, time_s: f64) -> Sample {
        let [phi1_rad, phi2_rad] = self.phi_urad.map(|value| f64::from(value) / 1e6);
        let [s1_m, s2_m] = self.s_um.map(|value| value.map(|value| f64::from(value) / 1e6));
        let [force1_n, force2_n] = self.force_mn.map(|value| value.map(|value| f64::from(value) / 1e3));
        Sample { s1_m, s2_m, force1_n, force2_n, ..Sample::new(time_s, PalmPair::hinged(phi1_rad, phi2_rad), 0.0, 0.0) }
    }

    /// Whether palms turn from one line to the other.
    fn can_follow(&self, before: &Self, step_s: f64) -> bool {
        let farthest_rad = FASTEST_TURN_RAD_PER_S * step_s + LARGEST_ANGLE_ERROR_RAD;
        let turn_rad = |palm: usize| (f64::from(self.phi_urad[palm]) - f64::from(before.phi_urad[palm])).abs() / 1e6;
        // An encoder may count modulo a turn.
        let turn1_rad = PI - (turn_rad(0).rem_euclid(TAU) - PI).abs();
        turn1_rad <= farthest_rad && turn_rad(1) <= farthest_rad
    }
}

/// The lines that a board would send of a log.
pub fn lines_of(log: &Log) -> impl Iterator<Item = String> {
    log.samples.iter().map(|sample| Packet::of_sample(sample).to_line())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line_protocol::fields::LONGEST_LINE;
    use proptest::prelude::*;

    #[test]
    fn lines_that_are_not_of_palms_are_told_apart() {
        let fields = |fields| PacketError::Fields { fields, needed: "5 or 7" };
        let faults = [
            ("1,2,3,4", fields(4)),
            ("1,2,3,4,5,6", fields(6)),
            ("1,,3,4,5", PacketError::Number { field: 2 }),
            ("1,2,+3,4,5", PacketError::Number { field: 3 }),
            ("1,2,3,4.5,5", PacketError::Number { field: 4 }),
            ("1,2,3,4,2147483648", PacketError::Number { field: 5 }),
            ("1,2,3,4,5,6,-", PacketError::Number { field: 7 }),
        ];
        for (body, fault) in faults {
            assert_eq!(Packet::parse(with_check(body.to_owned()).trim_end().as_bytes()), Err(fault), "{body}");
        }
        assert!(Packet::parse(with_check("1,2,3,,".to_owned()).replace('\n', "\r").as_bytes()).is_ok());
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
