//! What strokes determine, and how well any method could: Fisher information of the shape about the pivot, its null directions and the
//! Cramér–Rao bound (Kay, *Fundamentals of Statistical Signal Processing: Estimation Theory*, 1993, section 3.7).
//!
//! Each sample measures r(θ) and d(θ) with its own unknown θ. What is left of the two without θ is one number, across the curve (r, d). A
//! common rotation of shape and angles changes nothing: one null direction always. The centre of mass is in no equation. Where
//! d = 0 and r = v at once, a sample does not tell θ: the pivot stands over a contact whose radius of curvature is its height, as
//! everywhere on a circle about P.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use crate::estimate::coverage::{LONGEST_SLIDE, NODES, touches};
use crate::information::{Information, InformationError};
use crate::pivot::calibration::{Reading, TOLD};
use crate::pivot::error_bars::ErrorBars;
use crate::pivot::harmonic_prior::HarmonicPrior;
use crate::pivot::rig::PivotRig;
use crate::pivot::rows::sums_of_outer_products;
use crate::pivot::smoother::{Noise, Problem, State};
use crate::shape::SupportFunction;

/// Directions of the shape whose information is below this share of the largest are not told: to rounding of a sum over the samples.
const NULL: f64 = 1e-11;

/// A sample whose own readings leave its θ with more than this standard deviation, radians, is blind.
const BLIND_RAD: f64 = 0.1;

/// What the samples of some strokes tell.
#[derive(Clone, Debug, PartialEq)]
pub struct Observability {
    /// Unknowns of the shape: 2K + 1, and the open constants of the rig.
    pub unknowns: usize,
    /// Directions of these that no sample tells, the common rotation not among them. 0 = the shape is observable.
    pub null_directions: usize,
    /// The null directions as changes of the support function, each with the root of the mean square of its coefficients 1; the part that is
    /// of the rig's constants left out.
    pub null_shapes: Vec<SupportFunction>,
    /// Whether a common rotation changes the shape at all. It does not of a circle about the pivot: then no θ is observable either.
    pub has_rotation: bool,
    /// Samples with a contact that do not tell their own θ even if the shape is known.
    pub blind_samples: Vec<usize>,
    /// The Cramér–Rao bound: covariance of the shape after the best rotation over the felt boundary; `None` where a direction is not told.
    pub bound: Option<Information>,
}

/// What strokes tell of `shape` (about the pivot) when its contact is at `theta_rad` in each sample (`None`: no contact) and the foot of the
/// pivot stands at `along_m` on the pad, for noise of pad and arm (standard deviations, metres). The tolerances of `rig` say which of its
/// constants are unknown as well.
///
/// # Errors
/// When the lengths differ, a number is not finite, or the noise is not positive.
pub fn observability(
    shape: &SupportFunction,
    theta_rad: &[Option<f64>],
    along_m: &[f64],
    rig: &PivotRig,
    [pad_sd_m, arm_sd_m]: [f64; 2],
) -> Result<Observability, InformationError> {
    let bad = |what: &str| Err(InformationError::BadNumber { what: what.to_owned() });
    if theta_rad.len() != along_m.len() {
        return Err(InformationError::LengthsDiffer { orientations: theta_rad.len(), samples: along_m.len() });
    }
    if !(pad_sd_m >= 0.0 && arm_sd_m > 0.0 && (pad_sd_m + arm_sd_m).is_finite()) {
        return bad("the noise of the arm must be positive, that of the pad not negative, metres");
    }
    if shape.has_nonfinite() || !(shape.mean_radius_m() > 0.0) {
        return bad("the shape is no object");
    }
    if theta_rad.iter().flatten().chain(along_m).any(|value| !value.is_finite()) {
        return bad("an angle or a place of the pivot is not finite");
    }
    let contacts: Vec<(usize, f64)> =
        theta_rad.iter().enumerate().filter_map(|(index, theta)| theta.map(|theta| (index, theta))).collect();
    let readings: Vec<Reading> = contacts
        .iter()
        .map(|&(index, theta)| {
            let contact = shape.at(theta);
            Reading { along_m: along_m[index], above_m: contact.r, s_m: along_m[index] - contact.d }
        })
        .collect();
    let told = rig.tolerances.told();
    let problem = Problem {
        readings: &readings,
        noise: Noise { r_m: arm_sd_m, d_m: pad_sd_m.hypot(arm_sd_m) },
        order: shape.harmonics_m().len(),
        size_m: shape.mean_radius_m(),
        harmonics: HarmonicPrior::of_scale(shape.mean_radius_m()),
        stated: rig.calibration.with_told([0.0; TOLD]),
        open: told.into_iter().enumerate().filter(|(_, sd)| *sd > 0.0).collect(),
        between: None,
    };
    let state = State {
        coefficients: shape.coefficients(),
        told: [0.0; TOLD],
        theta_rad: contacts.iter().map(|(_, theta)| *theta).collect(),
    };
    let mut linear = problem.linearised(&state);
    let blind_samples = contacts
        .iter()
        .zip(&linear.told.slopes)
        .filter(|(_, slope)| slope[0].hypot(slope[1]) * BLIND_RAD < 1.0)
        .map(|(&(index, _), _)| index)
        .collect();
    // The data's own information: no prior of the shape. That of the rig's constants stays.
    let rows = (&linear.told.jacobian, &linear.told.left[..]);
    (linear.information, _) = sums_of_outer_products(&[rows], problem.unknowns());
    let shape_unknowns = state.coefficients.len();
    for (place, &(_, sd)) in problem.open.iter().enumerate() {
        let index = shape_unknowns + place;
        linear.information[(index, index)] += 1.0 / (sd * sd);
    }
    let rotation = linear.layout(&state.coefficients).rotation(&state.coefficients);
    let has_rotation = rotation.norm() > 1e-9 * problem.size_m;
    let null_shapes = null_shapes(&linear.information, has_rotation.then_some(&rotation), shape_unknowns, &problem);
    let bound = if null_shapes.is_empty() && has_rotation && !contacts.is_empty() {
        let paths: Vec<Vec<f64>> = contacts
            .chunk_by(|a, b| b.0 == a.0 + 1 && (b.1 - a.1).abs() <= LONGEST_SLIDE)
            .map(|path| path.iter().map(|(_, theta)| *theta).collect())
            .collect();
        let counts = touches(&paths);
        let felt_rad: Vec<f64> =
            (0..NODES).filter(|&node| counts[node] > 0).map(|node| TAU * node as f64 / NODES as f64).collect();
        let bars = ErrorBars::new(&linear, &linear, &state, &felt_rad);
        bars.and_then(|bars| Information::from_parts(bars.of_shape(), felt_rad).ok())
    } else {
        None
    };
    Ok(Observability {
        unknowns: problem.unknowns(),
        null_directions: null_shapes.len(),
        null_shapes,
        has_rotation,
        blind_samples,
        bound,
    })
}

/// Directions without information, besides the rotation.
fn null_shapes(
    information: &DMatrix<f64>,
    rotation: Option<&nalgebra::DVector<f64>>,
    shape_unknowns: usize,
    problem: &Problem,
) -> Vec<SupportFunction> {
    // Constants in units of their tolerances, so that one number is small for all.
    let mut scaled = information.clone();
    let scale =
        |index: usize| if index < shape_unknowns { problem.size_m } else { problem.open[index - shape_unknowns].1 };
    for row in 0..scaled.nrows() {
        for column in 0..scaled.ncols() {
            scaled[(row, column)] *= scale(row) * scale(column);
        }
    }
    let largest = scaled.diagonal().max();
    if let Some(rotation) = rotation {
        let unit = nalgebra::DVector::from_fn(rotation.len(), |index, _| rotation[index] / scale(index)).normalize();
        scaled += &unit * unit.transpose() * largest;
    }
    let eigen = scaled.symmetric_eigen();
    eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
        .filter(|(value, _)| **value <= NULL * largest)
        .map(|(_, vector)| {
            let part: Vec<f64> = vector.iter().take(shape_unknowns).copied().collect();
            let rms = (part.iter().map(|value| value * value).sum::<f64>() / shape_unknowns as f64).sqrt().max(1e-300);
            SupportFunction::from_coefficients(&part.iter().map(|value| value / rms).collect::<Vec<f64>>())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: [f64; 2] = [1e-4, 2e-5];

    fn pebble() -> SupportFunction {
        SupportFunction::new(0.03, vec![[0.003, 0.002], [0.002, -0.001], [0.0004, 0.0006]])
    }

    fn turns(count: usize, turn_rad: f64) -> (Vec<Option<f64>>, Vec<f64>) {
        let theta = |index: usize| turn_rad * index as f64 / count as f64;
        ((0..count).map(|index| Some(theta(index))).collect(), (0..count).map(|index| 0.03 * theta(index)).collect())
    }

    #[test]
    fn a_turn_tells_the_shape_and_the_bound_falls_with_the_root_of_the_samples() {
        let bound = |count: usize| {
            let (theta, along) = turns(count, TAU);
            let told = observability(&pebble(), &theta, &along, &PivotRig::default(), NOISE).expect("it is in range");
            assert_eq!((told.null_directions, told.has_rotation, told.unknowns), (0, true, 7));
            told.bound.expect("it is determined").rms_r_sd_m()
        };
        let (few, many) = (bound(200), bound(800));
        assert!((few / many - 2.0).abs() < 0.02, "{few} {many}");
        assert!(many > 0.0 && many < 1e-5);
    }

    #[test]
    fn a_circle_about_the_pivot_tells_its_radius_and_no_angle() {
        let (theta, along) = turns(300, TAU);
        let circle = SupportFunction::new(0.03, vec![[0.0, 0.0], [0.0, 0.0]]);
        let told = observability(&circle, &theta, &along, &PivotRig::default(), NOISE).expect("it is in range");
        assert!(!told.has_rotation && told.bound.is_none());
        assert_eq!(told.blind_samples.len(), 300);
    }

    #[test]
    fn a_pivot_over_a_contact_as_curved_as_it_is_high_is_blind_there_and_nowhere_else() {
        // r = a + c (cos 2θ − 4 cos θ): at 0 both d = 0 and r − v = −r'' = 0.
        let shape = SupportFunction::new(0.03, vec![[-4e-3, 0.0], [1e-3, 0.0]]);
        let contact = shape.at(0.0);
        assert!(contact.d.abs() < 1e-15 && (contact.r - contact.v).abs() < 1e-15);
        let (theta, along) = turns(360, TAU);
        let told = observability(&shape, &theta, &along, &PivotRig::default(), NOISE).expect("it is in range");
        assert!(told.blind_samples.contains(&0) && told.blind_samples.len() < 60, "{:?}", told.blind_samples);
        // A sample just above the limit and one just below.
        let sd = |index: usize| {
            let contact = shape.at(theta[index].expect("a contact"));
            1.0 / (contact.d / NOISE[1]).hypot((contact.r - contact.v) / NOISE[0].hypot(NOISE[1]))
        };
        for index in 0..360 {
            assert_eq!(told.blind_samples.contains(&index), sd(index) > BLIND_RAD);
        }
    }

    #[test]
    fn a_constant_height_tells_one_point_of_the_curve() {
        let along: Vec<f64> = (0..100).map(|index| 1e-3 * f64::from(index)).collect();
        let told = observability(&pebble(), &[Some(0.7); 100], &along, &PivotRig::default(), NOISE).expect("in range");
        // Of seven unknowns one number is told, and one is the rotation.
        assert_eq!(told.null_directions, 5);
        assert!(told.bound.is_none());
        // A null direction changes neither height nor offset by more than the angle can follow.
        for null in &told.null_shapes {
            let (change, contact) = (null.at(0.7), pebble().at(0.7));
            let across = change.r * (contact.r - contact.v) + change.d * contact.d;
            assert!(across.abs() < 1e-5 * (contact.r - contact.v).hypot(contact.d), "{across}");
        }
    }

    #[test]
    fn a_translation_of_the_object_is_told_and_the_centre_of_mass_is_no_unknown() {
        // The first harmonic is the place of the pivot in the form: it is determined as any other.
        let (theta, along) = turns(400, TAU);
        let told = observability(&pebble(), &theta, &along, &PivotRig::default(), NOISE).expect("it is in range");
        assert!(told.bound.expect("it is determined").center_of_mass_sd_m() < 5e-5);
    }

    #[test]
    fn open_constants_cost_something_and_are_told_by_a_turn() {
        let (theta, along) = turns(400, TAU);
        let rms = |rig: &PivotRig| {
            observability(&pebble(), &theta, &along, rig, NOISE)
                .expect("in range")
                .bound
                .expect("determined")
                .rms_r_sd_m()
        };
        let exact = rms(&PivotRig::default());
        let open = rms(&PivotRig::uncalibrated(crate::pivot::PadPose::default()));
        assert!(open > 1.02 * exact && open < 1e-3, "{exact} {open}");
    }

    #[test]
    fn what_is_out_of_range_is_an_error() {
        let rig = PivotRig::default();
        assert!(observability(&pebble(), &[None], &[], &rig, NOISE).is_err());
        assert!(observability(&pebble(), &[Some(f64::NAN)], &[0.0], &rig, NOISE).is_err());
        assert!(observability(&pebble(), &[None], &[0.0], &rig, [1e-4, 0.0]).is_err());
        let empty = observability(&pebble(), &[None], &[0.0], &rig, NOISE).expect("nothing is felt");
        assert!(empty.bound.is_none() && empty.null_directions > 0);
    }
}
