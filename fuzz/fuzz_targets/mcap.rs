//! Whatever the bytes, an MCAP file is read as a recording and as a bag, or refused by a message that names it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use palpate_io::fault_of;

const MAP: &str = r#"
phi1 = { topic = "/joint_states", field = "position[palm1]" }
phi2 = { topic = "/joint_states", field = "position[palm2]" }
s1 = { topic = "/palm1/contact", field = "point.x" }
s2 = { topic = "/pads", field = "data[0]", unit = "mm" }
force1 = { topic = "/palm1/wrench", field = "wrench.force.z" }
"#;

fuzz_target!(|bytes: &[u8]| {
    for map in [None, Some(MAP)] {
        match palpate_live::parse_mcap_log("log.mcap", bytes, map) {
            Ok((file, _)) => {
                assert!(file.log.samples.len() >= palpate_io::MIN_SAMPLES);
                assert!(file.log.samples.iter().all(|sample| fault_of(sample).is_none()));
                assert!(file.log.samples.windows(2).all(|pair| pair[1].time_s > pair[0].time_s));
            }
            Err(error) => assert!(error.to_string().starts_with("log.mcap"), "{error}"),
        }
    }
});
