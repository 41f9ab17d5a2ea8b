//! The figures of Moll & Erdmann (2001), drawn from data of our own, and the page that ties them together.
//!
//! [`figures()`] draws them as SVG, [`png`] makes pictures of them (feature `png`, on unless it is switched off), [`paper_page`] is the
//! page, [`errors_csv`] the table on it. What they show is made elsewhere: logs are simulated and reconstructed by whoever calls.

mod figures;
mod input;
mod page;

use palpate::palms::PalmPair;

use figures::geometry::Rest;

#[cfg(feature = "png")]
pub use crate::drawing::png::{PngError, png};
pub use figures::errors::errors_csv;
pub use figures::figure::{FIGURE_NAMES, Figure};
pub use input::{Method, PaperInput, StrokesTrial, Trial};
pub use page::paper_page;

/// Draws all figures, in the order of [`FIGURE_NAMES`].
pub fn figures(input: &PaperInput) -> Vec<Figure> {
    let mut names = FIGURE_NAMES.into_iter();
    let mut all = Vec::new();
    let mut add = |title: &str, caption: String, svg: String, beside: bool| {
        if let Some(name) = names.next() {
            all.push(Figure { name, title: title.to_owned(), caption, svg, beside });
        }
    };
    let (hinged, apart) = (rest(&input.palms), rest(&input.fingers));
    add(
        "Figure 1. Two arrangements",
        "An object at rest on two palms that share a hinge (a), and on two fingers whose base points lie apart (b). The angles are \
         what the robot sets; s₁ and s₂ are what it feels."
            .to_owned(),
        figures::geometry::arrangements(&hinged, &apart),
        false,
    );
    add(
        "Figure 2. The contact support function",
        "The line with outward normal n(θ) that touches the object lies at the distance r(θ) from the centre of mass O, and the \
         point of contact x(θ) at d(θ) from the foot of the perpendicular."
            .to_owned(),
        figures::geometry::contact_support(input.palms.shape),
        false,
    );
    add(
        "Figure 3. The coordinate frames",
        "The global frame (X, Y) at the base; that of the object (x, y) at its centre of mass, turned by ψ; and at each contact the normal and \
         tangent of the palm, opposite to those of the object. Hence θ = φ₁ − ψ − π/2 (equation 1) and θ₂ = θ + φ₂ − π."
            .to_owned(),
        figures::geometry::frames(&hinged),
        false,
    );
    add(
        "Figure 4. Sensor values, contact support functions and palm angle",
        "With r₁, r₂ and φ₂ known, the sensor values s₁ and s₂ give d₁ and d₂ (equation 3).".to_owned(),
        figures::geometry::dependencies(&hinged),
        false,
    );
    add(
        "Figure 5. The generalised contact support functions",
        "The vector from one contact to the other, projected on normal and tangent of each palm. All four follow from palm angles \
         and sensor values alone (equation 8)."
            .to_owned(),
        figures::geometry::generalized(&hinged),
        false,
    );
    for (trial, is_noisy) in [(&input.palms, true), (&input.exact, false), (&input.fingers, true)] {
        // Without noise the frames look the same.
        for method in Method::BOTH.into_iter().filter(|_| is_noisy) {
            add(
                &format!("Figure 6. Reconstruction in 27 frames: {}, {}", trial.name, method.name()),
                format!(
                    "After 10, 20 … {} measurements: centre of mass and contacts (large dots), and the part of the shape felt so far (small \
                     dots), in the reconstructed pose; behind it the object as it lies.",
                    trial.log.samples.len()
                ),
                figures::frames::frames(trial, method),
                method == Method::Likelihood,
            );
        }
        for method in Method::BOTH {
            add(
                &format!("Figure 7. Actual and observed: {}, {}", trial.name, method.name()),
                "Actual and observed shape after alignment by singular value decomposition (a), radius function (b), orientation (c), and \
                 the error in the norm of the contact point vector (d), which can be seen without knowing the truth."
                    .to_owned(),
                figures::results::differences(trial, method),
                method == Method::Likelihood,
            );
        }
    }
    for method in Method::BOTH {
        add(
            &format!("Figure 8. The experiment, simulated: {}", method.name()),
            format!(
                "Palms with touchpads and the markers that a camera follows (a); shape as observed, in grey what was felt fewer than {} times \
                 and can be left out (b); orientation as observed and as the camera sees it (c).",
                input.min_touches
            ),
            figures::results::experiment(&input.experiment, method, input.vision, input.min_touches),
            method == Method::Likelihood,
        );
    }
    add(
        "Figure 9. The pivoting grasp",
        "The rig that the paper left open: an arm holds the object at a pivot and drags it over one pad, here at instants of the first stroke (a). Where \
         the pad felt it, laid on the actual shape (b), and the orientation (c), by maximum likelihood from readings of pad and arm alone."
            .to_owned(),
        figures::pivot::pivoting_grasp(&input.strokes),
        false,
    );
    all
}

/// The object of a trial as it rests where the palms show the geometry best.
fn rest<'a>(trial: &Trial<'a>) -> Rest<'a> {
    // Both contacts away from the feet, the palms upright and neither flat nor steep.
    let score = |palms: &PalmPair, psi: f64| {
        let (theta1, theta2) = palms.contact_angles(psi);
        let feet = trial.shape.at(theta1).d.abs().min(trial.shape.at(theta2).d.abs()) / trial.shape.mean_radius_m();
        feet.min(0.3) - (palms.phi2_rad - 1.1).abs() - (palms.phi1_rad - 1.0).abs()
    };
    trial
        .log
        .samples
        .iter()
        .zip(&trial.truth.motion)
        .map(|(sample, pose)| (score(&sample.palms, pose.psi_rad), sample.palms, pose.psi_rad))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(Rest { shape: trial.shape, palms: PalmPair::hinged(0.7, 1.5), psi_rad: 0.0 }, |(_, palms, psi_rad)| {
            Rest { shape: trial.shape, palms, psi_rad }
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::compare::RigidMotion;
    use palpate::pivot::{PivotCalibration, PivotLog, PivotReconstruction, PivotTolerances};
    use palpate::reconstruct::{Doubt, FoundSymmetry, Verdict};
    use palpate::sensor::VisionSystem;
    use palpate::shape::SupportFunction;
    use palpate::{Log, Reconstruction, Truth};

    #[test]
    fn nothing_gives_figures_of_nothing() {
        let (log, truth, shape) = (Log::default(), Truth::default(), SupportFunction::new(0.03, vec![]));
        let found = Reconstruction {
            findings: None,
            shape: shape.clone(),
            outline: vec![],
            motion: vec![],
            verdict: Verdict::new(vec![Doubt::NotConvex]),
            chi2_per_dof: f64::NAN,
            jumps: vec![],
            coverage: 0.0,
            symmetry: FoundSymmetry::default(),
            alternatives: 1,
            others: vec![],
            sensor_sd_m: f64::NAN,
            balance_sd_m: f64::NAN,
            calibration: None,
            friction: None,
            inertia: None,
        };
        let vision = VisionSystem {
            noise_sd_m: 0.0,
            object_markers_m: vec![],
            palm_markers_m: vec![],
            camera: RigidMotion { angle_rad: 0.0, offset_m: [0.0; 2] },
        };
        let trial = Trial {
            name: "<nothing>",
            file: "nothing",
            log: &log,
            truth: &truth,
            shape: &shape,
            pad_length_m: 0.05,
            ode: &found,
            likelihood: &found,
        };
        let strokes_found = PivotReconstruction {
            shape: shape.clone(),
            outline: vec![],
            motion: vec![],
            doubts: vec![],
            chi2_per_dof: f64::NAN,
            coverage: 0.0,
            alternatives: 1,
            others: vec![],
            segments: 0,
            sensor_sd_m: f64::NAN,
            arm_sd_m: f64::NAN,
            calibration: PivotCalibration::default(),
            calibration_sd: PivotTolerances::default(),
            center_of_mass: None,
        };
        let strokes_log = PivotLog { samples: vec![], swing_period_s: None };
        let strokes = StrokesTrial { log: &strokes_log, truth: &truth, shape: &shape, found: &strokes_found };
        let input = PaperInput {
            strokes,
            palms: trial,
            exact: trial,
            fingers: trial,
            experiment: trial,
            vision: &vision,
            min_touches: 2,
            simulation_sd_m: 0.0,
            version: "0",
        };
        let all = figures(&input);
        assert_eq!(all.iter().map(|figure| figure.name).collect::<Vec<_>>(), FIGURE_NAMES);
        for figure in &all {
            assert!(!figure.svg.contains("NaN") && !figure.svg.contains("inf"), "{}", figure.name);
            assert!(png(&figure.svg).is_ok(), "{}", figure.name);
        }
        let page = paper_page(&input, &all);
        assert!(page.contains("&lt;nothing&gt;") && !page.contains("<nothing>") && !page.contains("NaN"));
        assert!(errors_csv(&input).contains("\nnothing,ode,,,,,"), "{}", errors_csv(&input));
    }
}
