//! A camera that tracks markers on palms and object, to have a ground truth in an experiment (section 5 of Moll & Erdmann 2001,
//! where an Adept vision system follows white arrows). Nobody knows where the camera hangs: rigid-body fits of the markers on
//! the palms, whose angles the robot knows, tell; then a rigid-body fit of the markers on the object gives its pose.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::math::procrustes::{RigidMotion, procrustes};
use crate::palms::{Palm, PalmPair};
use crate::truth::TruePose;

/// A simulated camera and its markers.
#[derive(Clone, Debug, PartialEq)]
pub struct VisionSystem {
    /// Standard deviation of each coordinate of a marker as seen, metres.
    pub noise_sd_m: f64,
    /// Markers on the object, in its own frame (origin at the centre of mass), metres. At least two.
    pub object_markers_m: Vec<[f64; 2]>,
    /// Markers on each palm, metres from its base. At least one.
    pub palm_markers_m: Vec<f64>,
    /// Where the camera hangs: carries the global frame into that of the picture.
    pub camera: RigidMotion,
}

impl VisionSystem {
    /// The poses as the camera sees them, for the palms and the true poses at the same instants. ψ is unwrapped. An instant at
    /// which nothing can be fitted has the pose NaN.
    pub fn track(&self, palms: &[PalmPair], poses: &[TruePose], seed: u64) -> Vec<TruePose> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut seen = |point: [f64; 2]| {
            let [x, y] = self.camera.apply(point);
            let mut noise = || self.noise_sd_m * rng.sample::<f64, _>(StandardNormal);
            [x + noise(), y + noise()]
        };
        let on_palms: Vec<[f64; 2]> = palms.iter().flat_map(|palms| self.on_palms(palms)).collect();
        let palms_seen: Vec<[f64; 2]> = on_palms.iter().map(|point| seen(*point)).collect();
        let camera = procrustes(&on_palms, &palms_seen);
        let mut last_psi = poses.first().map_or(0.0, |pose| pose.psi_rad);
        poses
            .iter()
            .map(|pose| {
                let real = RigidMotion { angle_rad: pose.psi_rad, offset_m: [pose.com_x_m, pose.com_y_m] };
                let object_seen: Vec<[f64; 2]> =
                    self.object_markers_m.iter().map(|marker| seen(real.apply(*marker))).collect();
                let found = camera.and_then(|camera| {
                    let in_global: Vec<[f64; 2]> = object_seen.iter().map(|point| camera.undo(*point)).collect();
                    procrustes(&self.object_markers_m, &in_global)
                });
                let Some(RigidMotion { angle_rad, offset_m }) = found else {
                    return TruePose { psi_rad: f64::NAN, com_x_m: f64::NAN, com_y_m: f64::NAN, ..*pose };
                };
                let turns = ((angle_rad - last_psi) / std::f64::consts::TAU).round();
                last_psi = angle_rad - turns * std::f64::consts::TAU;
                TruePose { psi_rad: last_psi, com_x_m: offset_m[0], com_y_m: offset_m[1], ..*pose }
            })
            .collect()
    }

    /// The markers on both palms in the global frame, metres.
    pub fn on_palms(&self, palms: &PalmPair) -> Vec<[f64; 2]> {
        let (t1, t2) = (palms.tangent(Palm::One), palms.tangent(Palm::Two));
        let one = self.palm_markers_m.iter().map(|s| [palms.base1_m[0] + s * t1[0], palms.base1_m[1] + s * t1[1]]);
        let two = self.palm_markers_m.iter().map(|s| [palms.base2_m[0] - s * t2[0], palms.base2_m[1] - s * t2[1]]);
        one.chain(two).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vision(noise_sd_m: f64) -> VisionSystem {
        VisionSystem {
            noise_sd_m,
            object_markers_m: vec![[0.01, 0.0], [-0.008, 0.006], [0.0, -0.01]],
            palm_markers_m: vec![0.02, 0.05],
            camera: RigidMotion { angle_rad: 0.3, offset_m: [0.4, -0.1] },
        }
    }

    fn scene() -> (Vec<PalmPair>, Vec<TruePose>) {
        let instants = (0..200).map(|i| 0.02 * f64::from(i));
        instants
            .map(|t| {
                let pose = TruePose { time_s: t, psi_rad: 4.0 + 2.0 * t, com_x_m: 0.01 * t, com_y_m: 0.03 };
                (PalmPair::hinged(0.6 + 0.05 * t, 1.5), pose)
            })
            .unzip()
    }

    #[test]
    fn without_noise_the_poses_are_seen_exactly() {
        let (palms, poses) = scene();
        for (found, real) in vision(0.0).track(&palms, &poses, 1).iter().zip(&poses) {
            assert!((found.psi_rad - real.psi_rad).abs() < 1e-12);
            assert!((found.com_x_m - real.com_x_m).hypot(found.com_y_m - real.com_y_m) < 1e-14);
        }
    }

    #[test]
    fn noise_of_the_markers_averages_out_over_them() {
        let (palms, poses) = scene();
        let found = vision(1e-4).track(&palms, &poses, 1);
        let square = |error: &dyn Fn(usize) -> f64| (0..200).map(|i| error(i).powi(2)).sum::<f64>() / 200.0;
        let position = square(&|i| found[i].com_x_m - poses[i].com_x_m).sqrt();
        assert!((0.3e-4..1.0e-4).contains(&position), "{position}");
        let turn = square(&|i| found[i].psi_rad - poses[i].psi_rad).sqrt();
        assert!((1e-3..1e-2).contains(&turn), "{turn}");
    }

    #[test]
    fn without_markers_there_is_no_pose() {
        let (palms, poses) = scene();
        let blind = VisionSystem { object_markers_m: Vec::new(), ..vision(0.0) };
        assert!(blind.track(&palms, &poses, 1).iter().all(|pose| pose.psi_rad.is_nan()));
    }
}
