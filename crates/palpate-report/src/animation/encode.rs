//! Pictures as an animated GIF: one palette for all of them, and in each only what has changed.

use std::collections::HashMap;
use std::iter::repeat_n;

use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use resvg::tiny_skia::Pixmap;

/// Colours of the palette; one more index stands for what is as it was.
const COLORS: usize = 255;
const AS_IT_WAS: u8 = 255;

/// So many pictures are counted for the palette.
const COUNTED: usize = 12;

type Color = [u8; 3];

/// A file of pictures of the same size, each shown for so many hundredths of a second, again and again.
pub(super) fn gif(pictures: &[Pixmap], delays_cs: impl IntoIterator<Item = u16>) -> Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    let Some(first) = pictures.first() else { return Ok(file) };
    let (width, height) = (first.width() as u16, first.height() as u16);
    let mut palette = Palette::of(pictures);
    let mut encoder = Encoder::new(&mut file, width, height, &palette.colors.concat())?;
    encoder.set_repeat(Repeat::Infinite)?;
    let mut shown: Vec<u8> = Vec::new();
    for (picture, delay) in pictures.iter().zip(delays_cs) {
        let next: Vec<u8> = runs(picture).flat_map(|(color, length)| repeat_n(palette.index(color), length)).collect();
        encoder.write_frame(&Frame { delay, dispose: DisposalMethod::Keep, ..changed(&shown, &next, width) })?;
        shown = next;
    }
    drop(encoder);
    Ok(file)
}

/// The smallest rectangle with all that differs; what does not is left as it was. All of it where there is nothing yet.
fn changed(shown: &[u8], next: &[u8], width: u16) -> Frame<'static> {
    let wide = usize::from(width);
    let differs = |at: usize| shown.get(at) != Some(&next[at]);
    let places = || (0..next.len()).filter(|&at| differs(at));
    let (top, bottom) = (places().next().unwrap_or(0) / wide, places().next_back().unwrap_or(0) / wide);
    let (left, right) = places().fold((wide, 0), |(left, right), at| (left.min(at % wide), right.max(at % wide)));
    let (left, right) = (left.min(right), right);
    let buffer = (top..=bottom).flat_map(|row| (left..=right).map(move |column| row * wide + column));
    let buffer: Vec<u8> = buffer.map(|at| if differs(at) { next[at] } else { AS_IT_WAS }).collect();
    Frame {
        top: top as u16,
        left: left as u16,
        width: (right - left + 1) as u16,
        height: (bottom - top + 1) as u16,
        transparent: Some(AS_IT_WAS),
        buffer: buffer.into(),
        ..Frame::default()
    }
}

/// The colours of a picture row by row, each with how many pixels in sequence have it.
fn runs(picture: &Pixmap) -> impl Iterator<Item = (Color, usize)> {
    let runs = picture.pixels().chunk_by(|a, b| a == b);
    // The pictures are opaque: nothing is premultiplied.
    runs.map(|run| ([run[0].red(), run[0].green(), run[0].blue()], run.len()))
}

/// The colours that occur most often; drawings of few colours keep theirs, and what lies on an edge gets the nearest.
struct Palette {
    colors: Vec<Color>,
    known: HashMap<Color, u8>,
}

impl Palette {
    fn of(pictures: &[Pixmap]) -> Self {
        let mut counts: HashMap<Color, usize> = HashMap::new();
        let stride = pictures.len().div_ceil(COUNTED).max(1);
        for picture in pictures.iter().rev().step_by(stride) {
            for (color, length) in runs(picture) {
                *counts.entry(color).or_default() += length;
            }
        }
        let mut often: Vec<(Color, usize)> = counts.into_iter().collect();
        often.sort_unstable_by_key(|&(color, count)| (std::cmp::Reverse(count), color));
        let mut colors: Vec<Color> = often.into_iter().take(COLORS).map(|(color, _)| color).collect();
        colors.resize(COLORS + 1, [0; 3]);
        Self { colors, known: HashMap::new() }
    }

    fn index(&mut self, color: Color) -> u8 {
        let apart =
            |other: &Color| -> u32 { color.iter().zip(other).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum() };
        let nearest = || (0..AS_IT_WAS).min_by_key(|&index| apart(&self.colors[usize::from(index)])).unwrap_or(0);
        let index = self.known.get(&color).copied().unwrap_or_else(nearest);
        self.known.insert(color, index);
        index
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use resvg::tiny_skia;

    #[test]
    fn pictures_come_back_as_they_were() {
        let pictures: Vec<Pixmap> = (0..3)
            .map(|step| {
                let mut picture = Pixmap::new(20, 10).expect("a size");
                picture.fill(tiny_skia::Color::WHITE);
                let place = tiny_skia::Rect::from_xywh(4.0 + step as f32, 2.0, 3.0, 5.0).expect("a rectangle");
                let mut paint = tiny_skia::Paint::default();
                paint.set_color_rgba8(213, 94, 0, 255);
                picture.fill_rect(place, &paint, tiny_skia::Transform::identity(), None);
                picture
            })
            .collect();
        let file = gif(&pictures, [8, 8, 160]).expect("a file");
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(file.as_slice()).expect("a GIF");
        assert_eq!((decoder.width(), decoder.height()), (20, 10));
        let mut screen = vec![0_u8; 4 * 20 * 10];
        for (picture, delay) in pictures.iter().zip([8, 8, 160]) {
            let frame = decoder.read_next_frame().expect("a frame").expect("one more");
            assert_eq!(frame.delay, delay);
            let (left, top, width) = (usize::from(frame.left), usize::from(frame.top), usize::from(frame.width));
            for (at, pixel) in frame.buffer.chunks(4).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
                let place = 4 * ((top + at / width) * 20 + left + at % width);
                screen[place..place + 4].copy_from_slice(pixel);
            }
            assert_eq!(screen, picture.data());
        }
        assert_eq!(decoder.repeat(), Repeat::Infinite);
        // The second one is no larger than what changed: two columns.
        assert!(changed(&[0; 200], &[0; 200], 20).buffer.len() == 1);
    }
}
