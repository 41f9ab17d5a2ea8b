//! The page that ties the figures together.

use crate::html::escape;
use crate::paper::figures::errors;
use crate::paper::figures::figure::{FIGURE_NAMES, Figure};
use crate::paper::input::PaperInput;

const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#1d2733;--soft:#5b6672;--paper:#ffffff;--rule:#dfe3e8}\
@media(prefers-color-scheme:dark){:root{--ink:#e6e9ed;--soft:#a3adb8;--paper:#14181d;--rule:#2c343d}}\
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.55 system-ui,sans-serif}\
main{max-width:1500px;margin:0 auto;padding:2rem 1.25rem 4rem}\
h1{font-size:1.8rem;line-height:1.2;margin:0 0 .5rem}h2{font-size:1.3rem;margin:3rem 0 .75rem}\
p{max-width:46rem}a{color:inherit}\
.row{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,34rem),1fr));gap:1.5rem;align-items:start;margin:1.25rem 0}\
figure{margin:0}figure:only-child{max-width:62rem}figure img{width:100%;height:auto;border:1px solid var(--rule);border-radius:6px;background:#fff}\
figcaption{font-size:.9rem;color:var(--soft);margin-top:.4rem}figcaption strong{color:var(--ink)}\
.wide{overflow-x:auto}table{border-collapse:collapse;font-variant-numeric:tabular-nums}\
th,td{padding:.4rem .8rem;border-bottom:1px solid var(--rule);text-align:right;vertical-align:bottom}\
th:nth-child(-n+2),td:nth-child(-n+2){text-align:left;white-space:nowrap}tbody tr:nth-child(2n) td{border-bottom-color:var(--soft)}\
footer{margin-top:3rem;color:var(--soft);font-size:.9rem}";

/// The page as one HTML document. It shows the SVG files of the figures, which must lie beside it, and links to their pictures.
pub fn paper_page(input: &PaperInput, figures: &[Figure]) -> String {
    let mut sections = String::new();
    let mut index = 0;
    while index < figures.len() {
        let heading = match figures[index].name {
            "figure-1-arrangements" => Some("The geometry"),
            "figure-6-palms-ode" => Some("Simulation: two palms"),
            "figure-7-exact-ode" => Some("Simulation without noise"),
            "figure-6-fingers-ode" => Some("Simulation: two fingers"),
            "figure-8-ode" => Some("Experiment"),
            _ => None,
        };
        if let Some(heading) = heading {
            sections += &format!("<h2>{heading}</h2>\n{}", introduction(figures[index].name, input));
        }
        let small = |figure: &Figure| !figure.beside && (1..5).contains(&index_of(figure));
        // Small figures stand in rows, and so do a pair by both methods.
        let mut row = vec![&figures[index]];
        while let Some(next) = figures.get(index + row.len())
            && (next.beside || (small(next) && small(row[0]) && row.len() < 2))
        {
            row.push(next);
        }
        sections += "<div class=\"row\">\n";
        for figure in &row {
            sections += &shown(figure);
        }
        sections += "</div>\n";
        index += row.len();
    }
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"generator\" content=\"palpate paper\">\n\
         <title>The figures of Moll &amp; Erdmann (2001), reproduced</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n\
         <h1>The figures of Moll &amp; Erdmann (2001), reproduced</h1>\n\
         <p>M. Moll and M. A. Erdmann, <em>Reconstructing Shape from Motion Using Tactile Sensors</em>, IROS 2001. Each figure is \
         drawn from data that palpate simulated and reconstructed, twice over: by the paper's own method, the differential equations 19 \
         to 21 with searched initial conditions, and by maximum likelihood. Neither is told anything but the log.</p>\n\
         <h2>Both methods on the same logs</h2>\n<div class=\"wide\">\n{}</div>\n{}{sections}\
         <footer>Made by palpate {} with the command <code>palpate paper</code>. The same version makes the same figures.</footer>\n\
         </main>\n</body>\n</html>\n",
        errors::table(input),
        "<p>Shape errors are those of the support function over the boundary that was felt, after the best rotation; the truth of the \
         experiment is what the camera sees, whose own error is in its orientation and centre of mass. The contact vector error needs no truth: a method may look good in it and be wrong. \
         The table is there as <a href=\"errors.csv\">errors.csv</a>, in SI units, and beside each log <code>NAME.csv</code> its truth, \
         <code>NAME.truth</code>, which <code>palpate reconstruct NAME.csv</code> compares its result with.</p>\n",
        escape(input.version),
    )
}

fn index_of(figure: &Figure) -> usize {
    FIGURE_NAMES.iter().position(|name| *name == figure.name).unwrap_or(usize::MAX)
}

fn introduction(name: &str, input: &PaperInput) -> String {
    let noise = 1e3 * input.simulation_sd_m;
    match name {
        "figure-6-palms-ode" => format!(
            "<p>{} measurements with {noise:.2} mm of noise while the palms, nearly flat at first, squeeze and rotate, and open one at a time: \
             an open-loop motion, chosen so that this object does not jump. Its log is <a href=\"palms.csv\">palms.csv</a>.</p>\n",
            input.palms.log.samples.len()
        ),
        "figure-7-exact-ode" => format!(
            "<p>The first simulation with exact readings, as in the paper: what is left is due to {} samples alone. The log is \
             <a href=\"exact.csv\">exact.csv</a>.</p>\n",
            input.exact.log.samples.len()
        ),
        "figure-6-fingers-ode" => format!(
            "<p>The same object on two fingers whose base points lie {:.0} mm apart. The log is <a href=\"fingers.csv\">fingers.csv</a>.</p>\n",
            1e3 * input.fingers.log.samples.first().map_or(0.0, |sample| {
                let (a, b) = (sample.palms.base1_m, sample.palms.base2_m);
                (a[0] - b[0]).hypot(a[1] - b[1])
            })
        ),
        "figure-8-ode" => format!(
            "<p>The touchpads of the paper: {:.1} mm long, 200 counts per inch, 128 pressure levels, 100 readings a second. A smooth convex object \
             never touches a pad in two places; if it did, the pad would report the centroid. The palms go back and forth, so that the boundary \
             is felt several times over. A camera with noise of its own ({:.1} mm on each marker) gives the truth by rigid-body fits. {} measurements, in \
             <a href=\"experiment.csv\">experiment.csv</a>.</p>\n",
            1e3 * input.experiment.pad_length_m,
            1e3 * input.vision.noise_sd_m,
            input.experiment.log.samples.len()
        ),
        _ => String::new(),
    }
}

fn shown(figure: &Figure) -> String {
    let (name, title) = (figure.name, escape(&figure.title));
    format!(
        "<figure><a href=\"{name}.png\"><img src=\"{name}.svg\" alt=\"{title}\"></a>\
         <figcaption><strong>{title}.</strong> {}</figcaption></figure>\n",
        escape(&figure.caption)
    )
}
