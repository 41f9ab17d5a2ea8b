//! What a log told of the inertia of an object: plain data.

/// How an object resists being turned, where palms are so fast that it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct InertiaEstimate {
    /// Radius of gyration about the centre of mass, metres.
    pub gyration_radius_m: f64,
    /// Its standard deviation, metres.
    pub gyration_radius_sd_m: f64,
    /// That of an even mass of the same shape, metres.
    pub uniform_gyration_radius_m: f64,
    /// Drag on the rotation over the moment of inertia, 1/s.
    pub damping_per_s: f64,
    /// Its standard deviation, 1/s.
    pub damping_sd_per_s: f64,
    /// By how much balance alone is missed, metres (standard deviation).
    pub static_balance_sd_m: f64,
}
