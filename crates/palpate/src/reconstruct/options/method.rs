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

/// A word that names no [`Method`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("method must be 'likelihood', 'ode' or 'quadrature', not '{0}'")]
pub struct UnknownMethod(String);

impl Method {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Likelihood, Self::Ode, Self::Quadrature];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Likelihood => "likelihood",
            Self::Ode => "ode",
            Self::Quadrature => "quadrature",
        }
    }
}

impl std::str::FromStr for Method {
    type Err = UnknownMethod;

    /// From its name.
    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        Self::ALL.into_iter().find(|method| method.name() == name).ok_or_else(|| UnknownMethod(name.to_owned()))
    }
}

impl std::fmt::Display for Method {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_method_is_read_as_it_is_written() {
        for method in Method::ALL {
            assert_eq!(method.to_string().parse(), Ok(method));
        }
        let message = "method must be 'likelihood', 'ode' or 'quadrature', not 'magic'";
        assert_eq!("magic".parse::<Method>().expect_err("none").to_string(), message);
    }
}
