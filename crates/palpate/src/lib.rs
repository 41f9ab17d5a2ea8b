//! Shape, motion and centre of mass of an object that is only felt.
//!
//! Two palms meet in a hinge (or stand apart, as two fingers) and hold a smooth convex object in the plane between them,
//! without grasping it: gravity keeps it there. Each palm feels one thing, how far from its base the object touches it. The palms
//! turn slowly, the object rolls and slides along, and from the two palm angles and the two contact positions over time this crate
//! finds what the object looks like, how it moved and where its centre of mass is. The problem is that of
//! Moll & Erdmann, *Reconstructing Shape from Motion Using Tactile Sensors* (IROS 2001).
//!
//! # In seven lines
//!
//! ```
//! # use palpate::{plan::{PalmLimits, plan_turn}, shape::NamedShape, simulate::{SimulateOptions, simulate}};
//! let egg = NamedShape::Egg.shape(0.030)?; // 30 mm mean radius; the robot does not know
//! let plan = plan_turn(&egg, &PalmLimits::default(), 40.0)?; // carries it round in 40 s
//! let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..Default::default() };
//! let felt = simulate(&egg, &plan.motion.sample(10.0)?, &options)?;
//! let found = palpate::reconstruct(&felt.log)?; // from what was felt alone
//! let perimeter_mm = 1e3 * found.shape.perimeter_m();
//! println!("{perimeter_mm:.1} mm around, certified: {}", found.is_certified());
//! # assert!(found.is_certified() && (found.shape.perimeter_m() - egg.perimeter_m()).abs() < 1e-5, "{}", found.verdict);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! prints `188.5 mm around, certified: true`. (The names are from [`plan`], [`shape`] and [`mod@simulate`].)
//!
//! *Certified* promises that the result is consistent with the noise of the log, unique and convex: of the about 1300
//! certified results of `docs/monte-carlo.md` (848 logs without jumps, 500 with) none is wrong; of 2000 further logs three were certified
//! wrongly when they were first tried.
//!
//! # Where to go
//!
//! | I have … | go to |
//! |---|---|
//! | a log: two palm angles and two contact positions over time | [`Log`], [`reconstruct()`] |
//! | a log, and the noise, the shape or the motion is known | [`Reconstructor`], [`reconstruct::Start`] |
//! | a result, and must decide what it is worth | [`Reconstruction`], [`reconstruct::Verdict`] |
//! | a result and the truth | [`compare()`](compare::compare), [`Truth`] |
//! | no log yet | [`simulate()`](simulate::simulate) with [`shape`]s and [`palms`] that move |
//! | a sensor that the simulation does not know | [`sensor::ContactSensor`], [`simulate::simulate_with`] |
//! | an object that I know, and want to feel all of it | [`plan`] |
//! | motions to choose from, or an estimator of my own to judge | [`information`] |
//! | a known object between palms: where does it rest, when does it jump? | [`mechanics`] |
//! | one pad, over which an arm drags an object that swings about a pivot | [`pivot`] |
//! | the figures of Moll & Erdmann (2001) | [`reconstruct::PaperEquations`], [`reconstruct::Method::Ode`] |
//! | questions about how and why | [`theory`] |
//!
//! [`Log`], [`Truth`] and [`Reconstruction`] are plain data. Nothing here touches files or devices (that is
//! `palpate-io`'s part) or prints. The folder `examples` has programs that begin with a log, a start, a sensor and a study of one's own.
//!
//! # The picture
//!
#![doc = include_str!("../docs/palms.svg")]
//!
//! | symbol | meaning | in a [`Log`] or a result |
//! |---|---|---|
//! | φ₁ | angle of palm 1 against the horizontal | `phi1_rad` |
//! | φ₂ | angle from palm 1 to palm 2 | `phi2_rad` |
//! | s₁, s₂ | from the base (hinge) to the contact, along each palm | `s1_m`, `s2_m` |
//! | ψ | orientation of the object | `psi_rad` |
//! | c | centre of mass, the origin of the object's own frame | `com_x_m`, `com_y_m` |
//!
//! The object is described by its *support function* r(θ): the distance from the centre of mass to the tangent whose outward
//! normal points along θ. Its slope −r' = d says where along that tangent the object touches, and v = r + r'' is the radius
//! of curvature, nowhere negative as the object is convex. Palm 1 touches at θ₁ = φ₁ − ψ − π/2 and palm 2 at θ₂ = θ₁ + φ₂ − π.
//!
//! # Conventions
//!
//! SI units and radians throughout, right-handed axes, gravity along −Y (ROS REP 103). A name carries its unit: `s1_m`,
//! `psi_rad`. Everything is deterministic: on one kind of processor and one platform the same input and seed give the same bits, whatever
//! the number of threads; elsewhere they agree to rounding.
//!
//! # Limits
//!
//! These are the limits of two palms; those of the other rig are in [`pivot`]. The object is convex, smooth and rigid, and lies in the plane; it touches each palm in one point, without friction, and is at rest at
//! all times or moves as its inertia has it. Light friction costs the certificate of the centre of mass first
//! ([`Reconstruction::is_com_certified`]). What cannot be certified is said to be so, with the reason.
#![forbid(unsafe_code)]

pub mod calibrate;
pub mod compare;
mod estimate;
pub mod information;
pub mod live;
pub mod log;
mod math;
pub mod mechanics;
#[cfg(feature = "serde")]
pub mod number_or_null;
pub mod palms;
pub mod pivot;
pub mod plan;
pub mod reconstruct;
pub mod sensor;
pub mod shape;
pub mod simulate;
pub mod truth;

#[cfg(doc)]
#[doc = include_str!("../docs/theory.md")]
pub mod theory {}

pub use log::{Log, Sample};
/// Random numbers, in the version from which a [`ContactSensor`](sensor::ContactSensor) of one's own draws.
pub use rand;
pub use reconstruct::{Reconstruction, Reconstructor, reconstruct};
pub use truth::Truth;

/// The README's code, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
