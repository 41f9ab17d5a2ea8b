//! The text of a rig file.

use crate::csv::number::number;
use crate::rig::RigFile;
use crate::rig::conventions::Direction;
use crate::rig::key::{
    ANGLE_READING_SD, ANGLE_ZERO, ANGLE_ZERO_SD, BASE, CLOCK, CLOCK_SD, COUNTS_PER_INCH, DIFFERENCE_SD, DIRECTION,
    FRICTION, FRICTION_SD, Key, LENGTH, LEVELS, RATIO_SD, READING_SD, SCALE, SCALE_SD, SIGN, SURFACE, SURFACE_SD, ZERO,
    ZERO_SD,
};

/// The rig as a rig file that [`parse_rig`](crate::parse_rig) reads back the same, to the last bit: in SI units, every constant with its
/// standard deviation, the rest where it is known. (A standard deviation of an unknown friction is left out.)
pub fn rig_to_toml(rig: &RigFile) -> String {
    let RigFile { rig, conventions, pads, angle_reading_sd_rad } = rig;
    let (calibration, tolerances) = (&rig.calibration, &rig.tolerances);
    let mut text = String::from("# Rig file of palpate. Units are in the names; sd = standard deviation, 0 = exact.\n");
    for (k, (palm, pad)) in conventions.palms.iter().zip(pads).enumerate() {
        text += &format!("\n[palm{}]\n", k + 1);
        push(&mut text, ZERO, Some(calibration.zero_m[k]));
        push(&mut text, ZERO_SD, Some(tolerances.zero_sd_m[k]));
        push(&mut text, SCALE, Some(calibration.scale[k]));
        push(&mut text, SCALE_SD, Some(tolerances.scale_sd[k]));
        push(&mut text, SURFACE, Some(calibration.surface_m[k]));
        push(&mut text, SURFACE_SD, Some(tolerances.surface_sd_m[k]));
        let direction = match palm.direction {
            Direction::FromBase { .. } => "from_base",
            Direction::ToBase { .. } => "to_base",
        };
        text += &format!("{} = \"{direction}\"\n", DIRECTION.si_name());
        push(&mut text, LENGTH, palm.direction.length_m());
        push(&mut text, READING_SD, pad.reading_sd_m);
        push(&mut text, COUNTS_PER_INCH, pad.counts_per_inch);
        push(&mut text, LEVELS, pad.levels.map(f64::from));
        push(&mut text, FRICTION, pad.friction);
        push(&mut text, FRICTION_SD, pad.friction.and(pad.friction_sd));
        push(&mut text, BASE[0], palm.base_m[0]);
        push(&mut text, BASE[1], palm.base_m[1]);
    }
    if tolerances.scale_ratio_sd.is_some() || tolerances.surface_difference_sd_m.is_some() {
        text += "\n[pads]\n";
        push(&mut text, RATIO_SD, tolerances.scale_ratio_sd);
        push(&mut text, DIFFERENCE_SD, tolerances.surface_difference_sd_m);
    }
    text += "\n[angles]\n";
    for k in 0..2 {
        push(&mut text, ANGLE_ZERO[k], Some(calibration.angle_zero_rad[k]));
        push(&mut text, ANGLE_ZERO_SD[k], Some(tolerances.angle_zero_sd_rad[k]));
        push(&mut text, SIGN[k], Some(conventions.angle_signs[k]));
    }
    push(&mut text, ANGLE_READING_SD, *angle_reading_sd_rad);
    text += "\n[clock]\n";
    push(&mut text, CLOCK, Some(calibration.clock_offset_s));
    push(&mut text, CLOCK_SD, Some(tolerances.clock_offset_sd_s));
    text
}

fn push(text: &mut String, key: Key, value: Option<f64>) {
    if let Some(value) = value {
        text.push_str(&format!("{} = {}\n", key.si_name(), number(value)));
    }
}

#[cfg(test)]
mod tests {
    use palpate::sensor::{Calibration, Rig, Tolerances};
    use proptest::prelude::*;

    use super::*;
    use crate::rig::Pad;
    use crate::rig::conventions::{Conventions, PalmConventions};
    use crate::rig::parse::parse_rig;

    #[test]
    fn the_default_reads_back_the_same() {
        assert_eq!(parse_rig("rig.toml", &rig_to_toml(&RigFile::default())), Ok(RigFile::default()));
    }

    fn two<T: std::fmt::Debug>(of: impl Strategy<Value = T> + Clone) -> impl Strategy<Value = [T; 2]> {
        (of.clone(), of).prop_map(|(one, two)| [one, two])
    }

    /// Standard deviations, also exact and tiny ones.
    fn sd() -> impl Strategy<Value = f64> + Clone {
        prop_oneof![Just(0.0), 0.0..0.1, 1e-12..1e-6, Just(1.0), Just(1e20)]
    }

    fn maybe<T: Clone + std::fmt::Debug>(
        of: impl Strategy<Value = T> + Clone,
    ) -> impl Strategy<Value = Option<T>> + Clone {
        prop_oneof![Just(None), of.prop_map(Some)]
    }

    fn rig() -> impl Strategy<Value = Rig> {
        let calibration = (two(-0.1..0.1), two(0.5..2.0), two(-0.5..0.5), two(-0.1..0.1), -1.0..1.0).prop_map(
            |(zero_m, scale, angle_zero_rad, surface_m, clock_offset_s)| {
                let mut calibration = Calibration::default();
                (calibration.zero_m, calibration.scale, calibration.surface_m) = (zero_m, scale, surface_m);
                (calibration.angle_zero_rad, calibration.clock_offset_s) = (angle_zero_rad, clock_offset_s);
                calibration
            },
        );
        let tolerances = (two(sd()), two(sd()), two(sd()), two(sd()), sd()).prop_map(
            |(zero_sd_m, scale_sd, angle_zero_sd_rad, surface_sd_m, clock_offset_sd_s)| {
                let mut tolerances = Tolerances::default();
                (tolerances.zero_sd_m, tolerances.scale_sd, tolerances.surface_sd_m) =
                    (zero_sd_m, scale_sd, surface_sd_m);
                (tolerances.angle_zero_sd_rad, tolerances.clock_offset_sd_s) = (angle_zero_sd_rad, clock_offset_sd_s);
                tolerances
            },
        );
        (calibration, tolerances).prop_map(|(calibration, tolerances)| Rig::new(calibration, tolerances))
    }

    fn conventions() -> impl Strategy<Value = Conventions> {
        let direction = prop_oneof![
            maybe(1e-3..10.0).prop_map(|length_m| Direction::FromBase { length_m }),
            (1e-3..10.0).prop_map(|length_m| Direction::ToBase { length_m }),
        ];
        let palm = (direction, two(maybe(-100.0..100.0)))
            .prop_map(|(direction, base_m)| PalmConventions { direction, base_m })
            .boxed();
        (two(palm), two(prop_oneof![Just(1.0), Just(-1.0)]))
            .prop_map(|(palms, angle_signs)| Conventions { palms, angle_signs })
    }

    fn pad() -> impl Strategy<Value = Pad> + Clone {
        let friction = maybe((0.0..2.0, maybe(sd())));
        (maybe(sd()), maybe(1.0..1e5), maybe(2..=u32::MAX), friction)
            .prop_map(|(reading_sd_m, counts_per_inch, levels, friction)| Pad {
                reading_sd_m,
                counts_per_inch,
                levels,
                friction: friction.map(|(friction, _)| friction),
                friction_sd: friction.and_then(|(_, sd)| sd),
            })
            .boxed()
    }

    proptest! {
        #[test]
        fn any_rig_reads_back_the_same(rig in rig(), conventions in conventions(), pads in two(pad()), angle_reading_sd_rad in maybe(sd())) {
            let file = RigFile { rig, conventions, pads, angle_reading_sd_rad };
            let text = rig_to_toml(&file);
            prop_assert_eq!(parse_rig("rig.toml", &text), Ok(file), "{}", text);
        }
    }
}
