//! Large blocks of memory go back to the system as soon as they are free.
//!
//! Every stage of a build allocates lists of many megabytes and frees those of the stage before.
//! The C library of GNU maps large blocks one by one, and unmaps them when they are freed; but with each one freed it
//! raises the size from which on it does so, up to 32 MB.
//! Lists below that come from its heap afterwards, where the gaps between them stay in the process: 30 to 60 bytes a face
//! of a million, a fifth of the peak.
//! Musl, macOS and Windows have no such rule.

/// Blocks of this many bytes and more are mapped: whole lists of a mesh that is worth a thought, and hardly any of what is
/// allocated again and again.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const MAPPED_FROM: i32 = 1 << 20;

/// Holds the size from which on blocks are mapped where it is. To be called first of all in `main`.
pub(crate) fn map_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    #[allow(unsafe_code, reason = "the allocator's settings are reached by a C function alone")]
    // SAFETY: mallopt takes two integers and touches no memory of ours. It changes settings of the allocator under the
    // allocator's own lock; it must not race with another first use of malloc, and no second thread has been started. A
    // refusal, which is a return value of 0, leaves everything as it was.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, MAPPED_FROM);
    }
}
