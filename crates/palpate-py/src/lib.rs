//! The Python package palpate: the libraries as they are, with numpy in and out. `_palpate` is its compiled part; what needs other
//! Python packages (matplotlib, pandas, IPython, Ray, tqdm) is in `python/palpate`.
//!
//! The comments on classes and functions here are the docstrings that Python shows, in the style of numpydoc.
#![forbid(unsafe_code)]

mod estimate;
mod interop;
mod measured;
mod object;
mod palms_motion;
mod strokes;
mod sweep;

use pyo3::prelude::*;

/// The compiled part of palpate.
#[pymodule]
mod _palpate {
    #[pymodule_export]
    use crate::estimate::calibrate::calibrate;
    #[pymodule_export]
    use crate::estimate::calibration::ConstantData;
    #[pymodule_export]
    use crate::estimate::doubt::DoubtData;
    #[pymodule_export]
    use crate::estimate::information::{InformationData, posterior};
    #[pymodule_export]
    use crate::estimate::jump::JumpData;
    #[pymodule_export]
    use crate::estimate::live::{EstimateData, LiveData, WatchData, watch};
    #[pymodule_export]
    use crate::estimate::reconstruct::{cramer_rao_bound_m, reconstruct, reconstruct_from};
    #[pymodule_export]
    use crate::estimate::result::ResultData;
    #[pymodule_export]
    use crate::estimate::rig_calibration::{CalibrationData, ContributionData, DriftData};
    #[pymodule_export]
    use crate::estimate::symmetry::SymmetryData;
    #[pymodule_export]
    use crate::measured::log::LogData;
    #[pymodule_export]
    use crate::measured::rig::RigData;
    #[pymodule_export]
    use crate::measured::sensor::Pad;
    #[pymodule_export]
    use crate::measured::simulate::{Simulated, simulate};
    #[pymodule_export]
    use crate::measured::truth::TrueData;
    #[pymodule_export]
    use crate::object::compare::{Errors, compare};
    #[pymodule_export]
    use crate::object::mechanics::{Landscape, Rest, follow};
    #[pymodule_export]
    use crate::object::outline::Fit;
    #[pymodule_export]
    use crate::object::shape::Shape;
    #[pymodule_export]
    use crate::palms_motion::motion::Motion;
    #[pymodule_export]
    use crate::palms_motion::moves::Move;
    #[pymodule_export]
    use crate::palms_motion::palms::{Palms, radii_of_curvature_m};
    #[pymodule_export]
    use crate::palms_motion::plan::{Limits, Planned, plan_jump_free, plan_turn};
    #[pymodule_export]
    use crate::strokes::live::{LiveStrokesData, StrokesEstimateData};
    #[pymodule_export]
    use crate::strokes::log::StrokesData;
    #[pymodule_export]
    use crate::strokes::plan::plan_strokes;
    #[pymodule_export]
    use crate::strokes::reconstruct::reconstruct_strokes;
    #[pymodule_export]
    use crate::strokes::result::StrokesResult;
    #[pymodule_export]
    use crate::strokes::simulate::simulate_strokes;
    #[pymodule_export]
    use crate::sweep::{FolderData, JobData, run_sweep_jobs, sweep_jobs};

    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name that Python uses")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
