//! Patches: the part of one surface in one cell of a coarser grid. Pixels of different surfaces never share a patch, so
//! values passed from patch to patch stay on their surface.

/// Label of a pixel that belongs to no patch: uncovered, or on an edge.
pub(crate) const NO_PATCH: u8 = u8::MAX;

/// Largest side of a cell: its pixels have labels of one byte.
pub(crate) const MAX_CELL_PX: usize = 8;

/// Labels the open pixels of one cell, row by row in `labels` as in `open`, by the patch they are connected to through
/// their sides; returns the number of patches. Patches are numbered by their first pixels.
#[inline]
pub(crate) fn label_cell(open: &[bool], labels: &mut [u8], width: usize) -> usize {
    labels.fill(NO_PATCH);
    // Pixels as bits, row by row.
    let with = |bits: u64, i: usize| bits | 1 << i;
    let mut left = (0..open.len()).filter(|&i| open[i]).fold(0, with);
    let first_column = (0..open.len()).step_by(width).fold(0, with);
    let last_column = first_column << (width - 1);
    let mut count = 0;
    while left != 0 {
        let first = left & left.wrapping_neg();
        let (mut patch, mut before) = (first, 0);
        while patch != before {
            before = patch;
            let across = (patch << 1 & !first_column) | (patch >> 1 & !last_column);
            patch |= (across | patch << width | patch >> width) & left;
        }
        left &= !patch;
        while patch != 0 {
            labels[patch.trailing_zeros() as usize] = count;
            patch &= patch - 1;
        }
        count += 1;
    }
    usize::from(count)
}

/// Pairs of patches that continue across the side between two neighbouring cells; `first` and `second` are labels along
/// that side. Pairs that share most of it come first, and no patch is in two.
#[inline]
pub(crate) fn joined(first: &[u8], second: &[u8], mut join: impl FnMut(u8, u8)) {
    const MOST: usize = MAX_CELL_PX;
    // One patch on each side, as nearly everywhere.
    let mut pairs = [(NO_PATCH, NO_PATCH, 0_u8); MOST];
    let mut count = 0;
    for (&a, &b) in first.iter().zip(second) {
        if a == NO_PATCH || b == NO_PATCH {
            continue;
        }
        match pairs[..count].iter_mut().find(|p| (p.0, p.1) == (a, b)) {
            Some(pair) => pair.2 += 1,
            None => {
                pairs[count] = (a, b, 1);
                count += 1;
            }
        }
    }
    let pairs = &mut pairs[..count];
    if count > 1 {
        pairs.sort_by_key(|p| std::cmp::Reverse(p.2));
    }
    let mut done = [(NO_PATCH, NO_PATCH); MOST];
    for (i, &(a, b, _)) in pairs.iter().enumerate() {
        if done[..i].iter().all(|d| d.0 != a && d.1 != b) {
            done[i] = (a, b);
            join(a, b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(picture: &str) -> (usize, String) {
        let width = picture.split_whitespace().next().unwrap().len();
        let open: Vec<bool> = picture
            .split_whitespace()
            .flat_map(|row| row.bytes().map(|b| b == b'#'))
            .collect();
        let mut labels = vec![7; open.len()];
        let count = label_cell(&open, &mut labels, width);
        let shown = labels.iter().map(|&l| match l {
            NO_PATCH => '.',
            l => char::from(b'0' + l),
        });
        (count, shown.collect())
    }

    #[test]
    fn what_touches_by_its_sides_is_one_patch() {
        assert_eq!(labels("#### #### #### ####"), (1, "0".repeat(16)));
        assert_eq!(labels(".... .... .... ...."), (0, ".".repeat(16)));
        assert_eq!(
            labels("#.## #.#. #.## #..#"),
            (2, "0.110.1.0.110..1".into())
        );
        // Corners do not touch.
        assert_eq!(labels("#.#. .#.# #.#. .#.#").0, 8);
        // Through the last row only.
        assert_eq!(labels("#.# #.# ###"), (1, "0.00.0000".into()));
        assert_eq!(labels("#"), (1, "0".into()));
    }

    #[test]
    fn patches_go_on_where_they_share_most_of_the_side() {
        let join = |a: &[u8], b: &[u8]| {
            let mut found = Vec::new();
            joined(a, b, |a, b| found.push((a, b)));
            found
        };
        const NO: u8 = NO_PATCH;
        assert_eq!(join(&[0, 0, NO, 1], &[0, 0, NO, 1]), [(0, 0), (1, 1)]);
        // 0 touches 0 once and 1 twice: it continues in 1, and the other 0 in none.
        assert_eq!(join(&[0, 0, 0, 0], &[0, NO, 1, 1]), [(0, 1)]);
        assert_eq!(join(&[NO, 0, NO, 0], &[0, NO, 0, NO]), []);
    }
}
