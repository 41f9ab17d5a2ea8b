//! The seam at which physics enters the estimator: one residual per instant that vanishes where the forces on the object balance.
//!
//! A model is chosen by a type parameter, never by a flag, so that one that reads nothing of the palms' rates costs nothing for them. Its
//! residual is a length: the moment of the forces over the weight. Its derivative by the contacts is linear in (r, d, v) for a
//! given motion, which is all that the elimination of the orientations needs.

use std::fmt::Debug;

use crate::math::lanes::Number;
use crate::mechanics::jump::Jump;
use crate::palms::{ContactRow, Contacts, PalmAngles, PalmPair};
use crate::shape::SupportFunction;

/// Palms, contacts and motion at one instant: all that a model of the forces may read of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionState<N = f64> {
    pub palms: PalmAngles<N>,
    pub contacts: Contacts<N>,
    /// How far each base point lies out on its palm from where the lines of the palms meet, metres: 0 for hinged palms.
    pub base_shifts_m: [N; 2],
    /// Rates of the angles of palm 1 and palm 2 against the horizontal, rad/s.
    pub palm_rates: [N; 2],
    /// Their rates, rad/s².
    pub palm_accelerations: [N; 2],
    /// ψ', rad/s.
    pub psi_rate: N,
    /// ψ'', rad/s².
    pub psi_acceleration: N,
}

impl<N: Number> MotionState<N> {
    /// Nothing moves, or so slowly that it does not matter.
    #[inline(always)]
    pub fn at_rest(palms: PalmAngles<N>, contacts: Contacts<N>) -> Self {
        Self {
            palms,
            contacts,
            base_shifts_m: [N::ZERO; 2],
            palm_rates: [N::ZERO; 2],
            palm_accelerations: [N::ZERO; 2],
            psi_rate: N::ZERO,
            psi_acceleration: N::ZERO,
        }
    }
}

/// The residual of the forces at one instant, metres, and its derivatives by the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ForceResidual<N = f64> {
    pub value: N,
    pub by_psi: N,
    /// By ψ' (s) and ψ'' (s²); zero for a model that looks at no neighbouring instant.
    pub by_psi_rates: [N; 2],
}

/// A number that all instants share: a coefficient of friction, a radius of gyration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SharedParameter {
    /// What it is called, with its unit.
    pub name: &'static str,
    /// What is believed of it beforehand: mean and standard deviation.
    pub prior: (f64, f64),
}

/// A model of the forces on the object.
pub(crate) trait ForceModel: Copy + Debug + Default + Send + Sync + 'static {
    /// Neighbouring instants whose orientation a residual reads besides its own: 0 at rest, 1 where a contact rolls, 2 with inertia.
    /// Only models with 0 can have their orientations eliminated one by one.
    const NEIGHBOURS: usize;

    /// Whether residuals read the radii of curvature at the contacts.
    const READS_CURVATURE: bool;

    /// Numbers that all instants share, in the order of their columns.
    const PARAMETERS: &'static [SharedParameter];

    /// The residual at an instant.
    fn residual<N: Number>(&self, at: &MotionState<N>) -> ForceResidual<N>;

    /// Its derivative by r, d and v at the contacts.
    fn row<N: Number>(&self, at: &MotionState<N>) -> ContactRow<N>;

    /// Its derivatives by the angles of palm 1 and palm 2 against the horizontal, ψ as it is, metres.
    fn by_palms<N: Number>(&self, at: &MotionState<N>) -> [N; 2];

    /// Whether an object at rest with this residual would leave its pose at the slightest disturbance. `slack_m` is forgiven in
    /// the stiffness (metres), and poses further off balance than `balance_m` are on their way: only one at rest can be unstable.
    fn is_unstable(&self, residual: &ForceResidual, slack_m: f64, balance_m: f64) -> bool;

    /// Where the object goes from a pose while the palms move: its orientation at the end (unwrapped, radians) and the jumps on the way.
    fn advance(&self, shape: &SupportFunction, from: &PalmPair, to: &PalmPair, psi_rad: f64) -> (f64, Vec<Jump>);
}
