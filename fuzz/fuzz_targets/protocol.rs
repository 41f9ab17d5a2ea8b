//! Whatever bytes a board sends, in whatever pieces: plausible samples in the order of time come out, of either rig.
#![no_main]

use libfuzzer_sys::fuzz_target;
use palpate::Sample;
use palpate::pivot::PivotSample;
use palpate_live::RigSample;
use palpate_live::protocol::{Decoder, Packet, StrokesPacket};

fn decode<S: RigSample>(bytes: &[u8]) {
    let (mut decoder, mut samples) = (Decoder::<S>::new(S::Conventions::default()), Vec::new());
    let piece = 1 + bytes.first().map_or(0, |&byte| usize::from(byte));
    for (index, piece) in bytes.chunks(piece).enumerate() {
        decoder.push(piece, index as f64, &mut samples);
        if index % 64 == 63 {
            decoder.interrupted();
        }
    }
    assert!(samples.iter().all(|sample| !sample.is_implausible(&S::Conventions::default())));
    assert!(samples.windows(2).all(|pair| pair[1].time_s() > pair[0].time_s()));
}

fuzz_target!(|bytes: &[u8]| {
    decode::<Sample>(bytes);
    decode::<PivotSample>(bytes);
    // So that the check is no obstacle: what a line says comes back from it.
    for line in bytes.split(|&byte| byte == b'\n') {
        if let Ok(packet) = Packet::parse(line) {
            assert_eq!(Packet::parse(packet.to_line().trim_end().as_bytes()), Ok(packet));
        }
        if let Ok(packet) = StrokesPacket::parse(line) {
            assert_eq!(StrokesPacket::parse(packet.to_line().trim_end().as_bytes()), Ok(packet));
        }
    }
});
