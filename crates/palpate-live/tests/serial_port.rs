//! A serial port that is a pseudo-terminal: samples come through, and the port may vanish and come back.
#![cfg(target_os = "linux")]

use std::fs::{self, File};
use std::io::Write;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::time::Duration;

use palpate::Sample;
use palpate::palms::PalmPair;
use palpate::pivot::PivotSample;
use palpate_live::protocol::{Packet, StrokesPacket};
use palpate_live::{Address, Batch, Head, RigKind, Stream};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Between two lines of the board.
const PAUSE: Duration = Duration::from_millis(5);

/// The board's end of a pseudo-terminal; the other is at `port`.
fn board(port: &Path) -> File {
    let board = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo-terminal");
    grantpt(&board).expect("a pseudo-terminal");
    unlockpt(&board).expect("a pseudo-terminal");
    let mut settings = tcgetattr(&board).expect("its settings");
    settings.make_raw();
    tcsetattr(&board, OptionalActions::Now, &settings).expect("its settings");
    let name = ptsname(&board, Vec::new()).expect("its name");
    let aside = port.with_extension("new");
    symlink(name.to_str().expect("a name"), &aside).expect("a link");
    fs::rename(&aside, port).expect("a link");
    File::from(board)
}

fn line(index: u32) -> String {
    let position_m = 0.03 + 1e-6 * f64::from(index);
    Packet::of_sample(&Sample::new(0.01 * f64::from(index), PalmPair::hinged(1.0, 1.3), position_m, 0.03)).to_line()
}

/// Sends line after line, from the first on, until so many samples have come of them.
fn exchange(end: &mut File, stream: &Stream, count: usize) -> Vec<Sample> {
    let mut found = Vec::new();
    for index in 0.. {
        end.write_all(line(index).as_bytes()).expect("a line");
        match stream.next(PAUSE).expect("a port that may come back is no failure") {
            Batch::Samples(samples) => found.extend(samples),
            Batch::End => panic!("a port has no end"),
        }
        if found.len() >= count {
            break;
        }
    }
    found
}

#[test]
fn a_port_that_is_closed_and_opened_ten_times_goes_on() {
    let dir = tempfile::tempdir().expect("a folder");
    let port = dir.path().join("port");
    let mut end = board(&port);
    let address: Address = format!("serial:{}?baud=115200", port.display()).parse().expect("an address");
    let stream = Stream::start(address.open(None).expect("the port"), None).expect("a thread");
    let mut all = Vec::new();
    for round in 0..11 {
        // The board begins anew each time; what it sends before the port is open is lost, and nothing after that.
        let found = exchange(&mut end, &stream, 20);
        let positions: Vec<u32> =
            found.iter().filter_map(|sample| sample.s1_m).map(|s1_m| (1e6 * (s1_m - 0.03)).round() as u32).collect();
        assert!(positions.windows(2).all(|pair| pair[1] == pair[0] + 1), "round {round}: {positions:?}");
        all.extend(found);
        if round < 10 {
            end.write_all(b"190000,1000").expect("half a line");
            drop(end);
            while stream.losses().gaps <= round {
                std::thread::yield_now();
            }
            // What came before that is in the queue.
            if let Batch::Samples(rest) = stream.next(Duration::ZERO).expect("no failure") {
                all.extend(rest);
            }
            end = board(&port);
        }
    }
    assert!(all.windows(2).all(|pair| pair[1].time_s > pair[0].time_s));
    let losses = stream.losses();
    assert_eq!((losses.gaps, losses.doubled, losses.late), (10, 0, 0), "{losses}");
}

#[test]
fn a_board_may_send_strokes() {
    let dir = tempfile::tempdir().expect("a folder");
    let port = dir.path().join("port");
    let mut end = board(&port);
    let address: Address = format!("serial:{}?rig=pivot", port.display()).parse().expect("an address");
    assert_eq!(address.rig_kind(&Head::of(&address)), RigKind::Pivot);
    let stream = Stream::<PivotSample>::start(address.open(None).expect("the port"), None).expect("a thread");
    let sample = |index: u32| {
        let s_m = index.is_multiple_of(2).then_some(0.5);
        PivotSample { time_s: 0.05 * f64::from(index), pivot_x_m: 0.5, pivot_y_m: 0.031, s_m }
    };
    let mut found = Vec::new();
    for index in 0.. {
        end.write_all(StrokesPacket::of_sample(&sample(index)).to_line().as_bytes()).expect("a line");
        // A line of palms is none of strokes.
        if index == 10 {
            end.write_all(line(index).as_bytes()).expect("a line");
        }
        match stream.next(PAUSE).expect("a port") {
            Batch::Samples(samples) => found.extend(samples),
            Batch::End => panic!("a port has no end"),
        }
        if found.len() >= 20 {
            break;
        }
    }
    for found in &found {
        let index = (found.time_s / 0.05).round() as u32;
        assert_eq!(*found, PivotSample { time_s: found.time_s, ..sample(index) });
    }
    assert_eq!(stream.losses().faulty, 1, "{}", stream.losses());
}

#[test]
fn a_port_that_is_not_there_is_named() {
    let address: Address = "serial:/dev/no-such-port".parse().expect("an address");
    let error = address.open::<Sample>(None).map(|_| ()).expect_err("no port").to_string();
    assert!(
        error.starts_with("/dev/no-such-port: the port cannot be opened: ") && error.contains("plugged in"),
        "{error}"
    );
}
