//! The residuals of a log with friction (see [`problem`](super::problem)) as linear equations in the steps of all unknowns: a band for the motion, in
//! which each sample meets the next, and a corner for shape, friction, weight and rig.

use super::problem::{FRICTION, NEIGHBOURS, Problem, RIG, Residuals, Unknowns, WEIGHT, of_samples};
use crate::estimate::measurements::Instant;
use crate::estimate::model::boundary::Boundary;
use crate::estimate::solver::arrow::{Arrow, ArrowBuilder};
use crate::mechanics::coulomb::{at_the_edges, moment_by_psi, moment_by_ratio, moment_row};

/// A place, and the residuals there.
pub(crate) struct Linearisation<'a> {
    pub problem: &'a Problem<'a>,
    pub at: &'a Unknowns,
    pub instants: &'a [Instant],
    /// The boundary at the contacts of all samples.
    pub boundaries: &'a [Boundary],
    pub here: &'a Residuals,
    /// Derivatives of all residuals by the constants of the rig, in units of their priors; none for those that are exact.
    pub by_constants: Vec<Option<Residuals>>,
}

/// Normal equations of each kind at standard deviations of a metre and a newton.
pub(crate) struct Linearised {
    pub contacts: Arrow<NEIGHBOURS>,
    pub rolls: Arrow<NEIGHBOURS>,
    pub forces: Arrow<NEIGHBOURS>,
    pub pads: Arrow<NEIGHBOURS>,
}

type Builder = ArrowBuilder<NEIGHBOURS>;

impl Linearisation<'_> {
    /// The normal equations of each kind.
    pub fn of_each_kind(&self) -> Linearised {
        let of = |add: &dyn Fn(&mut Builder)| {
            let mut builder = self.builder();
            add(&mut builder);
            builder.finish()
        };
        Linearised {
            contacts: of(&|builder| self.add_contacts(builder)),
            rolls: of(&|builder| self.add_rolls(builder)),
            forces: of(&|builder| self.add_forces(builder)),
            pads: of(&|builder| self.add_pads(builder)),
        }
    }

    /// Those of all, each kind (contacts, slip, forces, measured forces) with the inverse of its standard deviation as its weight.
    pub fn of_all(&self, [contacts, rolls, forces, pads]: [f64; 4]) -> Arrow<NEIGHBOURS> {
        let mut builder = self.builder();
        builder.weigh(contacts);
        self.add_contacts(&mut builder);
        builder.weigh(rolls);
        self.add_rolls(&mut builder);
        builder.weigh(forces);
        self.add_forces(&mut builder);
        builder.weigh(pads);
        self.add_pads(&mut builder);
        builder.finish()
    }

    fn builder(&self) -> Builder {
        Builder::new(self.problem.dense(), self.instants.len())
    }

    /// Of shape, friction, weight and rig: nothing so far.
    fn nothing(&self) -> (Vec<f64>, usize) {
        (vec![0.0; self.problem.dense()], self.at.coefficients.len())
    }

    fn set_constants(&self, row: &mut [f64], slope: impl Fn(&Residuals) -> f64) {
        let shape = self.at.coefficients.len();
        for (c, slopes) in self.by_constants.iter().enumerate() {
            row[shape + RIG + c] = slopes.as_ref().map_or(0.0, &slope);
        }
    }

    fn add_contacts(&self, builder: &mut Builder) {
        let (mut dense, shape) = self.nothing();
        for (index, (instant, boundary)) in self.instants.iter().zip(self.boundaries).enumerate() {
            let (r_by_psi, d_by_psi) = boundary.at.by_psi();
            let by_psi = instant.palms.positions(r_by_psi, d_by_psi);
            for (palm, weight) in [instant.weight1, instant.weight2].into_iter().enumerate() {
                if weight == 0.0 {
                    continue;
                }
                let mut share = [0.0; 2];
                share[palm] = weight;
                boundary.row_of(&instant.palms.positions_row(share), &mut dense[..shape]);
                self.set_constants(&mut dense, |slopes| slopes.contacts_m[index][palm]);
                let motion = of_samples(self.instants.len(), [(index, weight * by_psi[palm])]);
                builder.add(self.here.contacts_m[index][palm], &dense, motion);
            }
        }
    }

    fn add_rolls(&self, builder: &mut Builder) {
        let (mut dense, shape) = self.nothing();
        let mut row = vec![0.0; shape];
        for (place, (&(from, palm), weight)) in self.problem.rolls.iter().zip(&self.problem.roll_weights).enumerate() {
            dense.fill(0.0);
            let mut by_psi = [0.0; 2];
            for (end, sign) in [(0, -weight), (1, *weight)] {
                let index = from + end;
                let (instant, boundary) = (&self.instants[index], &self.boundaries[index]);
                let along = if palm == 0 { sign } else { -sign };
                let mut share = [0.0; 2];
                share[palm] = along;
                boundary.row_of(&instant.palms.positions_row(share), &mut row);
                let theta: [f64; 2] = instant.contact_angles(self.at.psi[index]).into();
                boundary.add_arc_row(theta[palm], palm, -sign, &mut row);
                dense[..shape].iter_mut().zip(&row).for_each(|(sum, by)| *sum += by);
                let (r_by_psi, d_by_psi) = boundary.at.by_psi();
                let position = instant.palms.positions(r_by_psi, d_by_psi)[palm];
                by_psi[end] = along * position + sign * boundary.at.v[palm];
            }
            self.set_constants(&mut dense, |slopes| slopes.rolls_m[place]);
            let motion = of_samples(self.instants.len(), [(from, by_psi[0]), (from + 1, by_psi[1])]);
            builder.add(self.here.rolls_m[place], &dense, motion);
        }
    }

    fn add_forces(&self, builder: &mut Builder) {
        let (mut dense, shape) = self.nothing();
        for (place, &(index, signs, value)) in self.here.forces_m.iter().enumerate() {
            let (palms, boundary) = (&self.instants[index].palms, &self.boundaries[index]);
            let weight = self.problem.force_weights[index];
            let tau = at_the_edges(self.at.friction, signs);
            boundary.row_of(&moment_row(palms, tau), &mut dense[..shape]);
            dense[..shape].iter_mut().for_each(|by| *by *= weight);
            for palm in 0..2 {
                let by_ratio = moment_by_ratio(palms, &boundary.at, tau, palm);
                dense[shape + FRICTION + palm] = -weight * signs[palm] * by_ratio;
            }
            self.set_constants(&mut dense, |slopes| slopes.forces_m[place].2);
            let by_psi = weight * moment_by_psi(palms, &boundary.at, tau);
            builder.add(value, &dense, of_samples(self.instants.len(), [(index, by_psi)]));
        }
    }

    fn add_pads(&self, builder: &mut Builder) {
        let (mut dense, shape) = self.nothing();
        for (place, &(index, palm, value)) in self.here.pads_n.iter().enumerate() {
            let (instant, boundary) = (&self.instants[index], &self.boundaries[index]);
            let Some(forces) = self.problem.normal_forces(self.at, instant, index, boundary) else { continue };
            let by = forces.by_unknowns(&instant.palms, &boundary.at, palm);
            let weight_n = -self.problem.pad_weights[index][palm] * self.at.weight_n;
            boundary.row_of(&by.contacts, &mut dense[..shape]);
            dense[..shape].iter_mut().for_each(|by| *by *= weight_n);
            for k in 0..2 {
                dense[shape + FRICTION + k] = weight_n * by.friction[k];
            }
            dense[shape + WEIGHT] = weight_n * forces.over_weight[palm];
            self.set_constants(&mut dense, |slopes| slopes.pads_n[place].2);
            builder.add(value, &dense, of_samples(self.instants.len(), [(index, weight_n * by.psi)]));
        }
    }
}
