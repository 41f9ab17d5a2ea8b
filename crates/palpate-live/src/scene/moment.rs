//! What is seen at a sample, of either rig: surfaces, contacts, the object, and what is thought of it.

use palpate::Sample;
use palpate::live::Estimate;
use palpate::pivot::{PadPose, PivotSample, StrokesEstimate};
use palpate::reconstruct::OutlinePoint;

/// Palms are drawn so far beyond the furthest contact, as a factor; and where there is none yet, so long, metres.
const BEYOND_CONTACT: f64 = 1.3;
const LENGTH_M: f64 = 0.08;

/// A pad is drawn so far to either side of the foot of the pivot, in heights of the pivot: further than any object that touches it there.
const BESIDE_PIVOT: f64 = 4.0;

/// A moment of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment<'a> {
    /// What the surfaces are called, and the frame that they are in.
    pub(super) surfaces: &'static str,
    pub(super) frame: &'static str,
    /// Ends of each surface, metres.
    pub(super) ends_m: Vec<[[f64; 2]; 2]>,
    /// Where contacts are seen, metres.
    pub(super) contacts_m: Vec<[f64; 2]>,
    /// The pivot, metres.
    pub(super) pivot_m: Option<[f64; 2]>,
    /// Origin of the object's frame, metres, and its orientation, radians.
    pub(super) pose: Option<([f64; 2], f64)>,
    /// The boundary in that frame.
    pub(super) outline: &'a [OutlinePoint],
    /// Whether the frame's origin is the centre of mass.
    pub(super) is_about_mass: bool,
    pub(super) coverage: f64,
    /// Why the estimate is not certified; `None` where it is.
    pub(super) doubt: Option<String>,
}

impl<'a> Moment<'a> {
    /// Of two palms.
    pub fn of_palms(sample: &Sample, estimate: &'a Estimate) -> Self {
        let seen_m = [sample.s1_m, sample.s2_m];
        let furthest_m = seen_m.iter().flatten().copied().fold(0.0, f64::max);
        let length_m = if furthest_m > 0.0 { BEYOND_CONTACT * furthest_m } else { LENGTH_M };
        let at = |s_m: [f64; 2]| <[[f64; 2]; 2]>::from(sample.palms.contact_points_m(s_m[0], s_m[1]));
        let (bases, ends) = (at([0.0; 2]), at([length_m; 2]));
        let places = at(seen_m.map(|s_m| s_m.unwrap_or(f64::NAN)));
        let seen = places.into_iter().zip(seen_m).filter(|(_, s_m)| s_m.is_some());
        Self {
            surfaces: "palms",
            frame: "palms",
            ends_m: bases.into_iter().zip(ends).map(|(base, end)| [base, end]).collect(),
            contacts_m: seen.map(|(place, _)| place).collect(),
            pivot_m: None,
            pose: estimate.pose.as_ref().map(|pose| ([pose.com_x_m, pose.com_y_m], pose.psi_rad)),
            outline: &estimate.outline,
            is_about_mass: true,
            coverage: estimate.coverage,
            doubt: (!estimate.is_certified()).then(|| estimate.reason()),
        }
    }

    /// Of a pivoting grasp over a pad.
    pub fn of_strokes(sample: &PivotSample, estimate: &'a StrokesEstimate, pad: &PadPose) -> Self {
        let pivot_m = [sample.pivot_x_m, sample.pivot_y_m];
        let [foot_m, height_m] = pad.along_and_above(sample.pivot_x_m, sample.pivot_y_m);
        let reach_m = BESIDE_PIVOT * height_m.abs();
        Self {
            surfaces: "pad",
            frame: "world",
            ends_m: vec![[foot_m - reach_m, foot_m + reach_m].map(|along_m| pad.point(along_m, 0.0))],
            contacts_m: sample.s_m.map(|s_m| pad.point(s_m, 0.0)).into_iter().collect(),
            pivot_m: Some(pivot_m),
            pose: estimate.psi_rad.map(|psi_rad| (pivot_m, psi_rad)),
            outline: &estimate.outline,
            is_about_mass: false,
            coverage: estimate.coverage,
            doubt: (!estimate.is_certified()).then(|| estimate.reason()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::palms::PalmPair;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

    /// Whether a contact lies between the ends of its surface.
    fn is_between([base, end]: [[f64; 2]; 2], contact: [f64; 2]) -> bool {
        let [along, whole] = [contact, end].map(|point| [point[0] - base[0], point[1] - base[1]]);
        let share = (along[0] * whole[0] + along[1] * whole[1]) / (whole[0] * whole[0] + whole[1] * whole[1]);
        (along[0] * whole[1] - along[1] * whole[0]).abs() < 1e-12 && (0.0..=1.0).contains(&share)
    }

    #[test]
    fn contacts_lie_on_their_palms() {
        // Palm 1 upright, palm 2 at 60 degrees to its left, its base 10 mm to the left.
        let palms_at = PalmPair { base2_m: [-0.01, 0.0], ..PalmPair::hinged(FRAC_PI_2, FRAC_PI_3) };
        let sample = Sample::new(0.0, palms_at, 0.03, 0.02);
        let estimate = Estimate::default();
        let moment = Moment::of_palms(&sample, &estimate);
        let expected = [[0.0, 0.03], [-0.01 - 0.02 * FRAC_PI_3.sin(), 0.02 * FRAC_PI_3.cos()]];
        for ((contact, ends), [x, y]) in moment.contacts_m.iter().zip(&moment.ends_m).zip(expected) {
            assert!((contact[0] - x).hypot(contact[1] - y) < 1e-12 && is_between(*ends, *contact), "{contact:?}");
        }
        assert_eq!(moment.contacts_m.len(), 2);
        let one = Sample { s1_m: None, ..sample };
        assert_eq!(Moment::of_palms(&one, &estimate).contacts_m.len(), 1);
    }

    #[test]
    fn a_contact_lies_on_the_pad_and_the_object_hangs_from_its_pivot() {
        let pad = PadPose { base_x_m: 0.1, base_y_m: -0.2, tilt_rad: 0.2 };
        let [pivot_x_m, pivot_y_m] = pad.point(0.5, 0.03);
        let sample = PivotSample { time_s: 0.0, pivot_x_m, pivot_y_m, s_m: Some(0.51) };
        let estimate = StrokesEstimate::default();
        let moment = Moment::of_strokes(&sample, &estimate, &pad);
        let [contact] = moment.contacts_m[..] else { panic!("a contact") };
        assert!(is_between(moment.ends_m[0], contact));
        assert!((contact[0] - pivot_x_m).hypot(contact[1] - pivot_y_m) > 0.03);
        assert_eq!((moment.pivot_m, moment.pose), (Some([pivot_x_m, pivot_y_m]), None));
        assert!(Moment::of_strokes(&PivotSample { s_m: None, ..sample }, &estimate, &pad).contacts_m.is_empty());
    }
}
