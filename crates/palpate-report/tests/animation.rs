//! The motion as a file: it opens in any viewer, begins blind, and is small enough to send.

mod fixture;

use fixture::{Fixture, fixture};
use palpate_report::{AnimationError, ReportInput, animation};

fn gif(egg: &Fixture) -> Result<Vec<u8>, AnimationError> {
    animation(&ReportInput {
        title: "a log",
        log: &egg.log,
        reconstruction: &egg.reconstruction,
        truth: None,
        seconds: 1.0,
        command: None,
        version: "0.1.0",
    })
}

#[test]
fn the_motion_is_a_gif_that_begins_blind() {
    let file = gif(&fixture(800, 12.0, 1.4)).expect("an animation");
    if let Some(folder) = std::env::var_os("PALPATE_SCREENSHOTS") {
        std::fs::write(std::path::Path::new(&folder).join("animation.gif"), &file).expect("a place for the animation");
    }
    assert!(file.starts_with(b"GIF89a") && file.len() < 1_500_000, "{} bytes", file.len());
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(file.as_slice()).expect("a GIF");
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    // The colours of the outline and of the contacts, which dots alone have.
    let has = |frame: &gif::Frame, color: [u8; 3]| frame.buffer.chunks(4).filter(|pixel| pixel[..3] == color).count();
    let (outline, contacts) = ([0x00, 0x72, 0xb2], [[0xb0, 0x47, 0x8c], [0xd5, 0x5e, 0x00]]);
    let first = decoder.read_next_frame().expect("a frame").expect("a first one").clone();
    assert_eq!(has(&first, outline), 0);
    assert!(contacts.iter().all(|color| has(&first, *color) > 40));
    let (mut frames, mut drawn, mut round_s) = (1, 0, f64::from(first.delay) / 100.0);
    while let Some(frame) = decoder.read_next_frame().expect("a frame") {
        frames += 1;
        drawn = has(frame, outline);
        round_s += f64::from(frame.delay) / 100.0;
    }
    assert!(
        frames > 60 && drawn > 50 && (6.0..15.0).contains(&round_s),
        "{frames} frames, {drawn} pixels, {round_s} s"
    );
}

#[test]
fn without_motion_there_is_none() {
    assert_eq!(gif(&fixture(1, 1.0, 1.0)), Err(AnimationError::NothingMoves));
    let mut egg = fixture(50, 1.0, 1.0);
    egg.reconstruction.motion[7].psi_rad = f64::NAN;
    assert_eq!(gif(&egg), Err(AnimationError::NothingMoves));
    egg.reconstruction.motion.clear();
    assert_eq!(gif(&egg), Err(AnimationError::NothingMoves));
}
