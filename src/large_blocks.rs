//! The program's memory of planes, on Linux: in huge pages, where the system leaves that to programs. To map it in pages of
//! 4 kB takes a tenth of a command's processor time.

use rustix::mm::{Advice, MapFlags, MremapFlags, ProtFlags};
use rustix::mm::{madvise, mmap_anonymous, mremap, munmap};
use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr::null_mut;

/// Bytes of a huge page. Blocks from there on are mapped here, and begin at one; the system's allocator makes smaller ones.
const HUGE_PAGE: usize = 1 << 21;
/// Bytes that a page has at least, to which mapped blocks stay aligned, and at most, of which they have a multiple.
const ALIGNED: usize = 1 << 12;
const PAGE: usize = 1 << 16;
/// Blocks are made up of huge pages alone where that adds at most one part in so many.
const PARTS_TO_ADD_ONE: usize = 16;
/// Most bytes at the end of its memory that the system's allocator keeps.
#[cfg(target_env = "gnu")]
const MOST_KEPT: i32 = 64 << 20;

/// The system's memory, with large blocks in huge pages.
struct Blocks;

#[global_allocator]
static BLOCKS: Blocks = Blocks;

/// Has the system's allocator keep what is freed, of which it would give back all but 128 kB.
#[cfg(target_env = "gnu")]
pub(crate) fn keep_small_blocks() {
    let settings = [
        (libc::M_MMAP_THRESHOLD, HUGE_PAGE as i32),
        (libc::M_TRIM_THRESHOLD, MOST_KEPT),
    ];
    for (setting, bytes) in settings {
        #[expect(unsafe_code, reason = "an interface of C")]
        // SAFETY: no other thread is there yet.
        let _ = unsafe { libc::mallopt(setting, bytes) };
    }
}

/// Bytes mapped for a block that is made here; `None` for others.
fn mapped(layout: Layout) -> Option<usize> {
    if layout.size() < HUGE_PAGE || layout.align() > ALIGNED {
        return None;
    }
    let whole = layout.size().checked_next_multiple_of(HUGE_PAGE)?;
    match (whole - layout.size()) * PARTS_TO_ADD_ONE <= layout.size() {
        true => Some(whole),
        false => Some(layout.size().next_multiple_of(PAGE)),
    }
}

/// Fresh memory of `size` bytes, which is zero; null if there is none.
#[expect(unsafe_code, reason = "memory is named by its address")]
fn map(size: usize) -> *mut u8 {
    let (access, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::PRIVATE);
    // SAFETY: fresh memory is nobody else's; with room to begin at a huge page, what lies around the block is not used.
    // Where advice is refused, or nothing is left to unmap, nothing changes.
    unsafe {
        let Ok(all) = mmap_anonymous(null_mut(), size + HUGE_PAGE, access, flags) else {
            return null_mut();
        };
        let before = all.align_offset(HUGE_PAGE);
        let start = all.wrapping_byte_add(before);
        let _ = munmap(all, before);
        let _ = munmap(start.wrapping_byte_add(size), HUGE_PAGE - before);
        let _ = madvise(start, size, Advice::LinuxHugepage);
        start.cast()
    }
}

#[expect(unsafe_code, reason = "the interface of allocators")]
// SAFETY: what is not mapped here is the system's allocator's, by its layout alone.
unsafe impl GlobalAlloc for Blocks {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as promised to this function, here and below.
        mapped(layout).map_or_else(|| unsafe { System.alloc(layout) }, map)
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        mapped(layout).map_or_else(|| unsafe { System.alloc_zeroed(layout) }, map)
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as above; a mapped block is its holder's alone.
        unsafe {
            match mapped(layout) {
                Some(size) => _ = munmap(block.cast(), size),
                None => System.dealloc(block, layout),
            }
        }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above; the caller has seen to it that such a layout is one, and knows the new address alone. A copy is
        // of two blocks that do not overlap.
        unsafe {
            let wanted = Layout::from_size_align_unchecked(size, layout.align());
            match (mapped(layout), mapped(wanted)) {
                (None, None) => System.realloc(block, layout, size),
                (Some(before), Some(after)) => {
                    let moved = mremap(block.cast(), before, after, MremapFlags::MAYMOVE);
                    moved.map_or(null_mut(), |moved| moved.cast())
                }
                _ => {
                    let other = self.alloc(wanted);
                    if !other.is_null() {
                        other.copy_from_nonoverlapping(block, size.min(layout.size()));
                        self.dealloc(block, layout);
                    }
                    other
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sizes around those from which on blocks are mapped here, and where they are made up of huge pages.
    const SIZES: [usize; 6] = [
        1,
        HUGE_PAGE - 1,
        HUGE_PAGE,
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
    fn large_blocks_begin_at_a_huge_page() {
        for size in SIZES.into_iter().filter(|&size| size >= HUGE_PAGE) {
            let blocks = [(); 3].map(|()| vec![1_u8; size]);
            let starts = blocks.each_ref().map(|block| block.as_ptr().addr());
            assert_eq!(starts.map(|start| start % HUGE_PAGE), [0; 3], "{size}");
        }
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
