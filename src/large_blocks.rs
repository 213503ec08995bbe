//! The program's memory of planes, on Linux: in huge pages, where it leaves that to programs, and used again once it has
//! been mapped. To map fresh memory in pages of 4 kB takes a tenth of a command's processor time.
//!
//! What is freed is kept, and joined with what is kept beside it; a block is cut from the smallest range that has room for
//! it. Where none has, as much is given back to the system as is mapped anew: the program never has more memory than its
//! blocks took at one time.

use rustix::mm::{Advice, MapFlags, MremapFlags, ProtFlags};
use rustix::mm::{madvise, mmap_anonymous, mremap, munmap};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cmp::Reverse;
use std::ffi::c_void;
use std::ptr::null_mut;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Bytes from which on a block is mapped here; the system's allocator makes smaller ones.
const LARGE: usize = 1 << 18;
/// Bytes that a page has at least, to which mapped blocks are aligned, and at most, of which they have a multiple.
const ALIGNED: usize = 1 << 12;
const PAGE: usize = 1 << 16;
/// Bytes of a huge page, to which larger blocks are aligned.
const HUGE_PAGE: usize = 1 << 21;
/// Blocks are made up of huge pages alone where that adds at most one part in so many.
const PARTS_TO_ADD_ONE: usize = 16;
/// Most ranges of freed memory that are kept, and most bytes in them.
const MOST_KEPT: usize = 64;
const MOST_KEPT_BYTES: usize = 256 << 20;
/// Most bytes at the end of its memory that the system's allocator keeps.
#[cfg(target_env = "gnu")]
const MOST_KEPT_SMALL: i32 = 64 << 20;

/// The system's memory; large blocks come in huge pages, and are kept for others.
struct Blocks {
    kept: Mutex<Kept>,
}

#[global_allocator]
static BLOCKS: Blocks = Blocks::new();

/// A mapped range of bytes.
#[derive(Clone, Copy)]
struct Block {
    start: *mut c_void,
    size: usize,
}

#[expect(unsafe_code, reason = "whoever holds a block has it alone")]
// SAFETY: as given.
unsafe impl Send for Block {}

/// Freed ranges, the oldest first. None touches another.
struct Kept {
    ranges: [Block; MOST_KEPT],
    count: usize,
    bytes: usize,
}

impl Kept {
    fn remove(&mut self, index: usize) -> Block {
        let range = self.ranges[index];
        self.ranges.copy_within(index + 1..self.count, index);
        self.count -= 1;
        self.bytes -= range.size;
        range
    }

    /// A block of this size, of the smallest range with room for it; of equal ones that freed last.
    fn take(&mut self, size: usize) -> Option<Block> {
        let ranges = self.ranges[..self.count].iter().enumerate();
        let with_room = ranges.filter(|(_, range)| range.place_of(size).is_some());
        let (index, _) = with_room.min_by_key(|(index, range)| (range.size, Reverse(*index)))?;
        let range = self.remove(index);
        let block = range.place_of(size)?;
        let [before, after] = range.around(block);
        for rest in [before, after].into_iter().filter(|rest| rest.size > 0) {
            self.keep(rest);
        }
        Some(block)
    }

    /// Gives memory back to the system, the oldest first, to take `size` bytes from it without having more of it.
    fn make_room(&mut self, size: usize) {
        let enough = self.bytes.saturating_sub(size);
        while self.bytes > enough {
            let oldest = self.ranges[0];
            // What is left ends with a huge page.
            let left = oldest.size.saturating_sub(self.bytes - enough);
            let end = (oldest.start.addr() + left) / HUGE_PAGE * HUGE_PAGE;
            let left = end.saturating_sub(oldest.start.addr());
            if left == 0 {
                self.remove(0).unmap();
                continue;
            }
            let [left, rest] = oldest.cut(left);
            self.ranges[0] = left;
            self.bytes -= rest.size;
            rest.unmap();
        }
    }

    fn keep(&mut self, mut range: Block) {
        while let Some(index) = self.ranges[..self.count]
            .iter()
            .position(|kept| kept.end() == range.start || range.end() == kept.start)
        {
            let kept = self.remove(index);
            range = Block {
                start: kept.start.min(range.start),
                size: kept.size + range.size,
            };
        }
        if self.count == MOST_KEPT {
            self.remove(0).unmap();
        }
        self.ranges[self.count] = range;
        self.count += 1;
        self.bytes += range.size;
        self.make_room(self.bytes.saturating_sub(MOST_KEPT_BYTES));
    }
}

impl Block {
    fn end(self) -> *mut c_void {
        self.start.wrapping_byte_add(self.size)
    }

    /// Its first bytes, as many as given, and the rest.
    fn cut(self, size: usize) -> [Self; 2] {
        let rest = Self {
            start: self.start.wrapping_byte_add(size),
            size: self.size - size,
        };
        [Self { size, ..self }, rest]
    }

    /// The first place in it for a block of this size, if there is room: larger blocks begin at a huge page.
    fn place_of(self, size: usize) -> Option<Self> {
        let before = match size >= HUGE_PAGE {
            true => self.start.align_offset(HUGE_PAGE),
            false => 0,
        };
        let [_, from_there] = self.cut(before.min(self.size));
        (from_there.size >= size).then(|| from_there.cut(size)[0])
    }

    /// What is left of it before and after a block in it.
    fn around(self, block: Self) -> [Self; 2] {
        let [before, from_there] = self.cut(block.start.addr() - self.start.addr());
        [before, from_there.cut(block.size)[1]]
    }
}

#[expect(unsafe_code, reason = "memory is named by its address")]
impl Block {
    /// Fresh memory of `size` bytes, at least a huge page, which is zero.
    fn map(size: usize) -> Option<Self> {
        // Room to begin at a huge page.
        let mapped = size + HUGE_PAGE;
        let (access, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::PRIVATE);
        // SAFETY: fresh memory is nobody else's.
        let start = unsafe { mmap_anonymous(null_mut(), mapped, access, flags) }.ok()?;
        let all = Self {
            start,
            size: mapped,
        };
        let block = all.place_of(size)?;
        for rest in all.around(block).into_iter().filter(|rest| rest.size > 0) {
            rest.unmap();
        }
        // SAFETY: the range is the block. Where the advice is refused, nothing changes.
        let _ = unsafe { madvise(block.start, size, Advice::LinuxHugepage) };
        Some(block)
    }

    fn unmap(self) {
        // SAFETY: whoever holds a block has it alone.
        let _ = unsafe { munmap(self.start, self.size) };
    }
}

impl Blocks {
    const fn new() -> Self {
        Self {
            kept: Mutex::new(Kept {
                ranges: [Block {
                    start: null_mut(),
                    size: 0,
                }; MOST_KEPT],
                count: 0,
                bytes: 0,
            }),
        }
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A block of `size` bytes, and whether it is zero.
    fn block(&self, size: usize) -> Option<(Block, bool)> {
        let mut kept = self.kept();
        if let Some(block) = kept.take(size) {
            return Some((block, false));
        }
        // Smaller blocks share a huge page.
        let fresh = size.max(HUGE_PAGE);
        kept.make_room(fresh);
        drop(kept);
        let [block, rest] = Block::map(fresh)?.cut(size);
        if rest.size > 0 {
            self.kept().keep(rest);
        }
        Some((block, true))
    }
}

/// Has the system's allocator keep what is freed too, of which it would give back all but 128 kB.
#[cfg(target_env = "gnu")]
pub(crate) fn keep_small_blocks() {
    let settings = [
        (libc::M_MMAP_THRESHOLD, LARGE as i32),
        (libc::M_TRIM_THRESHOLD, MOST_KEPT_SMALL),
    ];
    for (setting, bytes) in settings {
        #[expect(unsafe_code, reason = "an interface of C")]
        // SAFETY: no other thread is there yet.
        let _ = unsafe { libc::mallopt(setting, bytes) };
    }
}

/// Bytes mapped for a block that is made here; `None` for others.
fn mapped(layout: Layout) -> Option<usize> {
    if layout.size() < LARGE || layout.align() > ALIGNED {
        return None;
    }
    let whole = layout.size().checked_next_multiple_of(HUGE_PAGE)?;
    match (whole - layout.size()) * PARTS_TO_ADD_ONE <= layout.size() {
        true => Some(whole),
        false => Some(layout.size().next_multiple_of(PAGE)),
    }
}

#[expect(unsafe_code, reason = "the interface of allocators")]
// SAFETY: what is not mapped here is the system's allocator's. A mapped block is in one place alone: given out, or kept.
unsafe impl GlobalAlloc for Blocks {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        match mapped(layout) {
            Some(size) => self
                .block(size)
                .map_or(null_mut(), |(block, _)| block.start.cast()),
            // SAFETY: as promised to this function, here and below.
            None => unsafe { System.alloc(layout) },
        }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let Some(size) = mapped(layout) else {
            // SAFETY: as above.
            return unsafe { System.alloc_zeroed(layout) };
        };
        let Some((Block { start, .. }, is_zero)) = self.block(size) else {
            return null_mut();
        };
        if !is_zero {
            // SAFETY: the block has as many bytes.
            unsafe { start.cast::<u8>().write_bytes(0, layout.size()) };
        }
        start.cast()
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        match mapped(layout) {
            Some(size) => self.kept().keep(Block {
                start: block.cast(),
                size,
            }),
            // SAFETY: as above.
            None => unsafe { System.dealloc(block, layout) },
        }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller has seen to it that such a layout is one.
        let wanted = unsafe { Layout::from_size_align_unchecked(size, layout.align()) };
        match (mapped(layout), mapped(wanted)) {
            // SAFETY: as above.
            (None, None) => return unsafe { System.realloc(block, layout, size) },
            (Some(before), Some(after)) if before == after => return block,
            (Some(before), Some(after)) => {
                self.kept().make_room(after.saturating_sub(before));
                // SAFETY: the block is its holder's alone, who will know the new address. It fails for a block that the
                // system mapped in parts.
                let moved = unsafe { mremap(block.cast(), before, after, MremapFlags::MAYMOVE) };
                if let Ok(moved) = moved {
                    return moved.cast();
                }
            }
            _ => {}
        }
        // SAFETY: blocks that do not overlap, each of at least so many bytes; the old one is no longer needed.
        unsafe {
            let other = self.alloc(wanted);
            if !other.is_null() {
                other.copy_from_nonoverlapping(block, size.min(layout.size()));
                self.dealloc(block, layout);
            }
            other
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sizes around those from which on blocks are mapped here, and where they are made up of huge pages.
    const SIZES: [usize; 7] = [
        1,
        LARGE - 1,
        LARGE,
        LARGE + 1,
        HUGE_PAGE + PAGE,
        4 * HUGE_PAGE - 1000,
        4 * HUGE_PAGE,
    ];

    #[test]
    fn memory_that_is_used_again_is_zero_where_that_is_asked() {
        for size in SIZES {
            for _ in 0..3 {
                let mut bytes = vec![0_u8; size];
                assert!(bytes.iter().all(|&byte| byte == 0), "{size}");
                bytes.fill(1);
            }
        }
    }

    #[test]
    fn a_freed_block_is_the_next_and_makes_room_for_others() {
        let blocks = Blocks::new();
        let (first, is_zero) = blocks.block(7 * HUGE_PAGE).unwrap();
        assert!(is_zero && first.start.addr() % HUGE_PAGE == 0);
        blocks.kept().keep(first);
        let (again, is_zero) = blocks.block(7 * HUGE_PAGE).unwrap();
        assert!(again.start == first.start && !is_zero);
        blocks.kept().keep(again);
        // A larger one takes its place in the system's books.
        let (other, is_zero) = blocks.block(8 * HUGE_PAGE).unwrap();
        assert!(is_zero && blocks.kept().count == 0 && blocks.kept().bytes == 0);
        other.unmap();
    }

    #[test]
    fn blocks_are_cut_from_the_smallest_range_and_joined_again() {
        let blocks = Blocks::new();
        let all = Block::map(10 * HUGE_PAGE).unwrap();
        blocks.kept().keep(all);
        let block = |size| {
            let (block, is_zero) = blocks.block(size).unwrap();
            assert!(!is_zero);
            (block.start.addr() - all.start.addr(), block)
        };
        // Pages, then huge pages, which begin at one, then pages before them.
        let (at_start, a) = block(PAGE);
        let (at_huge_page, b) = block(4 * HUGE_PAGE);
        let (between, c) = block(LARGE);
        let (after, d) = block(5 * HUGE_PAGE);
        assert_eq!([at_start, at_huge_page], [0, HUGE_PAGE]);
        assert_eq!([between, after], [PAGE, 5 * HUGE_PAGE]);
        assert_eq!(blocks.kept().bytes, HUGE_PAGE - PAGE - LARGE);
        for freed in [c, a, d, b] {
            blocks.kept().keep(freed);
        }
        assert_eq!(blocks.kept().count, 1);
        assert_eq!(blocks.kept().bytes, all.size);
        // As much is given back as is taken, in huge pages.
        blocks.kept().make_room(HUGE_PAGE + 1);
        assert_eq!(blocks.kept().bytes, 8 * HUGE_PAGE);
        let (start, left) = block(8 * HUGE_PAGE);
        assert_eq!(start, 0);
        left.unmap();
    }

    #[test]
    fn small_blocks_share_a_huge_page() {
        let blocks = Blocks::new();
        let (first, is_zero) = blocks.block(LARGE).unwrap();
        assert!(is_zero && first.size == LARGE);
        assert_eq!(blocks.kept().bytes, HUGE_PAGE - LARGE);
        let (second, _) = blocks.block(LARGE).unwrap();
        assert_eq!(second.start, first.end());
        for freed in [first, second] {
            blocks.kept().keep(freed);
        }
        assert_eq!(blocks.kept().bytes, HUGE_PAGE);
        blocks.kept().make_room(usize::MAX);
    }

    #[test]
    fn no_more_is_kept_than_allowed() {
        let blocks = Blocks::new();
        // Apart from each other: behind each is a page that is not mapped, too small for others.
        let apart = |size| {
            let [block, gap] = Block::map(size + PAGE).unwrap().cut(size);
            gap.unmap();
            block
        };
        for _ in 0..MOST_KEPT + 3 {
            blocks.kept().keep(apart(8 * HUGE_PAGE));
        }
        assert_eq!(blocks.kept().bytes, MOST_KEPT_BYTES);
        blocks.kept().make_room(usize::MAX);
        for _ in 0..MOST_KEPT + 3 {
            blocks.kept().keep(apart(HUGE_PAGE));
        }
        assert_eq!(blocks.kept().count, MOST_KEPT);
        blocks.kept().make_room(usize::MAX);
        assert_eq!(blocks.kept().count, 0);
    }

    #[test]
    fn contents_stay_as_blocks_grow_and_shrink() {
        for (from, to) in SIZES.iter().flat_map(|&a| SIZES.map(|b| (a, b))) {
            let mut bytes: Vec<u8> = (0..from).map(|i: usize| i as u8).collect();
            bytes.reserve_exact(to.saturating_sub(from));
            bytes.truncate(to);
            bytes.shrink_to_fit();
            bytes.resize(to, 0);
            let mut kept = bytes.iter().zip(0_usize..).take(from.min(to));
            assert!(kept.all(|(&byte, i)| byte == i as u8), "{from} to {to}");
        }
    }

    #[test]
    fn threads_share_no_block() {
        let write = |number: u8| {
            for size in SIZES.iter().cycle().take(50) {
                let bytes = vec![number; *size];
                std::thread::yield_now();
                assert!(bytes.iter().all(|&byte| byte == number));
            }
        };
        std::thread::scope(|scope| {
            (0..4).for_each(|number| _ = scope.spawn(move || write(number)));
        });
    }
}
