//! Cancellation of long work from another thread.
//!
//! Work runs with a [`Token`] in its thread and in the threads of the pool that [`Token::run`] makes for it. What takes long calls
//! [`check`] every few milliseconds; once the token is cancelled, the work unwinds from there. Without a token nothing happens:
//! the commands have none, a signal ends their process.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};

thread_local! {
    static TOKEN: RefCell<Option<Token>> = const { RefCell::new(None) };
}

/// Payload with which cancelled work unwinds.
struct Cancelled;

/// Wish to end some work, shared by its threads and by whoever may cancel it.
#[derive(Clone, Debug, Default)]
pub struct Token(Arc<AtomicBool>);

impl Token {
    /// Ends the work at its next check.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Runs work on a rayon pool of its own, of as many threads as usual; `None` if it was cancelled. A panic of the work goes on.
    ///
    /// # Errors
    /// Threads that the operating system refuses.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<Option<T>, ThreadPoolBuildError> {
        let token = self.clone();
        let start = move |_| TOKEN.set(Some(token.clone()));
        let pool = ThreadPoolBuilder::new().start_handler(start).build()?;
        match catch_unwind(AssertUnwindSafe(|| pool.install(work))) {
            Ok(made) => Ok(Some(made)),
            Err(payload) if is_cancelled(&*payload) => Ok(None),
            Err(payload) => resume_unwind(payload),
        }
    }
}

fn is_cancelled(payload: &(dyn Any + Send)) -> bool {
    payload.is::<Cancelled>()
}

/// Ends the work of this thread, by unwinding, if its token was cancelled.
pub fn check() {
    let cancelled = TOKEN.with_borrow(|token| token.as_ref().is_some_and(|token| token.0.load(Ordering::Relaxed)));
    if cancelled {
        resume_unwind(Box::new(Cancelled));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;

    use rayon::prelude::*;

    use super::*;

    #[test]
    fn invariant_cancelled_work_ends_in_all_threads_and_other_work_goes_on() {
        const ITEMS: u64 = 64;
        let token = Token::default();
        let (steps, steps_after, is_cancelled) = (AtomicU64::new(0), AtomicU64::new(0), AtomicBool::new(false));
        let made = token.run(|| {
            (0..ITEMS).into_par_iter().for_each(|_| {
                for _ in 0..60_000 {
                    if is_cancelled.load(Ordering::Acquire) {
                        steps_after.fetch_add(1, Ordering::Relaxed);
                    }
                    if steps.fetch_add(1, Ordering::Relaxed) == 1000 {
                        token.cancel();
                        is_cancelled.store(true, Ordering::Release);
                    }
                    check();
                }
            });
        });
        assert_eq!(made.unwrap(), None);
        // Each item ends at its first check.
        assert!(steps_after.into_inner() <= ITEMS);
        // No token: nothing is cancelled here.
        check();
        assert_eq!(
            Token::default().run(|| (0..100u64).into_par_iter().inspect(|_| check()).sum::<u64>()).unwrap(),
            Some(4950)
        );
    }
}
