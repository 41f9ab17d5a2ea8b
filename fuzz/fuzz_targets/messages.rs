//! Whatever the bytes, a message of ROS 2 is read or refused, in CDR of both byte orders and in JSON.
#![no_main]

use libfuzzer_sys::fuzz_target;
use palpate_live::messages::{Encoding, MessageKind};

fuzz_target!(|bytes: &[u8]| {
    for kind in MessageKind::ALL {
        for encoding in [Encoding::Cdr, Encoding::Json] {
            if let Ok(message) = kind.decode(encoding, bytes) {
                let _ = message.stamp_s();
            }
        }
    }
});
