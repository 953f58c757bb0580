//! Panics of other people's code on damaged data, caught without a word on stderr: the caller has an error to give.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether a panic of this thread is expected and will be told as an error.
    static EXPECTED: Cell<bool> = const { Cell::new(false) };
}

/// Runs something on this thread that may panic; none if it does. Panics anywhere else are reported as ever.
pub(crate) fn caught<T>(run: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let report = take_hook();
        set_hook(Box::new(move |panic| {
            // One that ends the program, because it cannot be caught, is told in any case.
            let is_last = panic.payload_as_str().is_some_and(|text| text.contains("cannot unwind"));
            if is_last || !EXPECTED.get() {
                report(panic);
            }
        }));
    });
    let before = EXPECTED.replace(true);
    // What was half done is dropped with the panic: no caller hands in what outlives it.
    let answer = catch_unwind(AssertUnwindSafe(run));
    EXPECTED.set(before);
    answer.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_expected_panic_is_silent() {
        assert_eq!(caught(|| 3), Some(3));
        assert_eq!(caught(|| -> i32 { panic!("on damaged data") }), None);
        assert!(!EXPECTED.get(), "the next panic of this thread is reported");
        assert_eq!(caught(|| caught(|| -> i32 { panic!("within") }).is_none() && EXPECTED.get()), Some(true));
    }
}
