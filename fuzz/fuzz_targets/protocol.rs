//! Whatever bytes a board sends, in whatever pieces: plausible samples in the order of time come out.
#![no_main]

use libfuzzer_sys::fuzz_target;
use palpate_io::{Conventions, fault_of};
use palpate_live::protocol::{Decoder, Packet};

fuzz_target!(|bytes: &[u8]| {
    let (mut decoder, mut samples) = (Decoder::new(Conventions::default()), Vec::new());
    let piece = 1 + bytes.first().map_or(0, |&byte| usize::from(byte));
    for (index, piece) in bytes.chunks(piece).enumerate() {
        decoder.push(piece, index as f64, &mut samples);
        if index % 64 == 63 {
            decoder.interrupted();
        }
    }
    assert!(samples.iter().all(|sample| fault_of(sample).is_none()));
    assert!(samples.windows(2).all(|pair| pair[1].time_s > pair[0].time_s));
    // So that the check is no obstacle: what a line says comes back from it.
    for line in bytes.split(|&byte| byte == b'\n') {
        if let Ok(packet) = Packet::parse(line) {
            assert_eq!(Packet::parse(packet.to_line().trim_end().as_bytes()), Ok(packet));
        }
    }
});
