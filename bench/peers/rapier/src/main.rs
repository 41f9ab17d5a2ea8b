//! An object between two palms in rapier2d: a convex polygon without friction, driven so slowly that it is as good as at rest.
//!
//! Started with the scene that `cargo xtask bench-peers` writes; each line that comes in asks for one run,
//!
//! ```text
//! VERTICES DURATION_S STEP_S DAMPING
//! ```
//!
//! and is answered by the seconds that the steps took, without the making of the world, and ψ at each sample of the scene.
#![forbid(unsafe_code)]

use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::io::{BufRead, Write};
use std::time::Instant;

use rapier2d_f64::prelude::*;
use serde::Deserialize;

/// Mass of the object, kilograms; of no consequence.
const MASS_KG: f64 = 0.1;

/// Acceleration of free fall, metres per second squared.
const GRAVITY_M_PER_S2: f64 = 9.80665;

/// Stiffness of the contacts in periods per step: as stiff as the steps allow.
const PERIODS_PER_STEP: f64 = 0.25;

/// Object and motion of the palms.
#[derive(Deserialize)]
struct Scene {
    mean_radius_m: f64,
    harmonics_m: Vec<[f64; 2]>,
    time_s: Vec<f64>,
    phi1_rad: Vec<f64>,
    phi12_rad: Vec<f64>,
    start_psi_rad: f64,
    start_center_m: [f64; 2],
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: palpate-peer-rapier SCENE.json")?;
    let scene: Scene = serde_json::from_reader(std::fs::File::open(path)?)?;
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let settings: Vec<f64> = line.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        let [vertices, duration_s, step_s, damping] = settings[..] else {
            return Err("VERTICES DURATION_S STEP_S DAMPING".into());
        };
        let (seconds, psi) = run(&scene, vertices as usize, duration_s, step_s, damping)?;
        let words: Vec<String> = std::iter::once(seconds).chain(psi).map(|value| value.to_string()).collect();
        println!("{}", words.join(" "));
        std::io::stdout().flush()?;
    }
    Ok(())
}

/// One run: seconds, and ψ at each sample.
fn run(
    scene: &Scene,
    vertices: usize,
    duration_s: f64,
    step_s: f64,
    damping: f64,
) -> Result<(f64, Vec<f64>), Box<dyn Error>> {
    let (mut bodies, mut colliders) = (RigidBodySet::new(), ColliderSet::new());
    let palm = |bodies: &mut RigidBodySet, colliders: &mut ColliderSet, angle: f64| {
        let body = bodies.insert(RigidBodyBuilder::kinematic_position_based().rotation(angle));
        let half_plane = ColliderBuilder::halfspace(Vector::y_axis()).friction(0.0).restitution(0.0);
        colliders.insert_with_parent(half_plane, body, bodies);
        body
    };
    // The object lies above palm 1 and, seen from the hinge outward, to the right of palm 2.
    let palm1 = palm(&mut bodies, &mut colliders, scene.phi1_rad[0]);
    let palm2 = palm(&mut bodies, &mut colliders, scene.phi12_rad[0] - PI);
    let [x, y] = scene.start_center_m;
    let inertia = 0.5 * MASS_KG * scene.mean_radius_m.powi(2);
    let rate = (GRAVITY_M_PER_S2 / scene.mean_radius_m).sqrt();
    let object = bodies.insert(
        RigidBodyBuilder::dynamic()
            .translation(vector![x, y])
            .rotation(scene.start_psi_rad)
            .angular_damping(damping * rate)
            .additional_mass_properties(MassProperties::new(Point::origin(), MASS_KG, inertia))
            .can_sleep(false),
    );
    let outline: Vec<Point<f64>> =
        (0..vertices).map(|vertex| scene.boundary(TAU * vertex as f64 / vertices as f64)).collect();
    let polygon = ColliderBuilder::convex_polyline(outline).ok_or("the outline is not convex")?;
    colliders.insert_with_parent(polygon.density(0.0).friction(0.0).restitution(0.0), object, &mut bodies);

    let parameters = IntegrationParameters {
        dt: step_s,
        contact_natural_frequency: PERIODS_PER_STEP / step_s,
        // Contacts are to touch, not to sink in.
        normalized_allowed_linear_error: 0.0,
        length_unit: scene.mean_radius_m,
        ..IntegrationParameters::default()
    };
    let gravity = vector![0.0, -GRAVITY_M_PER_S2];
    let (mut pipeline, mut islands) = (PhysicsPipeline::new(), IslandManager::new());
    let (mut broad_phase, mut narrow_phase) = (DefaultBroadPhase::new(), NarrowPhase::new());
    let (mut joints, mut multibody_joints) = (ImpulseJointSet::new(), MultibodyJointSet::new());
    let mut continuous = CCDSolver::new();

    let steps = (duration_s / step_s).round() as usize;
    let whole_s = scene.time_s.last().copied().unwrap_or(0.0);
    let mut psi = Vec::with_capacity(scene.time_s.len());
    let began = Instant::now();
    for step in 0..=steps {
        let time_s = whole_s * step as f64 / steps as f64;
        while psi.len() < scene.time_s.len() && scene.time_s[psi.len()] <= time_s + 0.5 * whole_s / steps as f64 {
            psi.push(bodies[object].rotation().angle());
        }
        let (phi1, phi12) = scene.palms(whole_s * (step + 1) as f64 / steps as f64);
        bodies[palm1].set_next_kinematic_rotation(Rotation::new(phi1));
        bodies[palm2].set_next_kinematic_rotation(Rotation::new(phi12 - PI));
        pipeline.step(
            &gravity,
            &parameters,
            &mut islands,
            &mut broad_phase,
            &mut narrow_phase,
            &mut bodies,
            &mut colliders,
            &mut joints,
            &mut multibody_joints,
            &mut continuous,
            &(),
            &(),
        );
    }
    Ok((began.elapsed().as_secs_f64(), psi))
}

impl Scene {
    /// The boundary point whose outward normal has the angle `theta`.
    fn boundary(&self, theta: f64) -> Point<f64> {
        let (mut r, mut d) = (self.mean_radius_m, 0.0);
        for (index, [a, b]) in self.harmonics_m.iter().enumerate() {
            let k = (index + 1) as f64;
            let (sin, cos) = (k * theta).sin_cos();
            r += a * cos + b * sin;
            d += k * (a * sin - b * cos);
        }
        let (sin, cos) = theta.sin_cos();
        point![r * cos + d * sin, r * sin - d * cos]
    }

    /// φ₁ and φ₁₂ at a time, by cubic Hermite interpolation.
    fn palms(&self, time_s: f64) -> (f64, f64) {
        let last = self.time_s.len() - 1;
        let index = self.time_s.partition_point(|time| *time <= time_s).clamp(1, last) - 1;
        let span = self.time_s[index + 1] - self.time_s[index];
        let u = ((time_s - self.time_s[index]) / span).clamp(0.0, 1.0);
        let hermite = |values: &[f64]| {
            let slope = |at: usize| {
                let (before, after) = (at.saturating_sub(1), (at + 1).min(last));
                (values[after] - values[before]) / (self.time_s[after] - self.time_s[before])
            };
            let (u2, u3) = (u * u, u * u * u);
            (2.0 * u3 - 3.0 * u2 + 1.0) * values[index]
                + (u3 - 2.0 * u2 + u) * span * slope(index)
                + (3.0 * u2 - 2.0 * u3) * values[index + 1]
                + (u3 - u2) * span * slope(index + 1)
        };
        (hermite(&self.phi1_rad), hermite(&self.phi12_rad))
    }
}
