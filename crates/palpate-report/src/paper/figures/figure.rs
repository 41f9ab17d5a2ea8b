//! A figure of the paper, drawn.

/// A figure: SVG text with what to say about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of its files, without extension.
    pub name: &'static str,
    /// Number and title.
    pub title: String,
    /// What it shows.
    pub caption: String,
    /// The figure.
    pub svg: String,
    /// The figure belongs beside the one before it, which shows the same by the other method.
    pub beside: bool,
}

/// Names of all figures, in the order in which they are drawn.
pub const FIGURE_NAMES: [&str; 18] = [
    "figure-1-arrangements",
    "figure-2-contact-support",
    "figure-3-frames",
    "figure-4-dependencies",
    "figure-5-generalized-contact-support",
    "figure-6-palms-ode",
    "figure-6-palms-likelihood",
    "figure-7-palms-ode",
    "figure-7-palms-likelihood",
    "figure-7-exact-ode",
    "figure-7-exact-likelihood",
    "figure-6-fingers-ode",
    "figure-6-fingers-likelihood",
    "figure-7-fingers-ode",
    "figure-7-fingers-likelihood",
    "figure-8-ode",
    "figure-8-likelihood",
    "figure-9-pivoting-grasp",
];
