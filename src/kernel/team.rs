//! Threads that work on the layers of a net together, and stay awake between them.
//!
//! A net has a hundred layers of a fraction of a millisecond. Threads that sleep after each of them, or give their turn
//! away while they wait, come late to the next: on a busy machine by milliseconds, in which the others do the work alone.
//! So helpers look for work for a while before they sleep. And nobody waits for a helper that has not come: whoever leads
//! does all pieces that nobody else takes.
//!
//! Without a team, pieces are done on the current rayon pool.

use std::cell::{RefCell, UnsafeCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, TryLockError};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

use rayon::prelude::*;

/// How long a helper without work stays awake: longer than most layers that one thread does alone.
const AWAKE: Duration = Duration::from_millis(2);
/// How long the leader looks whether the helpers are done before it lets them have its processor.
const PATIENCE: Duration = Duration::from_micros(50);

/// One helper inside, in [`Shared::state`].
const ONE: u64 = 1;
/// Helpers may come in.
const OPEN: u64 = 1 << 16;
/// From one piece of work to the next.
const NEXT: u64 = 1 << 17;

thread_local! {
    static ROLE: RefCell<Role> = const { RefCell::new(Role::Free) };
}

/// What this thread is in a team.
#[derive(Clone)]
enum Role {
    Free,
    Leads(Arc<Shared>),
    Helps,
}

/// Threads that help whoever leads them; they end with the program.
#[derive(Debug)]
pub struct Team {
    shared: Arc<Shared>,
    turn: Mutex<()>,
}

/// What leader and helpers share.
struct Shared {
    /// Counts the pieces of work, says whether the present one is open, and how many helpers are inside.
    state: AtomicU64,
    /// The work; good while helpers are inside.
    work: UnsafeCell<Option<&'static (dyn Fn() + Sync)>>,
    /// Helpers that sleep, or are about to.
    asleep: AtomicUsize,
    /// Whether a helper panicked.
    failed: AtomicBool,
    helpers: OnceLock<Vec<Thread>>,
}

// SAFETY: `work` is written by the one leader while nobody is inside, and read by helpers that are.
unsafe impl Sync for Shared {}
// SAFETY: as above.
unsafe impl Send for Shared {}

impl std::fmt::Debug for Shared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} helpers", self.helpers.get().map_or(0, Vec::len))
    }
}

impl Team {
    /// A team of `threads`, the leader among them; of fewer where the system gives no more.
    pub fn new(threads: usize) -> Self {
        let shared = Arc::new(Shared {
            state: AtomicU64::new(0),
            work: UnsafeCell::new(None),
            asleep: AtomicUsize::new(0),
            failed: AtomicBool::new(false),
            helpers: OnceLock::new(),
        });
        let helper = |number: usize| {
            let shared = Arc::clone(&shared);
            let made = thread::Builder::new().name(format!("net-helper-{number}")).spawn(move || shared.help()).ok()?;
            Some(made.thread().clone())
        };
        let helpers = (1..threads).map_while(helper).collect();
        shared.helpers.get_or_init(|| helpers);
        Self { shared, turn: Mutex::default() }
    }

    /// Runs `job` with this thread as the leader: what it does `each` of, the team does. Where another thread leads
    /// already, the job runs without.
    pub fn lead<R>(&self, job: impl FnOnce() -> R) -> R {
        let _turn = match self.turn.try_lock() {
            Err(TryLockError::WouldBlock) => return job(),
            Ok(turn) => turn,
            Err(TryLockError::Poisoned(turn)) => PoisonError::into_inner(turn),
        };
        let _role = Restore(ROLE.replace(Role::Leads(Arc::clone(&self.shared))));
        job()
    }
}

/// Gives a thread its role back.
struct Restore(Role);

impl Drop for Restore {
    fn drop(&mut self) {
        ROLE.set(std::mem::replace(&mut self.0, Role::Free));
    }
}

impl Shared {
    /// Does `work` on this thread and on all helpers that come before this one is done.
    fn together(&self, work: &(dyn Fn() + Sync)) {
        // Work within work is done by whoever meets it.
        if self.state.load(Ordering::Relaxed) & OPEN != 0 {
            return work();
        }
        // SAFETY: helpers have this only while `Close` waits for them, which outlives neither `work` nor this call.
        let shared = unsafe { std::mem::transmute::<&(dyn Fn() + Sync), &'static (dyn Fn() + Sync)>(work) };
        // SAFETY: nobody is inside: the last one who led waited for that.
        unsafe { *self.work.get() = Some(shared) };
        self.failed.store(false, Ordering::Relaxed);
        let number = self.state.load(Ordering::Relaxed) / NEXT + 1;
        self.state.store(number * NEXT + OPEN, Ordering::SeqCst);
        if self.asleep.load(Ordering::SeqCst) > 0 {
            self.helpers.get().into_iter().flatten().for_each(Thread::unpark);
        }
        let close = Close(self);
        work();
        drop(close);
        assert!(!self.failed.load(Ordering::Relaxed), "a layer failed on another thread");
    }

    /// What a helper does all its life.
    fn help(&self) {
        ROLE.set(Role::Helps);
        let mut done = 0;
        loop {
            let state = self.next(done);
            // Only while it is open may anyone come in.
            if self.state.compare_exchange(state, state + ONE, Ordering::Acquire, Ordering::Relaxed).is_err() {
                continue;
            }
            done = state / NEXT;
            // SAFETY: this thread is inside, so the leader waits for it.
            let work = unsafe { *self.work.get() };
            if catch_unwind(AssertUnwindSafe(|| work.inspect(|work| work()))).is_err() {
                self.failed.store(true, Ordering::Relaxed);
            }
            self.state.fetch_sub(ONE, Ordering::Release);
        }
    }

    /// Waits for work that is open and another than the last one done.
    fn next(&self, done: u64) -> u64 {
        let is_new = |state: u64| state & OPEN != 0 && state / NEXT != done;
        loop {
            let since = Instant::now();
            while since.elapsed() < AWAKE {
                let state = self.state.load(Ordering::Relaxed);
                if is_new(state) {
                    return state;
                }
                (0..32).for_each(|_| std::hint::spin_loop());
            }
            self.asleep.fetch_add(1, Ordering::SeqCst);
            if !is_new(self.state.load(Ordering::SeqCst)) {
                thread::park();
            }
            self.asleep.fetch_sub(1, Ordering::SeqCst);
        }
    }
}

/// Lets nobody in any more, and waits for those who are inside; also where the leader panics.
struct Close<'a>(&'a Shared);

impl Drop for Close<'_> {
    fn drop(&mut self) {
        let state = &self.0.state;
        state.fetch_and(!OPEN, Ordering::Relaxed);
        let since = Instant::now();
        while state.load(Ordering::Acquire) & (OPEN - 1) != 0 {
            if since.elapsed() < PATIENCE {
                std::hint::spin_loop();
            } else {
                // A helper that was put aside by the system may want this very processor.
                thread::sleep(PATIENCE);
            }
        }
    }
}

/// Does the pieces of work 0 … `tasks` − 1, each once, on all threads.
pub(super) fn each(tasks: usize, f: impl Fn(usize) + Sync + Send) {
    each_with(tasks, || (), |(), task| f(task));
}

/// The same, with something that each thread makes for itself and has again at its next piece.
pub(super) fn each_with<S>(tasks: usize, init: impl Fn() -> S + Sync + Send, f: impl Fn(&mut S, usize) + Sync + Send) {
    let alone = || {
        let mut state = init();
        (0..tasks).for_each(|task| f(&mut state, task));
    };
    if tasks <= 1 {
        return alone();
    }
    match ROLE.with_borrow(Clone::clone) {
        Role::Helps => alone(),
        Role::Free => (0..tasks).into_par_iter().with_max_len(1).for_each_init(init, f),
        Role::Leads(team) => {
            let next = AtomicUsize::new(0);
            team.together(&|| {
                let mut state = None;
                loop {
                    let task = next.fetch_add(1, Ordering::Relaxed);
                    if task >= tasks {
                        break;
                    }
                    f(state.get_or_insert_with(&init), task);
                }
            });
        }
    }
}

/// Does something with each piece of `len` values, the last perhaps shorter; `f` gets its number.
pub(super) fn each_chunk<T: Send>(values: &mut [T], len: usize, f: impl Fn(usize, &mut [T]) + Sync + Send) {
    let (all, first) = (values.len(), First(values.as_mut_ptr()));
    each(all.div_ceil(len.max(1)), |task| {
        let start = task * len;
        // SAFETY: pieces are disjoint and lie in the slice, which is borrowed until all are done.
        let piece = unsafe { std::slice::from_raw_parts_mut(first.at(start), len.min(all - start)) };
        f(task, piece);
    });
}

/// The first of some values that threads write, each at places of its own.
struct First<T>(*mut T);

// SAFETY: whoever dereferences it answers for disjoint places.
unsafe impl<T: Send> Send for First<T> {}
// SAFETY: as above.
unsafe impl<T: Send> Sync for First<T> {}

impl<T> First<T> {
    fn at(&self, offset: usize) -> *mut T {
        self.0.wrapping_add(offset)
    }
}

#[cfg(test)]
mod tests {
    use std::panic::catch_unwind;

    use super::*;

    #[test]
    fn each_piece_is_done_once_however_many_help() {
        for threads in [1, 2, 5] {
            let team = Team::new(threads);
            for tasks in [0, 1, 2, 7, 1000] {
                let mut done = vec![0_u8; tasks];
                // Twice in a row, and without rest, so that late helpers meet the next work.
                team.lead(|| (0..2).for_each(|_| each_chunk(&mut done, 1, |_, piece| piece[0] += 1)));
                assert!(done.iter().all(|count| *count == 2), "{threads} threads, {tasks} pieces");
            }
        }
    }

    #[test]
    fn work_within_work_and_a_second_leader_get_done() {
        let team = Team::new(3);
        let count = AtomicUsize::new(0);
        let inner = || each(10, |_| _ = count.fetch_add(1, Ordering::Relaxed));
        team.lead(|| {
            each(4, |_| inner());
            team.lead(inner);
        });
        assert_eq!(count.into_inner(), 50);
    }

    #[test]
    fn a_panic_reaches_the_leader_and_the_team_works_on() {
        let team = Team::new(2);
        let failing = || team.lead(|| each(50, |task| assert!(task != 40)));
        assert!(catch_unwind(AssertUnwindSafe(failing)).is_err());
        let count = AtomicUsize::new(0);
        team.lead(|| each(50, |_| _ = count.fetch_add(1, Ordering::Relaxed)));
        assert_eq!(count.into_inner(), 50);
    }
}
