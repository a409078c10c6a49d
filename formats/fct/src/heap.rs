//! When memory that is free goes back to the system.
//!
//! The C library of GNU maps large blocks one by one and unmaps them when they are freed; smaller ones come from its heap,
//! whose end goes back when enough of it is free.
//! With each large block freed it raises the size from which on it maps them, up to 32 MB.
//! What suits one program does not suit the other, and neither is well served by a size that grows; so each sets its own,
//! first of all in `main`.
//! Musl, macOS and Windows have no such rule, and there nothing is done.

/// Maps blocks of 1 MiB and more, so that they go back as soon as they are free: whole lists of a mesh that is worth a
/// thought, and hardly any of what is allocated again and again.
///
/// For builds: every stage allocates lists of many megabytes and frees those of the stage before.
/// From a heap the gaps between them stay in the process: 30 to 60 bytes a face of a million, a fifth of the peak.
pub fn map_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    set(&[(libc::M_MMAP_THRESHOLD, 1 << 20)]);
}

/// Keeps up to 256 MiB of what is free, and maps no block below 32 MiB, the most that there is.
///
/// For frames: a driver that draws on the CPU allocates some ten megabytes in each and frees them at its end.
/// Where they go back, a tenth of a frame is spent on fresh pages.
pub fn keep_free_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    set(&[(libc::M_MMAP_THRESHOLD, 32 << 20), (libc::M_TRIM_THRESHOLD, 256 << 20)]);
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[allow(unsafe_code, reason = "the allocator's settings are reached by a C function alone")]
fn set(settings: &[(libc::c_int, libc::c_int)]) {
    for &(name, value) in settings {
        // SAFETY: mallopt takes two integers and touches no memory of ours. It changes settings of the allocator under
        // the allocator's own lock; it must not race with another first use of malloc, and commands call this before
        // they start a second thread. A refusal, which is a return value of 0, leaves everything as it was.
        unsafe { libc::mallopt(name, value) };
    }
}
