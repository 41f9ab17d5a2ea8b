//! Whatever log the reader lets through, the estimator returns: a result or an error, never a panic, and no result that is
//! certified without numbers to show for it.
#![no_main]

use libfuzzer_sys::fuzz_target;

/// Longer logs only make a run slow.
const MAX_SAMPLES: usize = 60;

fuzz_target!(|bytes: &[u8]| {
    let Ok(file) = palpate_io::parse_log("log.csv", bytes) else { return };
    if file.log.samples.len() > MAX_SAMPLES {
        return;
    }
    if let Ok(result) = palpate::reconstruct(&file.log) {
        assert_eq!(result.motion.len(), file.log.samples.len());
        if result.is_certified() {
            assert!(result.chi2_per_dof.is_finite() && result.sensor_sd_m.is_finite());
            assert!(result.outline.iter().all(|point| point.r_m.is_finite()));
            assert!(result.motion.iter().all(|pose| pose.psi_rad.is_finite()));
        }
    }
});
