//! Pictures of SVG figures, with a font of their own: they come out the same on a machine without any.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

/// Pixels of a PNG file for one of the drawing.
const SCALE: f32 = 2.0;

/// Most pixels of a picture: 16 384 by 16 384.
const MOST_PIXELS: u64 = 1 << 28;

/// Why no picture could be made of a figure.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PngError {
    /// The SVG text is faulty.
    #[error("the figure is not valid SVG: {0}")]
    Svg(String),
    /// The picture cannot be as large as that.
    #[error("a picture of {width} x {height} pixels cannot be made")]
    Size {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
    },
    /// The picture cannot be packed.
    #[error("the picture cannot be written as PNG: {0}")]
    Packing(String),
}

/// The PNG file of an SVG document, twice as large in pixels. Text is set in DejaVu Sans.
///
/// # Errors
/// The document is faulty or far too large.
pub fn png(svg: &str) -> Result<Vec<u8>, PngError> {
    Painter::new().pixels(svg, SCALE)?.encode_png().map_err(|error| PngError::Packing(error.to_string()))
}

/// Makes pixels of SVG documents, with its fonts at hand.
pub(crate) struct Painter<'a>(Options<'a>);

impl Painter<'_> {
    /// With the fonts read.
    pub fn new() -> Self {
        let mut options = Options { font_family: "DejaVu Sans".to_owned(), ..Options::default() };
        let fonts: &mut fontdb::Database = options.fontdb_mut();
        for font in [dejavu::sans::regular(), dejavu::sans::bold(), dejavu::sans::oblique()] {
            fonts.load_font_data(font.to_vec());
        }
        Self(options)
    }

    /// A picture, `scale` pixels for one of the drawing.
    pub fn pixels(&self, svg: &str, scale: f32) -> Result<Pixmap, PngError> {
        let tree = Tree::from_str(svg, &self.0).map_err(|error| PngError::Svg(error.to_string()))?;
        let size = tree.size();
        let (width, height) = ((scale * size.width()).ceil() as u32, (scale * size.height()).ceil() as u32);
        if u64::from(width) * u64::from(height) > MOST_PIXELS {
            return Err(PngError::Size { width, height });
        }
        let mut pixels = Pixmap::new(width, height).ok_or(PngError::Size { width, height })?;
        resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
        Ok(pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_drawn_without_any_font_of_the_system() {
        let sheet = |text: &str| {
            format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"60\" height=\"20\" font-family=\"DejaVu Sans, sans-serif\">\
                 <rect width=\"60\" height=\"20\" fill=\"#fff\"/><text x=\"2\" y=\"15\" font-size=\"14\">{text}</text></svg>"
            )
        };
        let (empty, greek) = (png(&sheet("")).expect("a picture"), png(&sheet("φ₁ r̃₂")).expect("a picture"));
        assert!(greek.starts_with(b"\x89PNG") && greek.len() > empty.len() + 200, "{} {}", greek.len(), empty.len());
    }

    #[test]
    fn what_is_no_drawing_is_refused() {
        assert!(matches!(png("no drawing"), Err(PngError::Svg(_))));
        let huge = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1e7\" height=\"1e7\"/>";
        assert!(matches!(png(huge), Err(PngError::Size { .. })));
    }
}
