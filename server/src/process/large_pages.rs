//! Large pages for large buffers.
//!
//! A solve of a million unknowns touches 850 MB for the first time: 200,000 pages of 4 kB, whose
//! faults take a seventh of its processor time, and whose addresses do not fit the processor's
//! table of them. Where the system lends pages of 2 MB to those who ask (`madvise`), buffers ask.
//! What a buffer does not touch it still does not get; a touched one may hold 2 MB more at each end.

use std::alloc::{GlobalAlloc, Layout, System};

/// Buffers from this size on ask: two large pages.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LARGE: usize = 4 << 20;
/// Every Linux page begins at a multiple of this.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const PAGE: usize = 4096;

/// The allocator of the system, whose large buffers ask for large pages.
#[derive(Clone, Copy, Debug)]
pub struct LargePages;

#[allow(unsafe_code)]
// SAFETY: all memory is the system allocator's, with the layout that the caller gave; advice
// changes no content and no address.
unsafe impl GlobalAlloc for LargePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise is the same.
        advised(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise is the same.
        advised(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, buffer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller's promise is the same.
        advised(unsafe { System.realloc(buffer, layout, size) }, size)
    }

    unsafe fn dealloc(&self, buffer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is the same.
        unsafe { System.dealloc(buffer, layout) }
    }
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[allow(unsafe_code)]
fn advised(buffer: *mut u8, size: usize) -> *mut u8 {
    if size >= LARGE && !buffer.is_null() {
        let ahead = buffer.addr() % PAGE;
        // SAFETY: the pages belong to the allocator; a system without large pages refuses, and
        // the buffer is as good.
        unsafe {
            libc::madvise(
                buffer.wrapping_sub(ahead).cast(),
                size + ahead,
                libc::MADV_HUGEPAGE,
            )
        };
    }
    buffer
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn advised(buffer: *mut u8, _size: usize) -> *mut u8 {
    buffer
}

#[cfg(test)]
#[allow(unsafe_code)]
mod tests {
    use super::*;

    #[test]
    fn buffers_of_every_size_keep_what_is_written_while_they_grow() {
        for size in [1, 4096, (4 << 20) - 1, 4 << 20, 9 << 20] {
            let layout = Layout::from_size_align(size, 64).expect("a size that fits");
            // SAFETY: the layout has a size, and what is read was written inside it.
            unsafe {
                let zeros = LargePages.alloc_zeroed(layout);
                assert_eq!((zeros.read(), zeros.add(size - 1).read()), (0, 0));
                zeros.add(size - 1).write(7);
                let grown = LargePages.realloc(zeros, layout, 3 * size);
                assert_eq!(grown.addr() % 64, 0);
                assert_eq!(grown.add(size - 1).read(), 7);
                grown.add(3 * size - 1).write(8);
                let layout = Layout::from_size_align(3 * size, 64).expect("a size that fits");
                LargePages.dealloc(grown, layout);
                let other = LargePages.alloc(layout);
                assert!(!other.is_null());
                LargePages.dealloc(other, layout);
            }
        }
    }
}
