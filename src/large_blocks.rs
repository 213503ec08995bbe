//! The program's memory of planes, on Linux: in huge pages, where it leaves that to programs, and used again once it has
//! been mapped. To map fresh memory in pages of 4 kB takes a tenth of a command's processor time.

use rustix::mm::{Advice, MapFlags, MremapFlags, ProtFlags};
use rustix::mm::{madvise, mmap_anonymous, mremap, munmap};
use std::alloc::{GlobalAlloc, Layout, System};
use std::ffi::c_void;
use std::ptr::null_mut;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Bytes from which on a block is mapped here; the system's allocator makes smaller ones.
const LARGE: usize = 1 << 20;
/// Bytes that a page has at least, to which mapped blocks are aligned, and at most, of which they have a multiple.
const ALIGNED: usize = 1 << 12;
const PAGE: usize = 1 << 16;
/// Bytes of a huge page, to which larger blocks are aligned.
const HUGE_PAGE: usize = 1 << 21;
/// Blocks are made up of huge pages alone where that adds at most one part in so many.
const PARTS_TO_ADD_ONE: usize = 16;
/// Most blocks, and most bytes of them, that are kept when they are freed.
const MOST_KEPT: usize = 64;
const MOST_KEPT_BYTES: usize = 256 << 20;
/// Most bytes at the end of its memory that the system's allocator keeps.
#[cfg(target_env = "gnu")]
const MOST_KEPT_SMALL: i32 = 64 << 20;

/// The system's memory; large blocks come in huge pages, and are kept for others of their size.
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

/// Freed blocks, the oldest first.
struct Kept {
    blocks: [Block; MOST_KEPT],
    count: usize,
    bytes: usize,
}

impl Kept {
    fn remove(&mut self, index: usize) -> Block {
        let block = self.blocks[index];
        self.blocks.copy_within(index + 1..self.count, index);
        self.count -= 1;
        self.bytes -= block.size;
        block
    }

    /// The block of this size that was freed last.
    fn take(&mut self, size: usize) -> Option<Block> {
        let index = self.blocks[..self.count]
            .iter()
            .rposition(|block| block.size == size)?;
        Some(self.remove(index))
    }

    /// Gives blocks back to the system, the oldest first, to take `size` bytes from it without having more of it.
    fn make_room(&mut self, size: usize) {
        let enough = self.bytes.saturating_sub(size);
        while self.bytes > enough {
            self.remove(0).unmap();
        }
    }

    fn keep(&mut self, block: Block) {
        if self.count == MOST_KEPT {
            self.remove(0).unmap();
        }
        self.blocks[self.count] = block;
        self.count += 1;
        self.bytes += block.size;
        while self.bytes > MOST_KEPT_BYTES {
            self.remove(0).unmap();
        }
    }
}

#[expect(unsafe_code, reason = "memory is named by its address")]
impl Block {
    /// Fresh memory of `size` bytes, which is zero.
    fn map(size: usize) -> Option<Self> {
        // Room to begin at a huge page.
        let spare = if size >= HUGE_PAGE { HUGE_PAGE } else { 0 };
        let (access, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::PRIVATE);
        // SAFETY: fresh memory is nobody else's.
        let all = unsafe { mmap_anonymous(null_mut(), size + spare, access, flags) }.ok()?;
        let before = match spare {
            0 => 0,
            _ => all.align_offset(HUGE_PAGE),
        };
        let start = all.wrapping_byte_add(before);
        let after = start.wrapping_byte_add(size);
        for (start, size) in [(all, before), (after, spare - before)] {
            if size > 0 {
                Self { start, size }.unmap();
            }
        }
        if size >= HUGE_PAGE {
            // SAFETY: the range is the block. Where the advice is refused, nothing changes.
            let _ = unsafe { madvise(start, size, Advice::LinuxHugepage) };
        }
        Some(Self { start, size })
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
                blocks: [Block {
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
        kept.make_room(size);
        drop(kept);
        Some((Block::map(size)?, true))
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
            (None, None) => unsafe { System.realloc(block, layout, size) },
            (Some(before), Some(after)) if before == after => block,
            (Some(before), Some(after)) => {
                // SAFETY: the block is its holder's alone, who will know the new address.
                let moved = unsafe { mremap(block.cast(), before, after, MremapFlags::MAYMOVE) };
                moved.map_or(null_mut(), |moved| moved.cast())
            }
            // SAFETY: blocks that do not overlap, each of at least so many bytes; the old one is no longer needed.
            _ => unsafe {
                let other = self.alloc(wanted);
                if !other.is_null() {
                    other.copy_from_nonoverlapping(block, size.min(layout.size()));
                    self.dealloc(block, layout);
                }
                other
            },
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
    fn a_freed_block_is_the_next_of_its_size_and_makes_room_for_others() {
        let blocks = Blocks::new();
        let (first, is_zero) = blocks.block(7 * HUGE_PAGE).unwrap();
        assert!(is_zero && first.start.addr() % HUGE_PAGE == 0);
        blocks.kept().keep(first);
        let (again, is_zero) = blocks.block(7 * HUGE_PAGE).unwrap();
        assert!(again.start == first.start && !is_zero);
        blocks.kept().keep(again);
        let (other, is_zero) = blocks.block(PAGE).unwrap();
        assert!(is_zero && blocks.kept().count == 0 && blocks.kept().bytes == 0);
        other.unmap();
    }

    #[test]
    fn no_more_is_kept_than_allowed() {
        let blocks = Blocks::new();
        for _ in 0..MOST_KEPT + 3 {
            let block = Block::map(8 * HUGE_PAGE).unwrap();
            blocks.kept().keep(block);
        }
        assert_eq!(blocks.kept().bytes, MOST_KEPT_BYTES);
        blocks.kept().make_room(usize::MAX);
        for _ in 0..MOST_KEPT + 3 {
            let block = Block::map(PAGE).unwrap();
            blocks.kept().keep(block);
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
