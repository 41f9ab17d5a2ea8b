//! What waits in the queue of a shortest-path search (E. W. Dijkstra, *Numerische Mathematik* 1, 269, 1959).

/// An entry of the queue of a shortest-path search; the greatest is the cheapest.
pub(super) struct Waiting {
    pub(super) cost: f64,
    pub(super) node: (usize, i64),
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.cost.total_cmp(&self.cost).then(other.node.cmp(&self.node))
    }
}
