//! What work of its own process may take and do. What it needs it has already, or reads from files that lie there.

use std::io;
use std::time::Duration;

/// Limits of a process that works for another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    /// Memory, in bytes.
    pub(crate) memory: u64,
    /// Time of the processor in seconds, and on the clock: a thread that waits for one that broke uses no processor.
    pub(crate) secs: u64,
    /// Whether it can open no file and no connection, start no program and change no file (Linux).
    pub(crate) is_shut: bool,
}

impl Bounds {
    /// Sets all limits that this system has, for good.
    pub(crate) fn set(self) -> io::Result<()> {
        std::thread::Builder::new().name("clock".to_owned()).spawn(move || {
            std::thread::sleep(Duration::from_secs(self.secs));
            std::process::abort();
        })?;
        #[cfg(target_os = "linux")]
        linux::set(self)?;
        Ok(())
    }
}

#[cfg(target_os = "linux")]
mod linux {
    use std::collections::BTreeMap;
    use std::io;

    use rustix::process::{Resource, Rlimit, Signal, getrlimit, set_parent_process_death_signal, setrlimit};
    use seccompiler::{BpfProgram, SeccompAction, SeccompFilter, TargetArch, apply_filter_all_threads};

    use super::Bounds;

    pub(super) fn set(bounds: Bounds) -> io::Result<()> {
        // Who asked has gone: nobody wants the answer.
        set_parent_process_death_signal(Some(Signal::KILL))?;
        for (resource, most) in [
            (Resource::Data, bounds.memory),
            (Resource::Cpu, bounds.secs),
            (Resource::Fsize, 0),
            (Resource::Core, 0),
            (Resource::Nofile, 64),
        ] {
            // Nobody may raise what the system has set lower.
            let now = getrlimit(resource);
            let most = now.maximum.map_or(most, |hard| hard.min(most));
            setrlimit(resource, Rlimit { current: Some(most), maximum: Some(most) })?;
        }
        if bounds.is_shut { forbid() } else { Ok(()) }
    }

    /// Forbids to open files and connections, to start programs, and to touch other processes. What is not named here
    /// stays allowed: allocators and threads need more than can be listed for every C library.
    fn forbid() -> io::Result<()> {
        let Ok(arch) = TargetArch::try_from(std::env::consts::ARCH) else { return Ok(()) };
        let rules: BTreeMap<i64, _> = FORBIDDEN.iter().map(|call| (*call, Vec::new())).collect();
        let refuse = SeccompAction::Errno(libc::EPERM as u32);
        let filter = SeccompFilter::new(rules, SeccompAction::Allow, refuse, arch).map_err(io::Error::other)?;
        let program: BpfProgram = filter.try_into().map_err(io::Error::other)?;
        apply_filter_all_threads(&program).map_err(io::Error::other)
    }

    const FORBIDDEN: &[i64] = &[
        libc::SYS_openat,
        libc::SYS_openat2,
        libc::SYS_open_by_handle_at,
        libc::SYS_name_to_handle_at,
        libc::SYS_execve,
        libc::SYS_execveat,
        libc::SYS_socket,
        libc::SYS_socketpair,
        libc::SYS_connect,
        libc::SYS_bind,
        libc::SYS_listen,
        libc::SYS_accept,
        libc::SYS_accept4,
        libc::SYS_sendto,
        libc::SYS_sendmsg,
        libc::SYS_sendmmsg,
        libc::SYS_recvfrom,
        libc::SYS_recvmsg,
        libc::SYS_recvmmsg,
        libc::SYS_ptrace,
        libc::SYS_process_vm_readv,
        libc::SYS_process_vm_writev,
        libc::SYS_pidfd_open,
        libc::SYS_pidfd_getfd,
        libc::SYS_pidfd_send_signal,
        libc::SYS_kill,
        libc::SYS_unlinkat,
        libc::SYS_renameat2,
        libc::SYS_linkat,
        libc::SYS_symlinkat,
        libc::SYS_mkdirat,
        libc::SYS_mknodat,
        libc::SYS_fchmod,
        libc::SYS_fchmodat,
        libc::SYS_fchown,
        libc::SYS_fchownat,
        libc::SYS_truncate,
        libc::SYS_ftruncate,
        libc::SYS_utimensat,
        libc::SYS_setxattr,
        libc::SYS_mount,
        libc::SYS_umount2,
        libc::SYS_chroot,
        libc::SYS_chdir,
        libc::SYS_unshare,
        libc::SYS_setns,
        libc::SYS_bpf,
        libc::SYS_io_uring_setup,
        libc::SYS_io_uring_enter,
        libc::SYS_perf_event_open,
        libc::SYS_userfaultfd,
        libc::SYS_keyctl,
        libc::SYS_add_key,
        libc::SYS_shmget,
        libc::SYS_msgget,
        libc::SYS_setrlimit,
        libc::SYS_prlimit64,
        // The older names, which not all processors have.
        #[cfg(target_arch = "x86_64")]
        libc::SYS_open,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_creat,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_fork,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_vfork,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_unlink,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_rmdir,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_rename,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_renameat,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_link,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_symlink,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_mkdir,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_mknod,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_chmod,
        #[cfg(target_arch = "x86_64")]
        libc::SYS_chown,
    ];

    #[cfg(test)]
    mod tests {
        use super::*;

        /// In a thread of its own, and only for it: what is forbidden cannot be allowed again.
        #[test]
        fn a_decoder_opens_nothing_and_starts_nothing() {
            let tried = std::thread::Builder::new().name("decoder".to_owned()).spawn(|| {
                let rules: BTreeMap<i64, _> = FORBIDDEN.iter().map(|call| (*call, Vec::new())).collect();
                let arch = TargetArch::try_from(std::env::consts::ARCH).unwrap();
                let refuse = SeccompAction::Errno(libc::EPERM as u32);
                let program: BpfProgram =
                    SeccompFilter::new(rules, SeccompAction::Allow, refuse, arch).unwrap().try_into().unwrap();
                seccompiler::apply_filter(&program).unwrap();
                let file = std::fs::File::open("/etc/passwd").unwrap_err();
                let connection = std::net::TcpStream::connect("127.0.0.1:9").unwrap_err();
                let program = std::process::Command::new("/bin/true").status().unwrap_err();
                let memory = vec![1_u8; 1 << 20];
                ([file, connection, program].map(|error| error.raw_os_error()), memory.len())
            });
            assert_eq!(tried.unwrap().join().unwrap(), ([Some(libc::EPERM); 3], 1 << 20));
        }
    }
}
