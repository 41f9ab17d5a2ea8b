//! The support function against finite differences, polygons, an ellipse and the laws of rotation and translation.

use std::f64::consts::{PI, TAU};

use palpate::shape::{
    BoundaryPoint, NamedShape, RandomShape, ShapeError, SupportFunction, ellipse, random_shape, rounded_polygon,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn pebble(seed: u64) -> SupportFunction {
    random_shape(&RandomShape::default(), seed).expect("the default kind is valid")
}

/// Area, centroid and perimeter of the boundary as a fine polygon.
fn polygon(shape: &SupportFunction) -> (f64, f64, f64, f64) {
    let corners: Vec<BoundaryPoint> =
        (0..20_000).map(|i| shape.boundary_point(TAU * f64::from(i) / 20_000.0)).collect();
    let (mut double_area, mut x, mut y, mut length) = (0.0, 0.0, 0.0, 0.0);
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let cross = a.x_m * b.y_m - a.y_m * b.x_m;
        double_area += cross;
        x += cross * (a.x_m + b.x_m);
        y += cross * (a.y_m + b.y_m);
        length += (b.x_m - a.x_m).hypot(b.y_m - a.y_m);
    }
    (0.5 * double_area, x / (3.0 * double_area), y / (3.0 * double_area), length)
}

/// The same cases every time; change the seed to explore.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases(25))]

    #[test]
    fn d_and_v_are_derivatives_of_r(seed in 0_u64..10_000, theta in -10.0..10.0_f64) {
        let (shape, h) = (pebble(seed), 1e-4);
        let [before, here, after] = [-h, 0.0, h].map(|step| shape.at(theta + step));
        let size = shape.mean_radius_m();
        prop_assert!((here.d + (after.r - before.r) / (2.0 * h)).abs() < 1e-6 * size);
        prop_assert!((here.v - here.r - (after.r - 2.0 * here.r + before.r) / (h * h)).abs() < 1e-5 * size);
        // x' = −v t
        let (a, b) = (shape.boundary_point(theta - h), shape.boundary_point(theta + h));
        let slope = [(b.x_m - a.x_m) / (2.0 * h), (b.y_m - a.y_m) / (2.0 * h)];
        prop_assert!((slope[0] + here.v * theta.sin()).abs() < 1e-6 * size);
        prop_assert!((slope[1] - here.v * theta.cos()).abs() < 1e-6 * size);
        prop_assert!((shape.radius_m(theta) - here.r).abs() < 1e-15);
    }

    #[test]
    fn area_centroid_and_perimeter_are_those_of_the_polygon(seed in 0_u64..10_000) {
        let shape = pebble(seed);
        let (area, x, y, length) = polygon(&shape);
        let size = shape.mean_radius_m();
        prop_assert!((shape.area_m2() / area - 1.0).abs() < 1e-6);
        prop_assert!((shape.perimeter_m() / length - 1.0).abs() < 1e-6);
        let centroid = shape.centroid();
        prop_assert!((centroid.x_m - x).hypot(centroid.y_m - y) < 1e-6 * size);
    }

    #[test]
    fn rotation_and_translation_move_the_boundary(
        seed in 0_u64..10_000, theta in -4.0..4.0_f64, angle in -4.0..4.0_f64, x in -0.01..0.01_f64, y in -0.01..0.01_f64,
    ) {
        let shape = pebble(seed);
        let (point, turned) = (shape.boundary_point(theta), shape.rotated(angle).boundary_point(theta + angle));
        let (sin, cos) = angle.sin_cos();
        prop_assert!((turned.x_m - (point.x_m * cos - point.y_m * sin)).abs() < 1e-14);
        prop_assert!((turned.y_m - (point.x_m * sin + point.y_m * cos)).abs() < 1e-14);
        let moved = shape.translated(x, y).boundary_point(theta);
        prop_assert!((moved.x_m - point.x_m - x).abs() < 1e-14 && (moved.y_m - point.y_m - y).abs() < 1e-14);
        prop_assert!((shape.translated(x, y).area_m2() / shape.area_m2() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn lengths_grow_with_the_scale_and_areas_with_its_square(
        seed in 0_u64..10_000, theta in -4.0..4.0_f64, factor in 0.1..10.0_f64,
    ) {
        let shape = pebble(seed);
        let larger = shape.scaled(factor);
        prop_assert!((larger.perimeter_m() / shape.perimeter_m() / factor - 1.0).abs() < 1e-14);
        prop_assert!((larger.area_m2() / shape.area_m2() / (factor * factor) - 1.0).abs() < 1e-12);
        let (point, there) = (shape.boundary_point(theta), larger.boundary_point(theta));
        prop_assert!((there.x_m - factor * point.x_m).hypot(there.y_m - factor * point.y_m) < 1e-14 * factor);
        prop_assert_eq!(shape.scaled(1.0), shape);
    }

    #[test]
    fn random_shapes_are_as_convex_as_asked(seed in 0_u64..10_000, order in 1_usize..16, amplitude in 0.0..3.0_f64) {
        let kind = RandomShape { order, amplitude, ..RandomShape::default() };
        let shape = random_shape(&kind, seed).expect("a valid kind");
        let least = (0..5000).map(|i| shape.at(TAU * f64::from(i) / 5000.0).v).fold(f64::INFINITY, f64::min);
        prop_assert!(least > kind.smallest_curvature * kind.mean_radius_m);
        // The refined minimum is below every sample, and close to the least.
        let refined = shape.min_curvature_radius_m();
        prop_assert!(refined <= least + 1e-15 && refined > least - 1e-4 * kind.mean_radius_m);
        prop_assert_eq!(shape, random_shape(&kind, seed).expect("a valid kind"));
    }

    #[test]
    fn samples_of_a_support_function_give_it_back(seed in 0_u64..10_000, shift in 0.0..1.0_f64) {
        let shape = pebble(seed);
        // Uneven angles, with a gap.
        let uneven: Vec<(f64, f64)> = (0..200)
            .map(|i| f64::from(i) / 200.0)
            .map(|u| shift + 5.6 * (u + 0.05 * (7.0 * u).sin()))
            .map(|theta| (theta, shape.radius_m(theta)))
            .collect();
        let even: Vec<(f64, f64)> =
            (0..64).map(|i| TAU * f64::from(i) / 64.0).map(|theta| (theta, shape.radius_m(theta))).collect();
        for (samples, tolerance) in [(uneven, 1e-9), (even, 1e-14)] {
            let again = SupportFunction::from_samples(&samples, 6).expect("enough samples");
            for i in 0..50 {
                let theta = f64::from(i) * 0.13;
                prop_assert!((again.radius_m(theta) - shape.radius_m(theta)).abs() < tolerance);
            }
        }
    }
}

#[test]
fn an_ellipse_has_its_textbook_values() {
    let (a, b) = (0.035, 0.025);
    let shape = ellipse(a, b).expect("valid axes");
    for i in 0..360 {
        let theta = f64::from(i).to_radians();
        let r = (a * theta.cos()).hypot(b * theta.sin());
        let v = a * a * b * b / r.powi(3);
        let contact = shape.at(theta);
        assert!((contact.r - r).abs() < 1e-12 * a, "r at {i} degrees");
        assert!((contact.d - (a * a - b * b) * theta.sin() * theta.cos() / r).abs() < 1e-11 * a, "d at {i} degrees");
        assert!((contact.v - v).abs() < 1e-9 * a, "v at {i} degrees");
    }
    assert!((shape.area_m2() / (PI * a * b) - 1.0).abs() < 1e-12);
    assert!((shape.min_curvature_radius_m() - b * b / a).abs() < 1e-9 * a);
    assert!(shape.centroid().x_m.hypot(shape.centroid().y_m) < 1e-14);
}

#[test]
fn a_dented_outline_is_not_convex() {
    // v = 1 − 3·0.4 cos 2θ is negative around 0.
    let dented = SupportFunction::new(1.0, vec![[0.0; 2], [0.4, 0.0]]);
    assert!(!dented.is_convex());
    assert!((dented.min_curvature_radius_m() + 0.2).abs() < 1e-12);
    // The lines at ±30 degrees meet where y = (0.6 − 0.8 cos² θ) sin θ vanishes, at x = 1.6 cos 30°.
    assert!((dented.concavity_m() - (1.4 - 1.6 * 0.75_f64.sqrt())).abs() < 1e-6);
    let turned = dented.rotated(0.7).scaled(0.03);
    assert!((turned.concavity_m() - 0.03 * dented.concavity_m()).abs() < 5e-6 * 0.03, "between two lines");
    assert!(dented.damped_to_convex().is_convex());
    let convex = SupportFunction::new(1.0, vec![[0.0; 2], [0.33, 0.0]]);
    assert!(convex.is_convex() && convex.concavity_m() == 0.0);
    // A ripple of the radius of curvature is a matter of its arc squared: harmonic 40 with v down to −0.1.
    let mut harmonics = vec![[0.0; 2]; 40];
    harmonics[39] = [1.1 / (40.0 * 40.0 - 1.0), 0.0];
    let rippled = SupportFunction::new(1.0, harmonics);
    assert!(rippled.min_curvature_radius_m() < -0.09 && rippled.concavity_m() > 0.0 && rippled.concavity_m() < 1e-5);
    assert!(SupportFunction::new(-1.0, vec![]).concavity_m().is_infinite());
}

#[test]
fn named_shapes_have_the_size_asked_for_and_are_convex() {
    for name in NamedShape::NAMES {
        let named: NamedShape = name
            .replace("SEED", "17")
            .replace("LENGTHxWIDTH", "60x40")
            .replace("[xCORNER]", "x5")
            .parse()
            .expect("a listed name");
        assert_eq!(named.to_string().parse(), Ok(named));
        let shape = named.shape(0.03).expect("a valid size");
        assert!((shape.mean_radius_m() - 0.03).abs() < 1e-15 && shape.is_convex(), "{name}");
    }
    let egg = NamedShape::Egg.shape(0.03).expect("a valid size").centroid();
    assert!(egg.x_m.hypot(egg.y_m) < 1e-15);
    assert!("brick".parse::<NamedShape>().is_err_and(|error| error.to_string().contains("circle, disc")));
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(NamedShape::Egg.shape(size).is_err());
    }
}

#[test]
fn a_rounded_polygon_has_its_symmetry() {
    let shape = rounded_polygon(3, 0.3, 0.2).expect("valid numbers");
    for i in 0..50 {
        let theta = 0.1 * f64::from(i);
        assert!((shape.radius_m(theta) - shape.radius_m(theta + TAU / 3.0)).abs() < 1e-14);
    }
    // Flat sides face θ = 0, corners the middle between two.
    assert!(shape.at(0.0).v > 2.0 && (shape.at(PI / 3.0).v - 0.3).abs() < 0.02);
    assert!(rounded_polygon(1, 0.3, 0.2).is_err() && rounded_polygon(3, 0.0, 0.2).is_err());
}

#[test]
fn a_polygon_becomes_a_convex_shape_about_its_centroid() {
    let corner = |x_m: f64, y_m: f64| BoundaryPoint { x_m, y_m };
    let square = [corner(0.01, 0.01), corner(0.05, 0.01), corner(0.05, 0.05), corner(0.01, 0.05), corner(0.03, 0.02)];
    let shape = SupportFunction::from_boundary_points(&square, 24, None).expect("a square");
    assert!(shape.is_convex());
    // Perimeter of the hull, from the mean of the support function.
    assert!((shape.perimeter_m() / 0.16 - 1.0).abs() < 1e-3);
    let centroid = shape.centroid();
    assert!(centroid.x_m.hypot(centroid.y_m) < 1e-6);
    assert!((shape.radius_m(0.0) - 0.02).abs() < 2.5e-3);
    let about = SupportFunction::from_boundary_points(&square, 24, Some(corner(0.03, 0.04))).expect("a square");
    assert!((about.centroid().y_m + 0.01).abs() < 1e-6);
    // Points of a smooth outline give the outline.
    let pebble = pebble(3);
    let outline: Vec<BoundaryPoint> = (0..3000).map(|i| pebble.boundary_point(TAU * f64::from(i) / 3000.0)).collect();
    let again = SupportFunction::from_boundary_points(&outline, 6, Some(corner(0.0, 0.0))).expect("a pebble");
    for i in 0..60 {
        let theta = 0.11 * f64::from(i);
        assert!((again.radius_m(theta) - pebble.radius_m(theta)).abs() < 1e-7);
    }
}

#[test]
fn useless_points_are_refused() {
    let corner = |x_m: f64, y_m: f64| BoundaryPoint { x_m, y_m };
    let line = [corner(0.0, 0.0), corner(1.0, 1.0), corner(2.0, 2.0)];
    assert_eq!(SupportFunction::from_boundary_points(&line, 4, None), Err(ShapeError::Undetermined));
    assert!(SupportFunction::from_boundary_points(&line[..2], 4, None).is_err());
    let hole = [corner(0.0, 0.0), corner(1.0, f64::NAN), corner(2.0, 2.0)];
    assert_eq!(SupportFunction::from_boundary_points(&hole, 4, None), Err(ShapeError::NotFinite { index: 1 }));
    let same = [(0.5, 1.0); 20];
    assert_eq!(SupportFunction::from_samples(&same, 3), Err(ShapeError::Undetermined));
    assert!(SupportFunction::from_samples(&same[..3], 3).is_err());
}

fn corner(x_m: f64, y_m: f64) -> BoundaryPoint {
    BoundaryPoint { x_m, y_m }
}

/// The hull of an outline about `center` against a shape: how far the shape is inside and outside of it at most.
fn distances(shape: &SupportFunction, outline: &[BoundaryPoint], center: BoundaryPoint) -> (f64, f64) {
    let gained = |theta: f64| {
        let (sin, cos) = theta.sin_cos();
        let heights = outline.iter().map(|p| (p.x_m - center.x_m) * cos + (p.y_m - center.y_m) * sin);
        shape.radius_m(theta) - heights.fold(f64::NEG_INFINITY, f64::max)
    };
    let all: Vec<f64> = (0..3600).map(|step| gained(TAU * f64::from(step) / 3600.0)).collect();
    (all.iter().copied().fold(0.0, f64::min).abs(), all.iter().copied().fold(0.0, f64::max))
}

#[test]
fn an_outline_says_what_its_fit_costs() {
    // A bar of soap with sharp corners, away from the origin, run clockwise.
    let soap = [corner(0.01, 0.0), corner(0.01, 0.04), corner(0.07, 0.04), corner(0.07, 0.0)];
    let fit = SupportFunction::from_outline(&soap).expect("a bar of soap");
    assert!(fit.shape.is_convex() && fit.shape.harmonics_m().len() == 256 && fit.dent_m == 0.0);
    let (cut, bulge) = distances(&fit.shape, &soap, corner(0.04, 0.02));
    assert!((fit.cut_m - cut).abs() < 2e-5 && (fit.bulge_m - bulge).abs() < 2e-5, "{cut} {bulge} {fit:?}");
    assert!(fit.residual_m() == fit.cut_m.max(fit.bulge_m) && (1e-4..6e-4).contains(&fit.residual_m()), "{fit:?}");
    let few = SupportFunction::from_boundary_points(&soap, 32, None).expect("the same");
    let (cut, bulge) = distances(&few, &soap, corner(0.04, 0.02));
    assert!(cut.max(bulge) > 3.0 * fit.residual_m(), "{cut} {bulge} against {}", fit.residual_m());
    // The origin is the centroid, and may be moved.
    assert!(fit.shape.centroid().x_m.hypot(fit.shape.centroid().y_m) < 1e-6);
    let about = fit.about(0.01, -0.002).shape.centroid();
    assert!((about.x_m + 0.01).abs() < 1e-6 && (about.y_m - 0.002).abs() < 1e-6);
}

#[test]
fn a_smooth_outline_takes_few_harmonics() {
    let pebble = pebble(3);
    let outline: Vec<BoundaryPoint> = (0..3000).map(|i| pebble.boundary_point(TAU * f64::from(i) / 3000.0)).collect();
    let fit = SupportFunction::from_outline(&outline).expect("a pebble");
    assert!(fit.shape.harmonics_m().len() == 8 && fit.residual_m() < 1e-6 && fit.dent_m < 1e-6, "{fit:?}");
    assert!((fit.shape.area_m2() / pebble.area_m2() - 1.0).abs() < 1e-4);
}

#[test]
fn samples_of_a_support_function_choose_their_harmonics() {
    let pebble = pebble(3);
    let samples: Vec<(f64, f64)> =
        (0..720).map(|i| TAU * f64::from(i) / 720.0).map(|theta| (theta, pebble.radius_m(theta))).collect();
    let fit = SupportFunction::from_support(&samples).expect("a pebble");
    assert!(fit.residual_m() < 1e-12 && fit.shape.harmonics_m().len() == 8);
    // A third of ten samples: three harmonics.
    let few = SupportFunction::from_support(&samples.iter().step_by(72).copied().collect::<Vec<_>>()).expect("ten");
    assert_eq!(few.shape.harmonics_m().len(), 3);
    assert!(SupportFunction::from_support(&samples[..2]).is_err());
}

#[test]
fn a_dent_is_closed_by_the_hull_and_said() {
    let notched = [corner(0.0, 0.0), corner(0.06, 0.0), corner(0.06, 0.04), corner(0.03, 0.035), corner(0.0, 0.04)];
    let fit = SupportFunction::from_outline(&notched).expect("a convex hull");
    assert!((fit.dent_m - 0.005).abs() < 1e-12, "{}", fit.dent_m);
    // The mass is that of the outline, not of the hull.
    assert!(fit.shape.centroid().y_m > 1e-4);
    let eight = [corner(0.0, 0.0), corner(0.06, 0.04), corner(0.06, 0.0), corner(0.0, 0.04)];
    assert_eq!(SupportFunction::from_outline(&eight), Err(ShapeError::Undetermined));
    assert!(SupportFunction::from_outline(&eight[..2]).is_err());
    let line = [corner(0.0, 0.0), corner(1.0, 1.0), corner(2.0, 2.0)];
    assert_eq!(SupportFunction::from_outline(&line), Err(ShapeError::Undetermined));
    let hole = [corner(0.0, 0.0), corner(1.0, f64::NAN), corner(2.0, 2.0)];
    assert_eq!(SupportFunction::from_outline(&hole), Err(ShapeError::NotFinite { index: 1 }));
}

#[test]
fn rectangles_and_stadiums_have_sizes_in_their_names() {
    let named = |name: &str| name.parse::<NamedShape>().expect("a name");
    let fit = named("rectangle:60x40x10").fitted(None).expect("a rectangle");
    assert!((fit.shape.perimeter_m() - (0.2 - 0.08 + 0.02 * PI)).abs() < 1e-4);
    assert!(
        (fit.shape.radius_m(0.0) - 0.03).abs() <= fit.residual_m() && fit.residual_m() < 3e-4,
        "{}",
        fit.residual_m()
    );
    assert!(fit.shape.is_convex() && named("rectangle:60x40x0").fitted(None).expect("sharp").shape.is_convex());
    assert_eq!(named("Rectangle:60x40"), named("rectangle:60x40x8"));
    for name in ["rectangle:60x40x8", "stadium:60x40", "rectangle:0.1x29.7x0.01"] {
        assert_eq!(named(name).to_string(), name);
    }
    let stadium = named("stadium:60x40").fitted(None).expect("a stadium").shape;
    assert!((stadium.perimeter_m() - (0.04 + 0.04 * PI)).abs() < 1e-4 && stadium.is_convex());
    for name in ["stadium:60x40", "rectangle:60x40x10", "egg"] {
        let fit = named(name).fitted(None).expect("a shape");
        assert!((fit.shape.mean_radius_m() - named(name).usual_radius_m()).abs() < 1e-12, "{name}");
    }
    let scaled = named("stadium:60x40").fitted(Some(0.02)).expect("a stadium").shape;
    assert!((scaled.mean_radius_m() - 0.02).abs() < 1e-12);
    assert_eq!(named("egg").fitted(None).expect("an egg").shape, NamedShape::Egg.shape(0.03).expect("the same"));
    assert_eq!(named("rectangle:60x40x21").fitted(None), Err(ShapeError::CornerRadius));
    assert!(named("stadium:0x40").fitted(None).is_err() && named("stadium:6x4").fitted(Some(f64::NAN)).is_err());
    for name in ["rectangle", "rectangle:60", "rectangle:axb", "stadium:60x40x5", "circle:3", "rectangle:1x2x3x4"] {
        assert!(name.parse::<NamedShape>().is_err(), "{name}");
    }
}

#[test]
fn a_miswritten_shape_is_answered_with_how_it_is_written() {
    let answer = |name: &str| name.parse::<NamedShape>().expect_err("no shape").to_string();
    for name in ["rectangle", "rectangle:60", "rectangle:60,40", "rect:60x40"] {
        assert!(answer(name).contains("written rectangle:60x40,"), "{}", answer(name));
    }
    assert!(answer("stadium:60").contains("written stadium:60x40") && answer("random").contains("written random:7"));
    assert!(answer("banana").contains("known are circle"), "{}", answer("banana"));
}
