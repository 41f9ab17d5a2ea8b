//! One picture of the motion: palms, contacts, object, and what of it was felt so far.

use palpate::palms::{Palm, PalmPair};
use palpate::reconstruct::Pose;
use palpate::{Log, Reconstruction, Sample};
use std::f64::consts::TAU;

use crate::drawing::colors::{GREY, INK};
use crate::drawing::svg::{Anchor, Point, Sheet, View, area, line, plain};

// Colours of the report's page in its light theme.
const ESTIMATE: &str = "#0072b2";
const CONTACT1: &str = "#b0478c";
const CONTACT2: &str = "#d55e00";
const PALM: &str = "#c3c8d0";

const WIDTH: f64 = 640.0;
const MIN_HEIGHT: f64 = 300.0;
const MAX_HEIGHT: f64 = 520.0;
const MARGIN: f64 = 18.0;
/// Room for a line of text at the bottom.
const FOOT: f64 = 22.0;
const PALM_THICKNESS: f64 = 9.0;
/// The shares of the motion between which what was inferred appears, as on the page.
const BLIND: f64 = 0.07;
const SEEN: f64 = 0.3;

/// All that stays the same from picture to picture.
pub(super) struct Stage<'a> {
    samples: &'a [Sample],
    motion: &'a [Pose],
    outline: Vec<Point>,
    /// When each point of the outline was first felt, seconds; infinite where it never was.
    first_felt_s: Vec<f64>,
    palm_lengths_m: [f64; 2],
    radius_m: f64,
    view: View,
    height: f64,
}

/// What is to be seen at a time.
struct Instant {
    time_s: f64,
    palms: PalmPair,
    contacts_m: [Option<f64>; 2],
    psi_rad: f64,
    com_m: Point,
}

impl<'a> Stage<'a> {
    /// Nothing where nothing moves.
    pub fn new(log: &'a Log, found: &'a Reconstruction) -> Option<Self> {
        let count = log.samples.len().min(found.motion.len());
        let (samples, motion) = (&log.samples[..count], &found.motion[..count]);
        let span = samples.last()?.time_s - samples.first()?.time_s;
        let outline: Vec<Point> = found.outline.iter().map(|point| [point.x_m, point.y_m]).collect();
        let finite = outline.iter().flatten().all(|value| value.is_finite())
            && motion.iter().all(|pose| (pose.psi_rad + pose.com_x_m + pose.com_y_m).is_finite())
            && samples.iter().all(|sample| (sample.time_s + sample.palms.phi12_rad()).is_finite());
        if !finite || span.is_nan() || span <= 0.0 || outline.len() < 3 {
            return None;
        }
        let reach_m = outline.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
        let longest = |of: fn(&Sample) -> Option<f64>| {
            let seen = samples.iter().filter_map(of).filter(|s| s.is_finite()).fold(0.0, f64::max);
            if seen > 0.0 { 1.1 * seen } else { 3.0 * reach_m }
        };
        let palm_lengths_m = [longest(|sample| sample.s1_m), longest(|sample| sample.s2_m)];
        // Everything that will ever be in view.
        let stride = count.div_ceil(1500);
        let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for (sample, pose) in samples.iter().zip(motion).step_by(stride) {
            let bodies = [-reach_m, reach_m].map(|by| [pose.com_x_m + by, pose.com_y_m + by]);
            let ends = [Palm::One, Palm::Two].map(|palm| ends_m(&sample.palms, palm, &palm_lengths_m));
            for point in bodies.into_iter().chain(ends.into_iter().flatten()) {
                for axis in [0, 1] {
                    low[axis] = low[axis].min(point[axis]);
                    high[axis] = high[axis].max(point[axis]);
                }
            }
        }
        let inner = WIDTH - 2.0 * MARGIN;
        let wanted = inner * (high[1] - low[1]) / (high[0] - low[0]).max(1e-12);
        let height = (wanted + 2.0 * MARGIN + FOOT).clamp(MIN_HEIGHT, MAX_HEIGHT).round();
        let view = View::fitting(low, high, [MARGIN; 2], [inner, height - 2.0 * MARGIN - FOOT]);
        let radius_m = found.shape.mean_radius_m();
        let first_felt_s = first_felt_s(found, samples, motion);
        Some(Self { samples, motion, outline, first_felt_s, palm_lengths_m, radius_m, view, height })
    }

    /// The picture at a share of the motion, 0 to 1, as SVG.
    pub fn at(&self, share: f64) -> String {
        let now = self.instant(share);
        let clear = ((share - BLIND) / (SEEN - BLIND)).clamp(0.0, 1.0);
        let clear = clear * clear * (3.0 - 2.0 * clear);
        let mut sheet = Sheet::new(WIDTH, self.height);
        sheet.faded(clear, |sheet| self.trail(sheet));
        for palm in [Palm::One, Palm::Two] {
            self.palm(&mut sheet, &now, palm);
        }
        if clear > 0.0 {
            let ring = || self.outline.iter().map(|point| self.view.at(now.placed(*point)));
            if clear < 1.0 {
                let wide = 2.0 + (1.0 - clear) * self.radius_m / self.view.metres(1.0);
                sheet.faded(clear * (1.0 - clear), |sheet| sheet.path(ring(), true, line(ESTIMATE, wide)));
            }
            sheet.faded(clear, |sheet| self.object(sheet, &now, ring()));
        }
        let mut base = |at: Point| sheet.dot(self.view.at(at), 3.5, line(INK, 1.4).filled("#ffffff"));
        base(now.palms.base1_m);
        if now.palms.base2_m != now.palms.base1_m {
            base(now.palms.base2_m);
        }
        for palm in [Palm::One, Palm::Two] {
            self.contact(&mut sheet, &now, palm);
        }
        let felt = self.first_felt_s.iter().filter(|first| **first <= now.time_s).count();
        let words = format!(
            "{:.1} s, {:.0} % felt",
            now.time_s - self.samples[0].time_s,
            100.0 * felt as f64 / self.outline.len() as f64
        );
        let foot = self.height - 10.0;
        sheet.text([MARGIN, foot], &words, plain(13.0).anchored(Anchor::Start).colored(GREY));
        self.scale(&mut sheet, foot);
        sheet.finish("Two palms, two contacts, and what follows from them")
    }

    fn instant(&self, share: f64) -> Instant {
        let (start, end) = (self.samples[0].time_s, self.samples[self.samples.len() - 1].time_s);
        let time_s = start + share * (end - start);
        let index = self.samples.partition_point(|sample| sample.time_s <= time_s).saturating_sub(1);
        let next = (index + 1).min(self.samples.len() - 1);
        let ([one, two], [from, to]) =
            ([index, next].map(|i| &self.samples[i]), [index, next].map(|i| &self.motion[i]));
        let step = two.time_s - one.time_s;
        let fraction = if step > 0.0 && from.piece == to.piece { (time_s - one.time_s) / step } else { 0.0 };
        let between = |a: f64, b: f64| a + fraction * (b - a);
        let contact = |a: Option<f64>, b: Option<f64>| a.map(|a| between(a, b.unwrap_or(a)));
        Instant {
            time_s,
            palms: one.palms.towards(&two.palms, fraction),
            contacts_m: [contact(one.s1_m, two.s1_m), contact(one.s2_m, two.s2_m)],
            psi_rad: between(from.psi_rad, to.psi_rad),
            com_m: [between(from.com_x_m, to.com_x_m), between(from.com_y_m, to.com_y_m)],
        }
    }

    fn trail(&self, sheet: &mut Sheet) {
        for run in self.motion.chunk_by(|a, b| a.piece == b.piece) {
            let places = run.iter().map(|pose| self.view.at([pose.com_x_m, pose.com_y_m]));
            sheet.faded(0.55, |sheet| sheet.path(places, false, line(GREY, 1.0)));
        }
    }

    fn palm(&self, sheet: &mut Sheet, now: &Instant, palm: Palm) {
        let ends = ends_m(&now.palms, palm, &self.palm_lengths_m).map(|end| self.view.at(end));
        // The normal points to the object, and the sheet has its y axis downwards.
        let [nx, ny] = now.palms.normal(palm);
        let back = ends.map(|[x, y]| [x - PALM_THICKNESS * nx, y + PALM_THICKNESS * ny]);
        sheet.path([ends[0], ends[1], back[1], back[0]], true, area(PALM));
        sheet.segment(ends[0], ends[1], line(INK, 1.4));
    }

    fn object(&self, sheet: &mut Sheet, now: &Instant, ring: impl Iterator<Item = Point> + Clone) {
        sheet.faded(0.07, |sheet| sheet.path(ring.clone(), true, area(ESTIMATE)));
        sheet.path(ring.clone(), true, line(GREY, 1.0));
        let felt = |index: usize| self.first_felt_s[index] <= now.time_s;
        // Points that were not felt break the line; the first one closes the ring.
        let points: Vec<Point> = ring.collect();
        let around = (0..=points.len()).map(|index| index % points.len());
        let line_of = around.map(|index| if felt(index) { points[index] } else { [f64::NAN; 2] });
        sheet.path(line_of, false, line(ESTIMATE, 3.0));
        let [x, y] = self.view.at(now.com_m);
        let down = (0.55 * self.radius_m / self.view.metres(1.0)).max(24.0);
        sheet.arrow([x, y], [x, y + down], line(INK, 1.6));
        sheet.dot([x, y], 6.0, line(INK, 1.4).filled("#ffffff"));
        for quarter in [0.25, 0.75] {
            let arc = crate::drawing::svg::arc([0.0; 2], 6.0, TAU * (quarter - 0.25), TAU * quarter);
            sheet.path(arc.map(|[dx, dy]| [x + dx, y - dy]).chain([[x, y]]), true, area(INK));
        }
    }

    fn contact(&self, sheet: &mut Sheet, now: &Instant, palm: Palm) {
        let (index, color) = match palm {
            Palm::One => (0, CONTACT1),
            Palm::Two => (1, CONTACT2),
        };
        let Some(length_m) = now.contacts_m[index].filter(|s| s.is_finite()) else { return };
        let [_, at] = ends_m(&now.palms, palm, &[length_m; 2]).map(|end| self.view.at(end));
        sheet.dot(at, 6.5, line("#ffffff", 1.6).filled(color));
        let [nx, ny] = now.palms.normal(palm);
        let beside = [at[0] - 21.0 * nx, at[1] + 21.0 * ny + 4.0];
        sheet.text(beside, &(index + 1).to_string(), plain(12.0));
    }

    fn scale(&self, sheet: &mut Sheet, foot: f64) {
        let mut rounds = (-3..5).flat_map(|power| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(power)));
        let Some(mm) = rounds.rfind(|mm| 1e-3 * mm / self.view.metres(1.0) <= 96.0) else { return };
        let right = WIDTH - MARGIN;
        let left = right - 1e-3 * mm / self.view.metres(1.0);
        sheet.path([[left, foot - 4.0], [left, foot], [right, foot], [right, foot - 4.0]], false, line(INK, 1.4));
        sheet.text([0.5 * (left + right), foot - 6.0], &format!("{mm} mm"), plain(12.0));
    }
}

impl Instant {
    /// A point of the object in the frame of the room.
    fn placed(&self, [x, y]: Point) -> Point {
        let (sin, cos) = self.psi_rad.sin_cos();
        [self.com_m[0] + cos * x - sin * y, self.com_m[1] + sin * x + cos * y]
    }
}

/// Base and tip of a palm.
fn ends_m(palms: &PalmPair, palm: Palm, lengths_m: &[f64; 2]) -> [Point; 2] {
    let [tx, ty] = palms.tangent(palm);
    let (base, along) = match palm {
        Palm::One => (palms.base1_m, lengths_m[0]),
        Palm::Two => (palms.base2_m, -lengths_m[1]),
    };
    [base, [base[0] + along * tx, base[1] + along * ty]]
}

/// When a contact first passed over each point of the outline.
fn first_felt_s(found: &Reconstruction, samples: &[Sample], motion: &[Pose]) -> Vec<f64> {
    let nodes = found.outline.len();
    let itself = found.felt_itself();
    let spacing = TAU / nodes as f64;
    let origin = found.outline[0].theta_rad;
    let mut first = vec![f64::INFINITY; nodes];
    for palm in [Palm::One, Palm::Two] {
        // The normal angle at the contact, where one was seen.
        let angle = |index: usize| {
            let (seen, theta_rad) = match palm {
                Palm::One => (samples[index].s1_m, motion[index].theta1_rad),
                Palm::Two => (samples[index].s2_m, motion[index].theta2_rad),
            };
            seen.map(|_| theta_rad).filter(|theta| theta.is_finite())
        };
        for (index, sample) in samples.iter().enumerate() {
            let Some(to) = angle(index) else { continue };
            let before = index.checked_sub(1).filter(|&before| motion[before].piece == motion[index].piece);
            let from = before.and_then(angle).unwrap_or(to);
            let steps = ((to - from).abs() / spacing).ceil().clamp(1.0, nodes as f64) as usize;
            for step in 0..=steps {
                let theta = from + (to - from) * step as f64 / steps as f64;
                let node = ((theta - origin) / spacing).round().rem_euclid(nodes as f64) as usize % nodes;
                first[node] = first[node].min(sample.time_s);
            }
        }
    }
    // What the log felt only just, at the edge of a node, appears with its neighbour; what does not count as felt, never.
    let near = |node: usize| {
        let around = (1..=6).flat_map(|reach| [(node + reach) % nodes, (node + nodes - reach) % nodes]);
        std::iter::once(node)
            .chain(around)
            .map(|near| first[near])
            .find(|time| time.is_finite())
            .unwrap_or(f64::INFINITY)
    };
    (0..nodes).map(|node| if itself[node] { near(node) } else { f64::INFINITY }).collect()
}
