//! The true shape and motion behind a log, where someone knows them: from a simulator, a vision system or a drawing.

/// True shape and motion. Plain data.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Truth {
    /// Support function about the centre of mass as (θ in radians, r in metres), θ increasing over [0, 2π).
    pub support: Vec<(f64, f64)>,
    /// One pose per sample of the log.
    pub motion: Vec<TruePose>,
}

/// True pose of the object at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TruePose {
    /// Time in seconds.
    pub time_s: f64,
    /// Orientation of the object in radians.
    pub psi_rad: f64,
    /// Centre of mass, X in the global frame, metres.
    pub com_x_m: f64,
    /// Centre of mass, Y in the global frame, metres.
    pub com_y_m: f64,
}
