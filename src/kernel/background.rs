//! Lets the window go first.

/// Lowers the priority of this thread and of those that it starts from now on, so that the window stays quick while
/// every core computes. Does nothing where the system has no such call.
pub fn step_back() {
    #[cfg(target_os = "linux")]
    // SAFETY: no pointers; 0 means the calling thread. A refusal does no harm.
    unsafe {
        libc::setpriority(libc::PRIO_PROCESS, 0, 5);
    }
}
