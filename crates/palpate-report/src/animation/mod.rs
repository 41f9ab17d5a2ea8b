//! The motion as an animated GIF, for slides and README files: first palms and contacts alone, then what follows from them.

mod encode;
mod stage;

use crate::drawing::png::{Painter, PngError};
use crate::input::ReportInput;
use stage::Stage;

/// Pictures of one round.
const FRAMES: usize = 120;
/// Time that each of them stands, in hundredths of a second.
const FRAME_CS: u16 = 8;
/// Time that the last one stands.
const LAST_CS: u16 = 160;

/// Why there is no animation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AnimationError {
    /// There are fewer than two samples, or no outline.
    #[error("nothing moves: an animation needs an outline and two samples at different times")]
    NothingMoves,
    /// A picture could not be made.
    #[error(transparent)]
    Picture(#[from] PngError),
    /// The pictures could not be packed.
    #[error("the animation cannot be written as GIF: {0}")]
    Packing(String),
}

/// The motion of a result as a GIF file that repeats itself.
///
/// # Errors
/// Nothing moves, or a picture cannot be made.
pub fn animation(input: &ReportInput) -> Result<Vec<u8>, AnimationError> {
    let stage = Stage::new(input.log, input.reconstruction).ok_or(AnimationError::NothingMoves)?;
    let painter = Painter::new();
    let pictures: Result<Vec<_>, PngError> =
        (0..FRAMES).map(|frame| painter.pixels(&stage.at(frame as f64 / (FRAMES - 1) as f64), 1.0)).collect();
    let delays = (1..=FRAMES).map(|frame| if frame == FRAMES { LAST_CS } else { FRAME_CS });
    encode::gif(&pictures?, delays).map_err(|error| AnimationError::Packing(error.to_string()))
}
