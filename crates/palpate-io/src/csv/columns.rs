//! The columns of boundary and motion, in the one order that files and pickled results have.

use palpate::reconstruct::{OutlinePoint, Pose};

use crate::csv::table::Quantity;
use crate::csv::unit::Dimension;

pub(crate) const SHAPE_HEADER: &str = "theta_rad,r_m,r_sd_m,x_m,y_m,curvature_radius_m,touches";
pub(crate) const SHAPE_QUANTITIES: [Quantity; 7] = [
    Quantity::new("theta", Dimension::Angle),
    Quantity::new("r", Dimension::Length),
    Quantity::new("r_sd", Dimension::Length),
    Quantity::new("x", Dimension::Length),
    Quantity::new("y", Dimension::Length),
    Quantity::new("curvature_radius", Dimension::Length),
    Quantity::count("touches"),
];

pub(crate) const MOTION_HEADER: &str =
    "time_s,psi_rad,psi_sd_rad,com_x_m,com_y_m,com_sd_m,theta1_rad,theta2_rad,piece,mode1,mode2";
pub(crate) const MOTION_QUANTITIES: [Quantity; 9] = [
    Quantity::new("time", Dimension::Time),
    Quantity::new("psi", Dimension::Angle),
    Quantity::new("psi_sd", Dimension::Angle),
    Quantity::new("com_x", Dimension::Length),
    Quantity::new("com_y", Dimension::Length),
    Quantity::new("com_sd", Dimension::Length),
    Quantity::new("theta1", Dimension::Angle),
    Quantity::new("theta2", Dimension::Angle),
    Quantity::count("piece"),
];

/// The columns of the contact modes: `stick`, `slide+` or `slide-`, empty where friction does not say. Older folders have none.
pub(crate) const MODE_QUANTITIES: [Quantity; 2] = [Quantity::count("mode1"), Quantity::count("mode2")];

/// A point of the boundary as a row of `shape.csv`.
pub fn point_row(point: &OutlinePoint) -> [f64; 7] {
    let OutlinePoint { theta_rad, r_m, r_sd_m, x_m, y_m, curvature_radius_m, touches } = *point;
    [theta_rad, r_m, r_sd_m, x_m, y_m, curvature_radius_m, f64::from(touches)]
}

/// The point of the boundary of such a row.
pub fn point_of([theta_rad, r_m, r_sd_m, x_m, y_m, curvature_radius_m, touches]: [f64; 7]) -> OutlinePoint {
    OutlinePoint { theta_rad, r_m, r_sd_m, x_m, y_m, curvature_radius_m, touches: touches as u32 }
}

/// The numbers of a pose in a row of `motion.csv`, which has no residuals.
pub fn pose_row(pose: &Pose) -> [f64; 9] {
    let Pose { time_s, psi_rad, psi_sd_rad, com_x_m, com_y_m, com_sd_m, theta1_rad, theta2_rad, piece, .. } = *pose;
    [time_s, psi_rad, psi_sd_rad, com_x_m, com_y_m, com_sd_m, theta1_rad, theta2_rad, f64::from(piece)]
}

/// The pose of such numbers, without residuals or contact modes.
pub fn pose_of(row: [f64; 9]) -> Pose {
    let [time_s, psi_rad, psi_sd_rad, com_x_m, com_y_m, com_sd_m, theta1_rad, theta2_rad, piece] = row;
    Pose {
        time_s,
        psi_rad,
        psi_sd_rad,
        com_x_m,
        com_y_m,
        com_sd_m,
        theta1_rad,
        theta2_rad,
        piece: piece as u32,
        residual1_m: None,
        residual2_m: None,
        modes: None,
    }
}
