//! `Touchpad`: what a palm reports of its contacts.

use palpate::sensor::{PadContact, Touchpad};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::interop::arrays::{self, Column};
use crate::interop::pickled::{self, Pickled};
use crate::interop::whole::Whole;

/// Properties of the touchpads, the same on both palms.
///
/// Parameters
/// ----------
/// length_m : float, default infinite
///     Length along the palm, metres.
/// width_m : float, default infinite
///     Width across the palm, metres; of no effect in the plane.
/// counts_per_inch : float, optional
///     Position steps per inch. Default: no rounding.
/// noise_sd_m : float, default 0
///     Standard deviation of Gaussian noise on the position before rounding, metres.
/// pressure_levels : int, optional
///     Number of pressure levels from 0 to `full_scale_n`. Default: no rounding.
/// full_scale_n : float, default 10
///     Force that gives the highest pressure level, newtons.
/// rate_hz : float, default 100
///     Samples per second.
/// dropout : float, default 0
///     Probability that a reading of one pad is missing, 0 to 1.
/// angle_noise_sd_rad : float, default 0
///     Standard deviation of Gaussian noise on each palm angle as reported, radians.
#[pyclass(frozen, eq, module = "palpate", name = "Touchpad")]
#[derive(Clone, PartialEq)]
pub struct Pad(pub Touchpad);

#[pymethods]
impl Pad {
    #[new]
    #[pyo3(signature = (*, length_m=f64::INFINITY, width_m=f64::INFINITY, counts_per_inch=None, noise_sd_m=0.0,
        pressure_levels=None, full_scale_n=10.0, rate_hz=100.0, dropout=0.0, angle_noise_sd_rad=0.0),
        text_signature = "(*, length_m=..., width_m=..., counts_per_inch=None, noise_sd_m=0.0, pressure_levels=None, \
        full_scale_n=10.0, rate_hz=100.0, dropout=0.0, angle_noise_sd_rad=0.0)")]
    #[expect(clippy::too_many_arguments, reason = "Python calls it by keywords")]
    fn new(
        length_m: f64,
        width_m: f64,
        counts_per_inch: Option<f64>,
        noise_sd_m: f64,
        pressure_levels: Option<Whole>,
        full_scale_n: f64,
        rate_hz: f64,
        dropout: f64,
        angle_noise_sd_rad: f64,
    ) -> Self {
        Self(Touchpad {
            length_m,
            width_m,
            counts_per_inch,
            noise_sd_m,
            pressure_levels: pressure_levels.map(Whole::small),
            full_scale_n,
            rate_hz,
            dropout,
            angle_noise_sd_rad,
        })
    }

    /// The pad of the paper, by Interlink Electronics: 55.5 mm long, 200 counts per inch, 128 pressure levels.
    ///
    /// Parameters
    /// ----------
    /// **changes
    ///     Properties that differ, by name.
    ///
    /// Returns
    /// -------
    /// Touchpad
    ///     The pad.
    #[staticmethod]
    #[pyo3(signature = (**changes))]
    fn interlink<'py>(py: Python<'py>, changes: Option<&Bound<'py, PyDict>>) -> PyResult<Bound<'py, PyAny>> {
        Self(Touchpad::interlink()).changed(py, changes)
    }

    /// The same pad with some properties changed.
    ///
    /// Parameters
    /// ----------
    /// **changes
    ///     Properties that differ, by name.
    ///
    /// Returns
    /// -------
    /// Touchpad
    ///     The pad.
    #[pyo3(signature = (**changes))]
    fn changed<'py>(&self, py: Python<'py>, changes: Option<&Bound<'py, PyDict>>) -> PyResult<Bound<'py, PyAny>> {
        let properties = self.properties(py)?;
        if let Some(changes) = changes {
            properties.update(changes.as_mapping())?;
        }
        py.get_type::<Self>().call((), Some(&properties))
    }

    /// float: length along the palm, metres.
    #[getter]
    fn length_m(&self) -> f64 {
        self.0.length_m
    }

    /// float: width across the palm, metres.
    #[getter]
    fn width_m(&self) -> f64 {
        self.0.width_m
    }

    /// float or None: position steps per inch.
    #[getter]
    fn counts_per_inch(&self) -> Option<f64> {
        self.0.counts_per_inch
    }

    /// float: standard deviation of the noise on the position, metres.
    #[getter]
    fn noise_sd_m(&self) -> f64 {
        self.0.noise_sd_m
    }

    /// int or None: number of pressure levels.
    #[getter]
    fn pressure_levels(&self) -> Option<u32> {
        self.0.pressure_levels
    }

    /// float: force that gives the highest pressure level, newtons.
    #[getter]
    fn full_scale_n(&self) -> f64 {
        self.0.full_scale_n
    }

    /// float: samples per second.
    #[getter]
    fn rate_hz(&self) -> f64 {
        self.0.rate_hz
    }

    /// float: probability that a reading is missing.
    #[getter]
    fn dropout(&self) -> f64 {
        self.0.dropout
    }

    /// float: standard deviation of the noise on each palm angle, radians.
    #[getter]
    fn angle_noise_sd_rad(&self) -> f64 {
        self.0.angle_noise_sd_rad
    }

    /// float: position step, metres; 0 for no rounding.
    #[getter]
    fn resolution_m(&self) -> f64 {
        self.0.resolution_m()
    }

    /// float: standard deviation of one position reading, noise and rounding together, metres.
    #[getter]
    fn position_sd_m(&self) -> f64 {
        self.0.position_sd_m()
    }

    /// What the pad reports of all its contacts together.
    ///
    /// Parameters
    /// ----------
    /// positions_m : array_like of float, shape (n,)
    ///     Distances of the contacts from the base of the palm, metres.
    /// forces_n : array_like of float, shape (n,)
    ///     Normal forces there, newtons.
    /// seed : int, default 0
    ///     Seed of the noise and the drop-out.
    ///
    /// Returns
    /// -------
    /// tuple of float or None
    ///     Force-weighted centroid (metres) and sum of the forces (newtons); None without a contact or on a drop-out.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If the columns differ in length.
    #[pyo3(signature = (positions_m, forces_n, *, seed=Whole(0)), text_signature = "($self, positions_m, forces_n, *, seed=0)")]
    fn read(&self, positions_m: Column, forces_n: Column, seed: Whole) -> PyResult<Option<(f64, f64)>> {
        let (positions, forces) = (arrays::values(&positions_m), arrays::values(&forces_n));
        arrays::same_length(&[("positions_m", positions.len()), ("forces_n", forces.len())])?;
        let contact = |(position_m, force_n)| PadContact { position_m, force_n };
        let contacts: Vec<PadContact> = positions.into_iter().zip(forces).map(contact).collect();
        let reading = self.0.read(&contacts, &mut ChaCha8Rng::seed_from_u64(seed.0));
        Ok(reading.map(|reading| (reading.position_m, reading.force_n)))
    }

    fn __repr__(&self) -> String {
        let pad = &self.0;
        let mut properties = Vec::new();
        let mut add = |name: &str, value: String, usual: bool| {
            if !usual {
                properties.push(format!("{name}={value}"));
            }
        };
        add("length_m", pad.length_m.to_string(), pad.length_m == f64::INFINITY);
        add("width_m", pad.width_m.to_string(), pad.width_m == f64::INFINITY);
        if let Some(counts) = pad.counts_per_inch {
            add("counts_per_inch", counts.to_string(), false);
        }
        add("noise_sd_m", pad.noise_sd_m.to_string(), pad.noise_sd_m == 0.0);
        if let Some(levels) = pad.pressure_levels {
            add("pressure_levels", levels.to_string(), false);
        }
        add("full_scale_n", pad.full_scale_n.to_string(), pad.full_scale_n == 10.0);
        add("rate_hz", pad.rate_hz.to_string(), pad.rate_hz == 100.0);
        add("dropout", pad.dropout.to_string(), pad.dropout == 0.0);
        add("angle_noise_sd_rad", pad.angle_noise_sd_rad.to_string(), pad.angle_noise_sd_rad == 0.0);
        format!("Touchpad({})", properties.join(", "))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        pickled::by_method::<Self>(py, "_made", (self.properties(py)?,))
    }

    #[staticmethod]
    fn _made<'py>(py: Python<'py>, properties: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyAny>> {
        py.get_type::<Self>().call((), Some(properties))
    }
}

impl Pad {
    /// The arguments that make this pad.
    fn properties<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let properties = PyDict::new(py);
        properties.set_item("length_m", self.0.length_m)?;
        properties.set_item("width_m", self.0.width_m)?;
        properties.set_item("counts_per_inch", self.0.counts_per_inch)?;
        properties.set_item("noise_sd_m", self.0.noise_sd_m)?;
        properties.set_item("pressure_levels", self.0.pressure_levels)?;
        properties.set_item("full_scale_n", self.0.full_scale_n)?;
        properties.set_item("rate_hz", self.0.rate_hz)?;
        properties.set_item("dropout", self.0.dropout)?;
        properties.set_item("angle_noise_sd_rad", self.0.angle_noise_sd_rad)?;
        Ok(properties)
    }
}
