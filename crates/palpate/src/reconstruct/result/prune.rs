//! Pruning of the outline by the number of touches: what a contact went over only once is less sure than what was felt again and again
//! (Moll & Erdmann 2001, section 5).

use super::reconstruction::{OutlinePoint, Reconstruction};

impl Reconstruction {
    /// Counts boundary that was felt fewer than `min_touches` times as never felt, in the alternatives too. `coverage` follows.
    pub fn prune(&mut self, min_touches: u32) {
        let few = |point: &&mut OutlinePoint| point.touches < min_touches;
        self.outline.iter_mut().filter(few).for_each(|point| point.touches = 0);
        if !self.outline.is_empty() {
            let felt = self.outline.iter().filter(|point| point.touches > 0).count();
            self.coverage = felt as f64 / self.outline.len() as f64;
        }
        self.others.iter_mut().for_each(|other| other.prune(min_touches));
    }
}
