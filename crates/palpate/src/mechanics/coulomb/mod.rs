//! Slow palms with Coulomb friction (`docs/theory.md`, friction): forces within the friction cones and the balance that they keep
//! ([`cone`]), the slip of the contacts and the rates of ψ at which one of them sticks ([`slip`]), and the motion through its contact
//! modes, event by event ([`motion`]).
//!
//! Sources: Coulomb's law; the rigid quasistatic problem as in Mason, *Mechanics of Robotic Manipulation*, 2001, chapters 6 and 7.

mod cone;
mod mode;
mod motion;
mod slip;

pub(crate) use cone::{
    Ratios, at_the_edges, balancing_ratio, moment, moment_by_psi, moment_by_ratio, moment_row, normal_forces,
    normal_forces_by_ratio, opening,
};
pub use mode::ContactMode;
pub(crate) use motion::FrictionPursuit;
pub(crate) use slip::slip_signs;
