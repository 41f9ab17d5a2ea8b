//! What a search arranges: the readings as corrected so far, cut into windows, and how exact they are taken to be (`docs/theory.md`, the
//! search; calibration).

use crate::estimate::measurements::Measurements;
use crate::estimate::model::prior::Prior;
use crate::reconstruct::search::schedule::Found;
use crate::reconstruct::search::tolerance::Tolerance;
use crate::reconstruct::search::windows::Window;
use crate::sensor::Calibration;
use std::borrow::Cow;

/// Readings corrected by a calibration.
pub(crate) struct Corrected {
    pub calibration: Calibration,
    pub measurements: Measurements,
    /// Standard deviation of a contact position, with what is still unknown of the calibration, metres.
    pub tolerance_m: f64,
}

/// What an arrangement of a part of a log tells of the rig; `None` where it tells nothing.
pub(crate) type Calibrate<'a> = dyn Fn(&Found) -> Option<Corrected> + 'a;

/// A log that is to be arranged.
#[derive(Clone)]
pub(crate) struct Problem<'a> {
    /// What the measurements were corrected by.
    pub calibration: Calibration,
    pub measurements: Cow<'a, Measurements>,
    /// In order of time.
    pub windows: Vec<Window>,
    pub tolerance: Tolerance,
    pub prior: Prior,
}

impl Problem<'_> {
    /// The same with readings that are known better.
    pub fn corrected(&self, by: Corrected) -> Self {
        let Corrected { calibration, measurements, tolerance_m } = by;
        let windows = self.windows.iter().map(|window| window.of(&measurements)).collect();
        let tolerance = Tolerance { scatter_m: tolerance_m, ..self.tolerance };
        Self { calibration, measurements: Cow::Owned(measurements), windows, tolerance, prior: self.prior }
    }
}
