//! Lattices of nodes linked to neighbours, and the paths along their links.

/// The eight steps to a neighbour, x right and y down; the opposite of step `i` is `i + 4` modulo 8.
pub(crate) const STEPS: [[i32; 2]; 8] = [
    [1, 0],
    [1, 1],
    [0, 1],
    [-1, 1],
    [-1, 0],
    [-1, -1],
    [0, -1],
    [1, -1],
];

/// Nodes in rows, each linked to some of its eight neighbours.
#[derive(Debug, Clone)]
pub(crate) struct Lattice {
    width: usize,
    height: usize,
    /// Bit i of a node: whether it is linked along step i.
    links: Vec<u8>,
    /// The nodes that have links, in order.
    pub(crate) linked: Vec<u32>,
}

/// Nodes joined one to the next by links.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NodePath {
    /// The nodes in order; of a closed path the first is not repeated.
    pub nodes: Vec<u32>,
    /// Whether the last node is linked to the first.
    pub closed: bool,
}

impl Lattice {
    /// A lattice of `width` by `height` nodes with these links, each given once: a node and a step.
    ///
    /// # Panics
    /// If a link leads out of the lattice.
    pub(crate) fn new(
        width: usize,
        height: usize,
        links: impl IntoIterator<Item = (u32, usize)>,
    ) -> Self {
        let mut lattice = Self {
            width,
            height,
            links: vec![0; width * height],
            linked: Vec::new(),
        };
        for (node, step) in links {
            let to = lattice.neighbour(node, step).expect("links stay inside");
            for (node, step) in [(node, step), (to, (step + 4) % 8)] {
                let bits = &mut lattice.links[node as usize];
                if *bits == 0 {
                    lattice.linked.push(node);
                }
                *bits |= 1 << step;
            }
        }
        lattice.linked.sort_unstable();
        lattice
    }

    /// The column and row of a node.
    pub(crate) fn place(&self, node: u32) -> [usize; 2] {
        [node as usize % self.width, node as usize / self.width]
    }

    /// Number of links of a node.
    pub(crate) fn degree(&self, node: u32) -> u32 {
        self.links[node as usize].count_ones()
    }

    /// Whether a node is on the rim of the lattice, or up to `steps` inside.
    pub(crate) fn on_rim(&self, node: u32, steps: usize) -> bool {
        let [x, y] = self.place(node);
        x.min(y) <= steps || x + 1 + steps >= self.width || y + 1 + steps >= self.height
    }

    /// The node a step away, if there is one.
    pub(crate) fn neighbour(&self, node: u32, step: usize) -> Option<u32> {
        let [dx, dy] = STEPS[step];
        let [x, y] = self.place(node);
        let (x, y) = (x as i64 + i64::from(dx), y as i64 + i64::from(dy));
        let inside = (0..self.width as i64).contains(&x) && (0..self.height as i64).contains(&y);
        inside.then(|| (y * self.width as i64 + x) as u32)
    }

    /// Every link once, in paths that end only at nodes with another number of links than two, or close.
    pub(crate) fn paths(&self) -> Vec<NodePath> {
        let mut left = self.links.clone();
        let mut paths = Vec::new();
        let at_ends = self.linked.iter().filter(|&&node| self.degree(node) != 2);
        for &start in at_ends {
            while left[start as usize] != 0 {
                paths.push(self.walk(start, &mut left));
            }
        }
        for &start in &self.linked {
            if left[start as usize] != 0 {
                paths.push(self.walk(start, &mut left));
            }
        }
        paths
    }

    /// Follows links from `start`, removing each from `left`.
    fn walk(&self, start: u32, left: &mut [u8]) -> NodePath {
        let mut nodes = vec![start];
        let mut at = start;
        loop {
            let step = left[at as usize].trailing_zeros() as usize;
            let to = self.neighbour(at, step).expect("links stay inside");
            left[at as usize] &= !(1 << step);
            left[to as usize] &= !(1 << ((step + 4) % 8));
            let closed = to == start && self.degree(start) == 2;
            if !closed {
                nodes.push(to);
            }
            if closed || self.degree(to) != 2 {
                return NodePath { nodes, closed };
            }
            at = to;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_run_from_junction_to_end_and_around() {
        // A square of 2 x 2 links with a tail from its corner (2, 0), and a loop apart:
        // nodes 5 wide; the corner (2, 0) has three links.
        let square = [
            (0, 0),
            (1, 0),
            (0, 2),
            (5, 2),
            (10, 0),
            (11, 0),
            (2, 2),
            (7, 2),
        ];
        let tail = [(2, 0), (3, 0)];
        let apart = [(15, 0), (20, 0), (15, 2), (16, 2)];
        let lattice = Lattice::new(5, 5, [&square[..], &tail, &apart].concat());
        let paths = lattice.paths();
        assert_eq!(paths.len(), 3);
        let find = |length: usize, closed| {
            paths
                .iter()
                .any(|path| path.nodes.len() == length && path.closed == closed)
        };
        // The square starts and ends at its junction: nine nodes. The tail has three, the loop four.
        assert!(
            find(9, false) && find(3, false) && find(4, true),
            "{paths:?}"
        );
    }
}
