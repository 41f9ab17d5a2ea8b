//! Samples of two palms, as sources and recordings have them.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use palpate::palms::PalmPair;
use palpate::{Log, Sample};
use palpate_io::{Conventions, ReadError, RigFile, RowReader, fault_of};

use crate::error::SourceError;
use crate::join::Joined;
use crate::line_protocol::palms_packet::Packet;
use crate::mcap_files::sample_message::SampleMessage;
use crate::rigs::{RigSample, json_schema};
use crate::source::Source;
use crate::source::address::Address;

impl RigSample for Sample {
    type Rig = RigFile;
    type Conventions = Conventions;
    type Rows = RowReader;
    type Packet = Packet;
    type Message = SampleMessage;

    const SCHEMA: &'static str = "palpate.Sample";

    fn time_s(&self) -> f64 {
        self.time_s
    }

    fn at(self, time_s: f64) -> Self {
        Self { time_s, ..self }
    }

    fn is_implausible(&self, conventions: &Conventions) -> bool {
        let log = conventions.apply(&Log { samples: vec![*self] });
        log.samples.first().is_none_or(|sample| fault_of(sample).is_some())
    }

    fn conventions(rig: &RigFile) -> Conventions {
        rig.conventions
    }

    fn take_comment(name: &str, line: &str, is_stated: bool, rig: &mut Option<RigFile>) -> Result<(), SourceError> {
        if !is_stated && rig.is_none() {
            *rig = palpate_io::rig_of_comment(name, line)?;
        }
        Ok(())
    }

    fn rows(name: &str, header: &str, line: usize, conventions: Conventions) -> Result<RowReader, ReadError> {
        RowReader::new(name, header, line, conventions)
    }

    fn row(rows: &RowReader, text: &str, line: usize) -> Result<Option<Self>, ReadError> {
        rows.sample(text, line)
    }

    fn csv_header(metadata: &[(String, String)]) -> String {
        palpate_io::log_csv_header(metadata)
    }

    fn push_csv_row(&self, text: &mut String) {
        palpate_io::push_log_row(text, self);
    }

    fn schema() -> String {
        let numbers = ["time_s", "phi1_rad", "phi2_rad", "base1_x_m", "base1_y_m", "base2_x_m", "base2_y_m"];
        json_schema(Self::SCHEMA, &numbers, &["s1_m", "s2_m", "s1_sd_m", "s2_sd_m", "force1_n", "force2_n"])
    }

    fn of_joined(joined: &Joined) -> Self {
        let Joined { time_s, place: [phi1_rad, phi2_rad], position_m: [s1_m, s2_m], force_n: [force1_n, force2_n] } =
            *joined;
        let palms = PalmPair::hinged(phi1_rad, phi2_rad);
        Self { s1_m, s2_m, force1_n, force2_n, ..Self::new(time_s, palms, 0.0, 0.0) }
    }

    /// The shorter way round.
    fn between(before: f64, after: f64, share: f64) -> f64 {
        let turn_rad = (after - before + PI).rem_euclid(TAU) - PI;
        before + turn_rad * share
    }

    #[cfg(target_os = "linux")]
    fn open_devices(address: &Address) -> Result<Box<dyn Source<Self>>, SourceError> {
        match address {
            Address::Evdev { pads, units_per_mm, angles } => {
                Ok(Box::new(crate::source::evdev::Evdev::open(pads, *units_per_mm, angles)?))
            }
            other => {
                Err(SourceError::Address { address: other.to_string(), problem: "this is no input device".to_owned() })
            }
        }
    }

    #[cfg(not(target_os = "linux"))]
    fn open_devices(address: &Address) -> Result<Box<dyn Source<Self>>, SourceError> {
        let problem = "input devices are read on Linux only".to_owned();
        Err(SourceError::Address { address: address.to_string(), problem })
    }

    fn simulated(path: &Path, plan: &str) -> Result<(Vec<Self>, f64, RigFile), SourceError> {
        crate::source::simulated::palms::simulated(path, plan)
    }
}
