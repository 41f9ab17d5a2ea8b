//! Linux input devices: a touchpad on each palm, and a device with the angles of both.
//!
//! An input device says only what changes, with the time of the kernel. So there is a sample whenever a pad says something, with what was last said by
//! the others.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, UNIX_EPOCH};

use evdev::raw_stream::RawDevice;
use evdev::{AbsInfo, AbsoluteAxisCode, EventType, InputEvent, KeyCode, SynchronizationCode};
use palpate::Sample;
use palpate::palms::PalmPair;

use crate::error::SourceError;
use crate::losses::Losses;
use crate::source::address::EvdevAngles;
use crate::source::{Arrival, Overflow, Source};

/// Events between the devices and the source at most. More are kept by the kernel, which says so when it drops them.
const QUEUE_EVENTS: usize = 1024;
/// Longest wait for an event before the caller hears of it.
const PATIENCE: Duration = Duration::from_millis(100);
/// Pause before a device that is gone is tried again.
const PAUSE: Duration = Duration::from_millis(200);
/// What both pads say within this time is one sample, seconds: a fifth of the time between two reports of a fast touchpad.
const TOGETHER_S: f64 = 0.002;

/// What a device says.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Said {
    /// An axis has a value: 0 is that of a pad, or of φ₁; 1 that of φ₂. In metres or radians.
    Axis(usize, f64),
    /// A pad is touched, or no longer.
    Touched(bool),
    /// That was all at this time, seconds since 1970.
    Report(f64),
    /// Something was dropped, or the device was gone.
    Gap,
}

/// What its numbers mean.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scale {
    code: AbsoluteAxisCode,
    zero: i32,
    per_unit: f64,
}

impl Scale {
    fn of(&self, value: i32) -> f64 {
        (f64::from(value) - f64::from(self.zero)) / self.per_unit
    }
}

/// A device and the meaning of its axes.
struct Device {
    path: PathBuf,
    device: RawDevice,
    scales: Vec<Scale>,
    /// Whether the kernel has dropped events and the rest of the report is to be passed over.
    dropped: bool,
}

impl Device {
    /// A pad: positions along its first axis.
    fn pad(path: &Path, units_per_mm: Option<f64>) -> Result<Self, SourceError> {
        let device = open(path)?;
        let x = [AbsoluteAxisCode::ABS_X, AbsoluteAxisCode::ABS_MT_POSITION_X];
        let infos = infos(path, &device)?;
        let found = x.into_iter().find_map(|code| infos.iter().find(|(found, _)| *found == code));
        let Some((code, info)) = found else {
            return Err(SourceError::content(path.display().to_string(), "it has no axis ABS_X: this is no touchpad"));
        };
        let per_mm = units_per_mm.or((info.resolution() > 0).then(|| f64::from(info.resolution())));
        let Some(per_mm) = per_mm else {
            let problem =
                "it does not say how many of its units are a millimetre; measure it and give ?units_per_mm=40";
            return Err(SourceError::content(path.display().to_string(), problem));
        };
        let scale = Scale { code: *code, zero: info.minimum(), per_unit: 1e3 * per_mm };
        Ok(Self { path: path.to_owned(), device, scales: vec![scale], dropped: false })
    }

    /// Both palm angles: φ₁ on `ABS_RX`, φ₂ on `ABS_RY`.
    fn angles(path: &Path) -> Result<Self, SourceError> {
        let device = open(path)?;
        let infos = infos(path, &device)?;
        let scale = |code: AbsoluteAxisCode| {
            let info = infos.iter().find(|(found, _)| *found == code).map(|(_, info)| info);
            let per_rad = info.map(AbsInfo::resolution).filter(|per_rad| *per_rad > 0);
            let problem = || {
                format!("it has no axis {code:?} with a resolution in units per radian; both palm angles are needed")
            };
            let per_rad = per_rad.ok_or_else(|| SourceError::content(path.display().to_string(), problem()))?;
            Ok::<_, SourceError>(Scale { code, zero: 0, per_unit: f64::from(per_rad) })
        };
        let scales = vec![scale(AbsoluteAxisCode::ABS_RX)?, scale(AbsoluteAxisCode::ABS_RY)?];
        Ok(Self { path: path.to_owned(), device, scales, dropped: false })
    }

    /// What the device says now, all of it.
    fn state(&self) -> std::io::Result<Vec<Said>> {
        let axes = self.device.get_abs_state()?;
        let of_axis = |(index, scale): (usize, &Scale)| {
            axes.get(usize::from(scale.code.0)).map(|axis| Said::Axis(index, scale.of(axis.value)))
        };
        let mut said: Vec<Said> = self.scales.iter().enumerate().filter_map(of_axis).collect();
        said.push(Said::Touched(self.device.get_key_state()?.contains(KeyCode::BTN_TOUCH)));
        Ok(said)
    }

    /// Waits for events.
    fn read(&mut self) -> std::io::Result<Vec<Said>> {
        let events: Vec<InputEvent> = self.device.fetch_events()?.collect();
        let mut said = Vec::new();
        for event in events {
            match said_by(&event, &self.scales) {
                Some(Said::Gap) => {
                    self.dropped = true;
                    said.push(Said::Gap);
                }
                Some(Said::Report(time_s)) => {
                    if std::mem::take(&mut self.dropped) {
                        said.extend(self.state()?);
                    }
                    said.push(Said::Report(time_s));
                }
                Some(other) if !self.dropped => said.push(other),
                _ => {}
            }
        }
        Ok(said)
    }

    /// Reads for ever, opening the device again when it is back.
    fn serve(mut self, index: usize, queue: &SyncSender<(usize, Said)>) {
        let send = |said: Vec<Said>| said.into_iter().try_for_each(|said| queue.send((index, said)));
        let mut said = self.state().unwrap_or_default();
        loop {
            if send(said).is_err() {
                return;
            }
            said = self.read().unwrap_or_else(|_| {
                std::thread::sleep(PAUSE);
                match RawDevice::open(&self.path) {
                    Ok(device) => {
                        self.device = device;
                        let mut said = vec![Said::Gap];
                        said.extend(self.state().unwrap_or_default());
                        said
                    }
                    Err(_) => Vec::new(),
                }
            });
            // Also notices that nobody listens any more.
            if said.is_empty() {
                said.push(Said::Touched(false));
            }
        }
    }
}

fn open(path: &Path) -> Result<RawDevice, SourceError> {
    RawDevice::open(path)
        .map_err(|error| SourceError::io(path.display().to_string(), "it cannot be opened as an input device", &error))
}

fn infos(path: &Path, device: &RawDevice) -> Result<Vec<(AbsoluteAxisCode, AbsInfo)>, SourceError> {
    let failed = |error| SourceError::io(path.display().to_string(), "its axes cannot be read", &error);
    Ok(device.get_absinfo().map_err(failed)?.collect())
}

/// What an event says.
fn said_by(event: &InputEvent, scales: &[Scale]) -> Option<Said> {
    match event.event_type() {
        EventType::ABSOLUTE if event.code() == AbsoluteAxisCode::ABS_MT_TRACKING_ID.0 => {
            Some(Said::Touched(event.value() >= 0))
        }
        EventType::ABSOLUTE => {
            let index = scales.iter().position(|scale| scale.code.0 == event.code())?;
            Some(Said::Axis(index, scales.get(index)?.of(event.value())))
        }
        EventType::KEY if event.code() == KeyCode::BTN_TOUCH.0 => Some(Said::Touched(event.value() != 0)),
        EventType::SYNCHRONIZATION if event.code() == SynchronizationCode::SYN_REPORT.0 => {
            Some(Said::Report(event.timestamp().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64()))
        }
        EventType::SYNCHRONIZATION if event.code() == SynchronizationCode::SYN_DROPPED.0 => Some(Said::Gap),
        _ => None,
    }
}

/// What all devices have said so far.
#[derive(Clone, Debug)]
struct State {
    angles_rad: [Option<f64>; 2],
    position_m: [Option<f64>; 2],
    touched: [bool; 2],
    /// A sample that the other pad may still add to.
    pending: Option<Sample>,
    /// Seconds since 1970 at the first report: samples count from there.
    start_s: Option<f64>,
    losses: Losses,
}

impl State {
    fn new(angles_rad: [Option<f64>; 2]) -> Self {
        Self {
            angles_rad,
            position_m: [None; 2],
            touched: [false; 2],
            pending: None,
            start_s: None,
            losses: Losses::default(),
        }
    }

    /// Takes in what a device says: 0 and 1 are the pads, 2 has the angles. A sample that is complete comes out.
    fn take(&mut self, device: usize, said: Said) -> Option<Sample> {
        match said {
            Said::Gap => {
                self.losses.gaps += 1;
                if device < 2 {
                    self.touched[device] = false;
                }
                None
            }
            Said::Axis(index, value) => {
                if device < 2 {
                    self.position_m[device] = Some(value);
                } else if let Some(angle_rad) = self.angles_rad.get_mut(index) {
                    *angle_rad = Some(value);
                }
                None
            }
            Said::Touched(touched) => {
                if device < 2 {
                    self.touched[device] = touched;
                }
                None
            }
            Said::Report(_) if device == 2 => None,
            Said::Report(time_s) => self.report(time_s),
        }
    }

    fn report(&mut self, time_s: f64) -> Option<Sample> {
        let [Some(phi1_rad), Some(phi2_rad)] = self.angles_rad else {
            self.losses.without_angles += 1;
            return None;
        };
        let time_s = time_s - *self.start_s.get_or_insert(time_s);
        let contact = |palm: usize| self.position_m[palm].filter(|_| self.touched[palm]);
        let sample = Sample {
            s1_m: contact(0),
            s2_m: contact(1),
            ..Sample::new(time_s, PalmPair::hinged(phi1_rad, phi2_rad), 0.0, 0.0)
        };
        match self.pending {
            Some(pending) if (time_s - pending.time_s).abs() <= TOGETHER_S => {
                self.pending = Some(Sample { time_s: pending.time_s, ..sample });
                None
            }
            _ => self.pending.replace(sample),
        }
    }
}

/// The devices together.
pub(crate) struct Evdev {
    queue: Receiver<(usize, Said)>,
    state: State,
}

impl Evdev {
    pub(crate) fn open(
        pads: &[PathBuf; 2],
        units_per_mm: Option<f64>,
        angles: &EvdevAngles,
    ) -> Result<Self, SourceError> {
        let mut devices = vec![Device::pad(&pads[0], units_per_mm)?, Device::pad(&pads[1], units_per_mm)?];
        let fixed = match angles {
            EvdevAngles::Fixed(angles_rad) => angles_rad.map(Some),
            EvdevAngles::Device(path) => {
                devices.push(Device::angles(path)?);
                [None; 2]
            }
        };
        let (send, queue) = sync_channel(QUEUE_EVENTS);
        for (index, device) in devices.into_iter().enumerate() {
            let send = send.clone();
            let thread =
                std::thread::Builder::new().name(format!("input {index}")).spawn(move || device.serve(index, &send));
            thread.map_err(|error| SourceError::io("evdev", "no thread can be started", &error))?;
        }
        Ok(Self { queue, state: State::new(fixed) })
    }
}

impl Source for Evdev {
    fn next(&mut self) -> Result<Arrival, SourceError> {
        let sample = match self.queue.recv_timeout(PATIENCE) {
            Ok((device, said)) => self.state.take(device, said),
            // The other pad is silent.
            Err(RecvTimeoutError::Timeout) => self.state.pending.take(),
            Err(RecvTimeoutError::Disconnected) => return Ok(Arrival::End),
        };
        Ok(sample.map_or(Arrival::Nothing, Arrival::Sample))
    }

    fn losses(&self) -> Losses {
        self.state.losses
    }

    fn overflow(&self) -> Overflow {
        Overflow::DropsOldest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scales() -> Vec<Scale> {
        vec![Scale { code: AbsoluteAxisCode::ABS_X, zero: 1000, per_unit: 40_000.0 }]
    }

    fn event(kind: EventType, code: u16, value: i32) -> InputEvent {
        InputEvent::new(kind.0, code, value)
    }

    #[test]
    fn events_say_positions_touches_reports_and_gaps() {
        let said = |kind, code, value| said_by(&event(kind, code, value), &scales());
        assert_eq!(said(EventType::ABSOLUTE, AbsoluteAxisCode::ABS_X.0, 2200), Some(Said::Axis(0, 0.03)));
        assert_eq!(said(EventType::ABSOLUTE, AbsoluteAxisCode::ABS_Y.0, 2200), None);
        assert_eq!(said(EventType::ABSOLUTE, AbsoluteAxisCode::ABS_MT_TRACKING_ID.0, -1), Some(Said::Touched(false)));
        assert_eq!(said(EventType::KEY, KeyCode::BTN_TOUCH.0, 1), Some(Said::Touched(true)));
        assert_eq!(said(EventType::SYNCHRONIZATION, SynchronizationCode::SYN_DROPPED.0, 0), Some(Said::Gap));
        assert_eq!(said(EventType::SYNCHRONIZATION, SynchronizationCode::SYN_REPORT.0, 0), Some(Said::Report(0.0)));
    }

    fn samples(state: &mut State, said: &[(usize, Said)]) -> Vec<(f64, Option<f64>, Option<f64>)> {
        said.iter()
            .filter_map(|&(device, said)| state.take(device, said))
            .map(|sample| (sample.time_s, sample.s1_m, sample.s2_m))
            .collect()
    }

    #[test]
    fn what_both_pads_say_at_a_time_is_one_sample_with_what_was_last_said() {
        let mut state = State::new([None; 2]);
        let found = samples(
            &mut state,
            &[
                (0, Said::Report(99.0)),
                (2, Said::Axis(0, 1.0)),
                (2, Said::Axis(1, 1.25)),
                (2, Said::Report(99.5)),
                (0, Said::Axis(0, 0.03)),
                (0, Said::Touched(true)),
                (0, Said::Report(100.0)),
                (1, Said::Axis(0, 0.04)),
                (1, Said::Touched(true)),
                (1, Said::Report(100.0 + 0.0019)),
                (0, Said::Axis(0, 0.031)),
                (0, Said::Report(100.5)),
                (1, Said::Touched(false)),
                (1, Said::Report(101.0)),
                (1, Said::Report(102.0)),
            ],
        );
        assert_eq!(found, [(0.0, Some(0.03), Some(0.04)), (0.5, Some(0.031), Some(0.04)), (1.0, Some(0.031), None)]);
        assert_eq!(state.losses, Losses { without_angles: 1, ..Losses::default() });
        assert_eq!(state.pending.map(|sample| (sample.time_s, sample.palms.phi2_rad)), Some((2.0, 1.25)));
    }

    #[test]
    fn a_gap_is_counted_and_leaves_no_contact_that_nobody_saw() {
        let mut state = State::new([Some(1.0), Some(1.25)]);
        let touch = [(0, Said::Axis(0, 0.03)), (0, Said::Touched(true)), (0, Said::Report(1.0))];
        assert_eq!(samples(&mut state, &touch), []);
        let found = samples(&mut state, &[(0, Said::Gap), (0, Said::Report(2.0)), (0, Said::Report(3.0))]);
        assert_eq!(found, [(0.0, Some(0.03), None), (1.0, None, None)]);
        assert_eq!(state.losses, Losses { gaps: 1, ..Losses::default() });
    }

    #[test]
    fn what_is_no_input_device_is_refused() {
        let pads = [PathBuf::from("/dev/null"), PathBuf::from("/dev/null")];
        let error = Evdev::open(&pads, None, &EvdevAngles::Fixed([1.0, 1.25])).map(|_| ()).expect_err("no pads");
        assert!(error.to_string().starts_with("/dev/null: "), "{error}");
    }
}
