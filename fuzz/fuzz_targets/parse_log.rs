//! Whatever the bytes, the reader returns a log or one printable paragraph that names the file.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    match palpate_io::parse_log("log.csv", bytes) {
        Ok(file) => assert!(file.log.samples.len() >= palpate_io::MIN_SAMPLES),
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with("log.csv") && message.chars().count() < 1500, "{message:?}");
            assert!(!message.chars().any(char::is_control), "{message:?}");
        }
    }
});
