//! Shape, motion and centre of mass of an object that is only felt.
//!
//! Two palms meet in a hinge (or stand apart, as two fingers) and hold a smooth convex object in the plane between them,
//! without grasping it: gravity keeps it there. Each palm feels one thing, how far from its base the object touches it. The palms
//! turn slowly, the object rolls and slides along, and from the two palm angles and the two contact positions over time this crate
//! finds what the object looks like, how it moved and where its centre of mass is. The problem is that of
//! Moll & Erdmann, *Reconstructing Shape from Motion Using Tactile Sensors* (IROS 2001).
//!
//! # The picture
//!
//! ```text
//!              palm 2                 φ1   palm 1 against the horizontal
//!                \   ____             φ2   from palm 1 to palm 2
//!              s2 \ /    \            s1   hinge to contact, along palm 1
//!                  X  *c  |           s2   hinge to contact, along palm 2
//!                   \    /  .         ψ    orientation of the object
//!                    \__X.  palm 1    c    centre of mass, the origin of the object's own frame
//!                     \. s1
//!               hinge  O  φ1
//! ```
//!
//! The object is described by its *support function* r(θ): the distance from the centre of mass to the tangent whose outward
//! normal points along θ. Its slope −r' = d says where along that tangent the object touches, and v = r + r'' is the radius
//! of curvature, nowhere negative as the object is convex. Palm 1 touches at θ₁ = φ₁ − ψ − π/2 and palm 2 at θ₂ = θ₁ + φ₂ − π.
//!
//! # The chain
//!
//! Data flow one way:
//!
//! ```text
//! shape + palm motion ──simulate──▶ Log ──reconstruct──▶ Reconstruction ──compare──▶ errors against the Truth
//! ```
//!
//! * [`shape`]: support functions, of named objects, random ones, polygons and sampled outlines
//! * [`palms`]: the palm pair, its frames and contact angles, what two contacts say together, palm motions
//! * [`mechanics`]: potential energy, balance, where an object rests and where it jumps to
//! * [`sensor`]: touchpads and their faults
//! * [`mod@simulate`]: the exact quasistatic forward model
//! * [`plan`]: palm motions for a known object, without jumps
//! * [`mod@reconstruct`]: the estimator
//! * [`mod@compare`]: error figures
//!
//! [`Log`], [`Truth`] and [`Reconstruction`] are plain data. Nothing here touches files or devices (that is
//! `palpate-io`'s part) or prints.
//!
//! # An example
//!
//! ```
//! use palpate::palms::PalmPair;
//! use palpate::plan::{PalmLimits, plan_turn};
//! use palpate::shape::NamedShape;
//! use palpate::simulate::{SimulateOptions, simulate};
//!
//! // What the robot cannot see: an egg of 30 mm mean radius that the palms carry round in 40 s.
//! let egg = NamedShape::Egg.shape(0.030)?;
//! let plan = plan_turn(&egg, &PalmLimits::default(), 40.0)?;
//! let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
//! let motion: Vec<(f64, PalmPair)> = plan.motion.sample(10.0)?;
//! let felt = simulate(&egg, &motion, &options)?;
//!
//! // What it gets back from what it felt.
//! let found = palpate::reconstruct(&felt.log)?;
//! assert!(found.is_certified(), "{}", found.verdict);
//! assert!((found.shape.perimeter_m() - egg.perimeter_m()).abs() < 1e-5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//!
//! SI units and radians throughout, right-handed axes, gravity along −Y (ROS REP 103). A name carries its unit: `s1_m`,
//! `psi_rad`. Everything is deterministic: the same input and seed give the same result, whatever the number of threads.
//!
//! # Limits
//!
//! The object is convex, smooth and rigid, and lies in the plane; it touches each palm in one point, without friction, and the
//! palms are slow enough for it to be at rest at all times. Light friction and moderate speed cost the certificate of the centre
//! of mass first ([`Reconstruction::is_com_certified`]). What cannot be certified is said to be so, with the reason.
#![forbid(unsafe_code)]

pub mod compare;
mod estimate;
pub mod information;
pub mod log;
mod math;
pub mod mechanics;
#[cfg(feature = "serde")]
pub mod number_or_null;
pub mod palms;
pub mod plan;
pub mod reconstruct;
pub mod sensor;
pub mod shape;
pub mod simulate;
pub mod truth;

pub use log::{Log, Sample};
pub use reconstruct::{Reconstruction, Reconstructor, reconstruct};
pub use truth::Truth;

/// The README's code, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
