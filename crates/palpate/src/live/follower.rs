//! Follows the object from the optimum of a search: poses of the newest samples, the shape that they sharpen, the boundary that they feel, and whether
//! they still agree with it.

use nalgebra::DMatrix;

use crate::estimate::coverage::{LONGEST_SLIDE, NODES, images, nodes_between};
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::layout::rotate;
use crate::estimate::motion::LONGEST_STEP;
use crate::live::estimate::{Estimate, Stage};
use crate::live::kept::Kept;
use crate::live::optimum::{FITTED_AT_MOST, Optimum};
use crate::live::poses::{Decided, Poses, UNEXPLAINED};
use crate::live::shape_belief::ShapeBelief;
use crate::log::{Log, Sample};
use crate::math::angle::wrapped;
use crate::reconstruct::verdict::assemble::{outline, pose};
use crate::reconstruct::{CertificateLimits, Pose, ReconstructOptions};
use crate::shape::SupportFunction;

/// Samples that sharpen the shape together: a Gauss-Newton step takes as long for eight as for one. Of those that are known, no more than one in so
/// many waits for others: they would move the shape by a thirtieth of its standard deviation, and an error bar by a two thousandth.
const BLOCK: u64 = 8;
const WAITING_SHARE: u64 = 1000;

/// Samples between two looks at the whole outline with its error bars.
pub const OUTLINE_EVERY: u64 = 10;

/// The newest samples contradict the shape when their mean squared distance from it (two are expected, of three readings and an orientation) is
/// larger: over so many samples, each counted up to what counts as unexplained.
const CONTRADICTED: f64 = 8.0;
const EXPECTED: f64 = 2.0;
const MEMORY: f64 = 50.0;

/// The same over so few is doubt about the pose alone: the object may have jumped to boundary where no pose is looked for.
const SHORT_MEMORY: f64 = 5.0;

#[derive(Clone)]
pub(super) struct Follower {
    /// What the last search or fit found, with the orientations that were decided on since, as far as a fit may need them.
    optimum: Optimum,
    /// Samples of the optimum and since.
    known: u64,
    shape: ShapeBelief,
    poses: Poses,
    /// Samples that were decided on and have not sharpened the shape yet.
    block: Vec<(Instant, f64)>,
    /// Touches of each node of the outline, in the object's own frame.
    touches: Vec<u32>,
    /// Contact angles of the newest sample that was decided on, in the frame of the fit, where seen.
    contacts: [Option<f64>; 2],
    /// Covariance of the shape after the best rotation over the felt boundary, of how many samples, and whether more was felt since.
    covariance: DMatrix<f64>,
    covariance_of: u64,
    feels_more: bool,
    /// Mean squared distance of the newest samples, and of the last few.
    strain: f64,
    short_strain: f64,
    before: Option<Sample>,
    psi_before: f64,
    piece: u32,
    /// Whether the pose since the last jump is that of boundary that is known, and whether that of every jump since the last search was. Where the
    /// object lands on boundary that is not, any pose explains it, and only a search can tell.
    is_placed: bool,
    were_placed: bool,
    taken: u64,
    outline_is_due: bool,
    /// Standard deviation of an orientation that is hardly known, radians.
    uncertain_rad: f64,
}

impl Follower {
    /// `None` where the optimum does not determine a shape.
    pub fn new(optimum: Optimum, limits: &CertificateLimits) -> Option<Self> {
        let shape = ShapeBelief::new(optimum.belief.clone(), optimum.noise, optimum.prior)?;
        let touches = optimum.found.outline.iter().map(|point| point.touches).collect();
        let psi = *optimum.motion.last()?;
        let mut follower = Self {
            known: optimum.motion.len() as u64,
            shape,
            poses: Poses::from(psi),
            block: Vec::new(),
            touches,
            contacts: [None; 2],
            covariance: DMatrix::zeros(0, 0),
            covariance_of: 0,
            feels_more: false,
            strain: EXPECTED,
            short_strain: EXPECTED,
            before: None,
            psi_before: psi,
            piece: optimum.piece,
            // A last piece of few samples may be elsewhere than the search found it.
            is_placed: optimum.psi_sd_rad < limits.psi_sd_rad,
            were_placed: true,
            taken: 0,
            outline_is_due: true,
            uncertain_rad: limits.largest_psi_sd_rad,
            optimum,
        };
        follower.look()?;
        Some(follower)
    }

    /// The same with shape, noise and prior fitted anew to all samples that were decided on, as the batch estimator fits them, and not one after
    /// the other; of at most [`FITTED_AT_MOST`] samples. `None` where that determines no shape.
    pub fn refitted(self, kept: &Kept, options: &ReconstructOptions) -> Option<Self> {
        let psi = self.optimum.motion.clone();
        let log = Log { samples: kept.log().samples.get(..psi.len())?.to_vec() };
        let optimum = self.optimum.refitted(&log, options, self.shape.coefficients().to_vec(), psi)?;
        let shape = ShapeBelief::new(optimum.belief.clone(), optimum.noise, optimum.prior)?;
        let mut follower = Self { optimum, shape, block: Vec::new(), ..self };
        follower.look()?;
        Some(follower)
    }

    /// Takes the next sample in, as the rig wrote it.
    pub fn push(&mut self, sample: &Sample) -> (Sample, Instant) {
        let (corrected, instant) = self.instant(sample);
        for Decided { instant, psi } in self.poses.push(instant, &self.shape) {
            self.decided(instant, psi);
        }
        self.taken += 1;
        if self.taken.is_multiple_of(OUTLINE_EVERY) {
            self.outline_is_due = true;
            if self.feels_more || self.known - self.covariance_of > self.known / WAITING_SHARE {
                // What is undetermined stays as it was.
                let _ = self.look();
            }
        }
        (corrected, instant)
    }

    /// A sample corrected by the constants of the rig, and ready for estimation.
    fn instant(&mut self, sample: &Sample) -> (Sample, Instant) {
        let samples = self.before.replace(*sample).into_iter().chain([*sample]).collect();
        let log = self.optimum.calibration.corrected(&Log { samples });
        let newest = log.samples.last().copied().unwrap_or(*sample);
        let measured = Measurements::new(&Log { samples: vec![newest] }, self.optimum.stated_m);
        let mut instant = measured.instants[0];
        instant.weight1 *= self.optimum.weights[0];
        instant.weight2 *= self.optimum.weights[1];
        instant.balance_weight = if self.optimum.balance_counts { 1.0 } else { 0.0 };
        (newest, instant)
    }

    fn decided(&mut self, instant: Instant, psi: f64) {
        self.known += 1;
        if self.optimum.motion.len() < FITTED_AT_MOST {
            self.optimum.motion.push(psi);
        }
        let misfit = self.shape.settled(&instant, psi).misfit;
        // No number is no explanation.
        let is_explained = misfit < UNEXPLAINED;
        let counted = if is_explained { misfit } else { UNEXPLAINED };
        // Without a contact a sample agrees with any shape.
        if instant.weight1 > 0.0 || instant.weight2 > 0.0 {
            self.strain += (counted - self.strain) / MEMORY;
            self.short_strain += (counted - self.short_strain) / SHORT_MEMORY;
        }
        if wrapped(psi - self.psi_before).abs() > LONGEST_STEP {
            self.piece += 1;
            self.were_placed &= self.is_placed;
            self.is_placed = false;
        }
        self.psi_before = psi;
        if !self.is_placed && is_explained && self.shape.knows(&instant, psi) {
            self.is_placed = true;
        }
        if !is_explained || !self.is_placed {
            return;
        }
        self.feel(&instant, psi);
        self.block.push((instant, psi));
        if self.block.len() as u64 >= (self.known / WAITING_SHARE).clamp(1, BLOCK) {
            self.shape.fold(std::mem::take(&mut self.block));
        }
    }

    /// Marks the boundary that the contacts passed over.
    fn feel(&mut self, instant: &Instant, psi: f64) {
        let (theta1, theta2) = instant.contact_angles(psi);
        for (contact, (theta, weight)) in [(theta1, instant.weight1), (theta2, instant.weight2)].into_iter().enumerate()
        {
            let theta = theta + self.optimum.turned;
            let now = (weight > 0.0 && theta.is_finite()).then_some(theta);
            let from = self.contacts[contact].filter(|from| (theta - from).abs() < LONGEST_SLIDE);
            self.contacts[contact] = now;
            let Some(to) = now else { continue };
            let from = from.unwrap_or(to);
            let symmetry = self.optimum.found.symmetry.symmetry;
            for node in nodes_between(from.min(to), from.max(to), NODES) {
                for image in images(node, NODES, symmetry, self.optimum.turned) {
                    if let Some(touches @ 0) = self.touches.get_mut(image) {
                        *touches = 1;
                        self.feels_more = true;
                    }
                }
            }
        }
    }

    /// The covariance of the shape over the boundary felt so far.
    fn look(&mut self) -> Option<()> {
        let felt: Vec<f64> = (0..self.touches.len())
            .filter(|&node| self.touches[node] > 0)
            .map(|node| std::f64::consts::TAU * node as f64 / NODES as f64 - self.optimum.turned)
            .collect();
        self.covariance = self.shape.posterior().covariance_over(&felt)?;
        (self.covariance_of, self.feels_more) = (self.known, false);
        self.outline_is_due = true;
        Some(())
    }

    /// Writes what is known behind the newest sample.
    pub fn tell(&mut self, (sample, instant): &(Sample, Instant), estimate: &mut Estimate) {
        let mut coefficients = self.shape.coefficients().to_vec();
        let best = self.poses.best();
        let in_fit = SupportFunction::from_coefficients(&coefficients);
        let there = pose(sample, instant, &in_fit, &coefficients, best.psi);
        let (psi_sd, com_sd) = self.shape.pose_sd(instant, best.psi, &self.covariance);
        let scale = self.optimum.inflation.sqrt();
        let turned = self.optimum.turned;
        let psi_sd_rad = (scale * psi_sd).max(self.poses.ambiguity_rad());
        estimate.ambiguous =
            !self.all_are_placed() || psi_sd_rad > self.uncertain_rad || self.short_strain > CONTRADICTED;
        estimate.pose = Some(Pose {
            psi_rad: best.psi - turned,
            psi_sd_rad,
            com_sd_m: scale * com_sd,
            theta1_rad: there.theta1_rad + turned,
            theta2_rad: there.theta2_rad + turned,
            piece: self.piece,
            ..there
        });
        rotate(&mut coefficients, turned);
        let shape = SupportFunction::from_coefficients(&coefficients);
        if std::mem::take(&mut self.outline_is_due) || estimate.outline.is_empty() {
            let layout = self.shape.posterior().layout;
            let r_sd_m = |theta: f64| {
                let row = layout.support_row(theta - turned);
                scale * (&self.covariance * &row).dot(&row).max(0.0).sqrt()
            };
            estimate.outline = outline(&shape, &self.touches, r_sd_m);
            let felt = self.touches.iter().filter(|touches| **touches > 0).count();
            estimate.coverage = felt as f64 / NODES as f64;
        }
        estimate.shape = Some(shape);
        estimate.stage = Stage::Following;
        estimate.hypotheses = self.poses.count();
        estimate.contradicted = self.strain > CONTRADICTED;
    }

    /// Whether the pose of every sample since the last search is that of boundary that is known.
    pub fn all_are_placed(&self) -> bool {
        self.is_placed && self.were_placed
    }

    /// What was found by the search behind it, as last fitted.
    pub fn optimum(&self) -> &Optimum {
        &self.optimum
    }
}
