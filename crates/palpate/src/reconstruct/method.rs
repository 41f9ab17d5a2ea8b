//! The ways from a log to shape and motion.

/// A way from the log to shape and motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Method {
    /// Maximum likelihood over all samples, with error bars and a certificate.
    #[default]
    Likelihood,
    /// Equations 19 to 21 of Moll & Erdmann (2001), integrated by a fourth-order Adams-Bashforth-Moulton method. Without
    /// error bars (they are NaN), never certified.
    Ode,
    /// Closed forms for the same by quadrature (trapezoid rule, second order). Without error bars (they are NaN), never certified.
    Quadrature,
}

impl std::fmt::Display for Method {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Likelihood => "likelihood",
            Self::Ode => "ode",
            Self::Quadrature => "quadrature",
        })
    }
}
