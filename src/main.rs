//! The `relievo` command.

fn main() {
    std::process::exit(relievo::cli::run());
}

/// Planes in huge pages, where Linux leaves that to programs: to map fresh memory in pages of 4 kB takes a tenth of a
/// command's processor time.
#[cfg(target_os = "linux")]
mod memory {
    use rustix::mm::{Advice, madvise};
    use std::alloc::{GlobalAlloc, Layout, System};
    use std::ffi::c_void;

    /// Bytes of a huge page, and their alignment.
    const PAGE: usize = 1 << 21;

    /// The system's memory, with advice on blocks that hold huge pages.
    struct InHugePages;

    #[global_allocator]
    static MEMORY: InHugePages = InHugePages;

    #[expect(unsafe_code, reason = "the interface of allocators")]
    // SAFETY: all is the system's allocator, and advice changes neither contents nor addresses.
    unsafe impl GlobalAlloc for InHugePages {
        unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
            // SAFETY: as promised to this function, here and below.
            advised(unsafe { System.alloc(layout) }, layout.size())
        }

        unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
            // SAFETY: as above.
            advised(unsafe { System.alloc_zeroed(layout) }, layout.size())
        }

        unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
            // SAFETY: as above.
            advised(unsafe { System.realloc(block, layout, size) }, size)
        }

        unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
            // SAFETY: as above.
            unsafe { System.dealloc(block, layout) }
        }
    }

    /// `block` of this many bytes, of which whole huge pages are to be mapped at once.
    fn advised(block: *mut u8, size: usize) -> *mut u8 {
        let before = block.align_offset(PAGE);
        let whole = size.saturating_sub(before) / PAGE * PAGE;
        if !block.is_null() && whole > 0 {
            let start: *mut c_void = block.wrapping_add(before).cast();
            #[expect(unsafe_code, reason = "memory is named by its address")]
            // SAFETY: the range lies in the block. Where the advice is refused, nothing changes.
            let _ = unsafe { madvise(start, whole, Advice::LinuxHugepage) };
        }
        block
    }
}
