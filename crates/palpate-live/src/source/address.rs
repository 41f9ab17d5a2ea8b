//! What a source is called: its address on the command line.

use std::fmt;
use std::io::Read;
use std::path::PathBuf;
use std::str::FromStr;

use crate::error::SourceError;
use crate::head::Head;
use crate::log_file::mcap_rig_kind;
use crate::rigs::{RigKind, RigSample};
use crate::source::Source;
use crate::source::follow::Follow;
use crate::source::mcap::McapSource;
use crate::source::serial::Serial;
use crate::source::simulated::{self, Simulated};
use crate::source::text::Text;

/// Bits per second of a serial port if nothing is said of it.
const USUAL_BAUD: u32 = 115_200;

/// The address of a source.
///
/// ```
/// use palpate_live::{Address, RigKind};
/// let address: Address = "serial:/dev/ttyUSB0?baud=230400".parse()?;
/// assert_eq!(address, Address::Serial { path: "/dev/ttyUSB0".to_owned(), baud: 230_400, rig: RigKind::Palms });
/// assert_eq!(address.to_string(), "serial:/dev/ttyUSB0?baud=230400");
/// # Ok::<(), palpate_live::SourceError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Address {
    /// `-`: CSV lines on standard input.
    StandardInput,
    /// A path: a CSV file that is followed as it grows.
    File(PathBuf),
    /// `serial:/dev/ttyUSB0?baud=115200`; with `?rig=pivot` one of strokes.
    Serial {
        /// The device.
        path: String,
        /// Bits per second.
        baud: u32,
        /// Of which rig its lines are.
        rig: RigKind,
    },
    /// `evdev:/dev/input/eventX,/dev/input/eventY?angles=/dev/input/eventZ`.
    Evdev {
        /// The pads of palm 1 and palm 2.
        pads: [PathBuf; 2],
        /// What they call a millimetre; `None` = as they say themselves.
        units_per_mm: Option<f64>,
        /// Where the palm angles come from.
        angles: EvdevAngles,
    },
    /// `mcap:FILE?map=topics.toml`.
    Mcap {
        /// An MCAP file or a ROS 2 bag in that format.
        file: PathBuf,
        /// Which topics hold what; `None` for a recording of palpate.
        map: Option<PathBuf>,
    },
    /// `sim:PLAN.toml`.
    Simulated(PathBuf),
}

/// Palm angles beside input devices that have none.
#[derive(Clone, Debug, PartialEq)]
pub enum EvdevAngles {
    /// A third device, with φ₁ on its axis `ABS_RX` and φ₂ on `ABS_RY`.
    Device(PathBuf),
    /// Palms that stand still, radians.
    Fixed([f64; 2]),
}

const KINDS: &str = "a source is a path, -, serial:/dev/ttyUSB0?baud=115200, evdev:/dev/input/event5,/dev/input/event6?angles=/dev/input/event7, \
                     mcap:FILE?map=topics.toml or sim:PLAN.toml";

impl FromStr for Address {
    type Err = SourceError;

    fn from_str(address: &str) -> Result<Self, SourceError> {
        let wrong = |problem: String| SourceError::Address { address: address.to_owned(), problem };
        if address == "-" {
            return Ok(Self::StandardInput);
        }
        let (kind, rest) = match address.split_once(':') {
            Some((kind @ ("serial" | "evdev" | "mcap" | "sim"), rest)) => (kind, rest),
            _ if address.is_empty() => return Err(wrong(KINDS.to_owned())),
            _ => return Ok(Self::File(PathBuf::from(address))),
        };
        let (name, mut options) = Options::split(rest).map_err(wrong)?;
        if name.is_empty() {
            return Err(wrong(format!("there is nothing after {kind}:; {KINDS}")));
        }
        let found = match kind {
            "serial" => {
                let baud = options.take("baud").map_or(Ok(USUAL_BAUD), |text| {
                    text.parse().ok().filter(|&baud| baud > 0).ok_or("baud is a whole number such as 115200")
                });
                let baud = baud.map_err(|problem| wrong(problem.to_owned()))?;
                let rig = match options.take("rig") {
                    None | Some("palms") => RigKind::Palms,
                    Some("pivot") => RigKind::Pivot,
                    Some(_) => return Err(wrong("rig is palms or pivot".to_owned())),
                };
                Self::Serial { path: name.to_owned(), baud, rig }
            }
            "evdev" => {
                let (pad1, pad2) =
                    name.split_once(',').ok_or_else(|| wrong(format!("two pads are needed; {KINDS}")))?;
                let angle = |text: Option<&str>| text.and_then(|text| text.parse::<f64>().ok()).map(f64::to_radians);
                let device = options.take("angles");
                let fixed = [angle(options.take("phi1_deg")), angle(options.take("phi2_deg"))];
                let angles = match (device, fixed) {
                    (Some(device), [None, None]) => EvdevAngles::Device(PathBuf::from(device)),
                    (None, [Some(phi1_rad), Some(phi2_rad)]) => EvdevAngles::Fixed([phi1_rad, phi2_rad]),
                    _ => {
                        return Err(wrong(
                            "say where the palm angles come from: ?angles=/dev/input/eventZ, a device with both, or ?phi1_deg=60&phi2_deg=74 for palms that stand still"
                                .to_owned(),
                        ));
                    }
                };
                let units_per_mm = options.take("units_per_mm").map(|text| {
                    let units_per_mm = text.parse::<f64>().ok().filter(|units| *units > 0.0 && units.is_finite());
                    units_per_mm.ok_or_else(|| wrong("units_per_mm is a positive number such as 40".to_owned()))
                });
                let pads = [PathBuf::from(pad1), PathBuf::from(pad2)];
                Self::Evdev { pads, units_per_mm: units_per_mm.transpose()?, angles }
            }
            "mcap" => Self::Mcap { file: PathBuf::from(name), map: options.take("map").map(PathBuf::from) },
            _ => Self::Simulated(PathBuf::from(name)),
        };
        options.require_none().map_err(wrong)?;
        Ok(found)
    }
}

/// What stands behind the `?`.
struct Options<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Options<'a> {
    fn split(text: &'a str) -> Result<(&'a str, Self), String> {
        let Some((name, options)) = text.split_once('?') else { return Ok((text, Self(Vec::new()))) };
        let pair = |option: &'a str| {
            option.split_once('=').ok_or_else(|| format!("{option:?} is no option: write name=value"))
        };
        Ok((name, Self(options.split('&').map(pair).collect::<Result<_, _>>()?)))
    }

    fn take(&mut self, name: &str) -> Option<&'a str> {
        let index = self.0.iter().position(|(found, _)| *found == name)?;
        Some(self.0.remove(index).1)
    }

    fn require_none(&self) -> Result<(), String> {
        self.0.first().map_or(Ok(()), |(name, _)| {
            Err(format!("this source has no option {name:?}, or it is given twice; {KINDS}"))
        })
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StandardInput => f.write_str("-"),
            Self::File(path) => path.display().fmt(f),
            Self::Serial { path, baud, rig: RigKind::Palms } => write!(f, "serial:{path}?baud={baud}"),
            Self::Serial { path, baud, rig: RigKind::Pivot } => write!(f, "serial:{path}?baud={baud}&rig=pivot"),
            Self::Evdev { pads: [pad1, pad2], units_per_mm, angles } => {
                write!(f, "evdev:{},{}", pad1.display(), pad2.display())?;
                match angles {
                    EvdevAngles::Device(path) => write!(f, "?angles={}", path.display()),
                    EvdevAngles::Fixed([phi1_rad, phi2_rad]) => {
                        write!(f, "?phi1_deg={}&phi2_deg={}", phi1_rad.to_degrees(), phi2_rad.to_degrees())
                    }
                }?;
                units_per_mm.map_or(Ok(()), |units_per_mm| write!(f, "&units_per_mm={units_per_mm}"))
            }
            Self::Mcap { file, map: None } => write!(f, "mcap:{}", file.display()),
            Self::Mcap { file, map: Some(map) } => write!(f, "mcap:{}?map={}", file.display(), map.display()),
            Self::Simulated(path) => write!(f, "sim:{}", path.display()),
        }
    }
}

impl Address {
    /// Which rig the source is of: said by the head of CSV lines, by the address of a port, by the map or the messages of an MCAP file, by the plan
    /// of a simulated rig. What cannot be read is of palms; opening it says why.
    pub fn rig_kind(&self, head: &Head) -> RigKind {
        match self {
            Self::StandardInput | Self::File(_) if head.is_of_strokes() => RigKind::Pivot,
            Self::Serial { rig, .. } => *rig,
            Self::Mcap { file, map } => mcap_rig_kind(file, map.as_deref()),
            Self::Simulated(path) => simulated::rig_kind(path),
            _ => RigKind::Palms,
        }
    }

    /// Opens the source. The conventions are those of its rig, where they are stated; else it may state them itself. Samples are given as the rig has them.
    ///
    /// # Errors
    /// There is no such source, or it cannot be used.
    pub fn open<S: RigSample>(&self, conventions: Option<S::Conventions>) -> Result<Box<dyn Source<S>>, SourceError> {
        self.open_after(Head::default(), conventions)
    }

    /// The same where the head was read already.
    ///
    /// # Errors
    /// As of [`open`](Self::open).
    pub fn open_after<S: RigSample>(
        &self,
        head: Head,
        conventions: Option<S::Conventions>,
    ) -> Result<Box<dyn Source<S>>, SourceError> {
        Ok(match self {
            Self::StandardInput => {
                let whole = std::io::Cursor::new(head.into_bytes()).chain(std::io::stdin());
                Box::new(Text::new("standard input", whole, conventions))
            }
            Self::File(path) => Box::new(Follow::open(path, conventions)?),
            Self::Serial { path, baud, .. } => Box::new(Serial::open(path, *baud, conventions.unwrap_or_default())?),
            Self::Evdev { .. } => S::open_devices(self)?,
            Self::Mcap { file, map } => Box::new(McapSource::open(file, map.as_deref())?),
            Self::Simulated(path) => Box::new(Simulated::open(path)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_come_back_from_their_text() {
        for text in [
            "-",
            "logs/trial.csv",
            "serial:/dev/ttyUSB0?baud=9600",
            "serial:/dev/ttyUSB0?baud=9600&rig=pivot",
            "evdev:/dev/input/event5,/dev/input/event6?angles=/dev/input/event7",
            "evdev:a,b?angles=c&units_per_mm=12.5",
            "mcap:bag.mcap",
            "mcap:bag.mcap?map=topics.toml",
            "sim:plan.toml",
        ] {
            let address: Address = text.parse().expect(text);
            assert_eq!(address.to_string(), text);
        }
        assert_eq!("c:log.csv".parse(), Ok(Address::File(PathBuf::from("c:log.csv"))));
        let fixed: Address = "evdev:a,b?phi2_deg=90&phi1_deg=45".parse().expect("fixed palms");
        let Address::Evdev { angles: EvdevAngles::Fixed([phi1_rad, phi2_rad]), .. } = fixed else { panic!("{fixed}") };
        assert_eq!([phi1_rad, phi2_rad].map(f64::to_degrees), [45.0, 90.0]);
    }

    #[test]
    fn what_is_no_address_is_refused_with_what_to_write() {
        for text in [
            "",
            "serial:",
            "serial:a?baud=0",
            "serial:a?baud=x",
            "serial:a?baud",
            "serial:a?speed=1",
            "serial:a?rig=hand",
            "sim:a?map=b",
            "evdev:a?angles=c",
            "evdev:a,b",
            "evdev:a,b?phi1_deg=60",
            "evdev:a,b?angles=c&units_per_mm=0",
            "evdev:a,b?angles=c&phi1_deg=1&phi2_deg=2",
            "mcap:a?map=b&map=c",
        ] {
            let error = text.parse::<Address>().expect_err(text);
            assert!(error.to_string().starts_with(text), "{error}");
        }
    }
}
