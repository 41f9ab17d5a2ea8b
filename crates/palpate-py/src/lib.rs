//! The Python package palpate: the libraries as they are, with numpy in and out. `_palpate` is its compiled part; what needs other
//! Python packages (matplotlib, pandas, Ray, tqdm) is in `python/palpate`.
//!
//! The comments on classes and functions here are the docstrings that Python shows, in the style of numpydoc.
#![forbid(unsafe_code)]

mod arrays;
mod compare;
mod doubt;
mod errors;
mod information;
mod jump;
mod log;
mod mechanics;
mod motion;
mod moves;
mod palms;
mod pickled;
mod plan;
mod reconstruct;
mod result;
mod sensor;
mod shape;
mod simulate;
mod svg;
mod sweep;
mod truth;
mod whole;
mod work;

use pyo3::prelude::*;

/// The compiled part of palpate.
#[pymodule]
mod _palpate {
    #[pymodule_export]
    use crate::compare::{Errors, compare};
    #[pymodule_export]
    use crate::doubt::DoubtData;
    #[pymodule_export]
    use crate::information::{InformationData, posterior};
    #[pymodule_export]
    use crate::jump::JumpData;
    #[pymodule_export]
    use crate::log::LogData;
    #[pymodule_export]
    use crate::mechanics::{Landscape, Rest, follow};
    #[pymodule_export]
    use crate::motion::Motion;
    #[pymodule_export]
    use crate::moves::Move;
    #[pymodule_export]
    use crate::palms::{Palms, radii_of_curvature_m};
    #[pymodule_export]
    use crate::plan::{Limits, Planned, plan_jump_free, plan_turn};
    #[pymodule_export]
    use crate::reconstruct::{cramer_rao_bound_m, reconstruct, reconstruct_from};
    #[pymodule_export]
    use crate::result::ResultData;
    #[pymodule_export]
    use crate::sensor::Pad;
    #[pymodule_export]
    use crate::shape::Shape;
    #[pymodule_export]
    use crate::simulate::{Simulated, simulate};
    #[pymodule_export]
    use crate::sweep::{FolderData, JobData, run_sweep_jobs, sweep_jobs};
    #[pymodule_export]
    use crate::truth::TrueData;

    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name that Python uses")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
