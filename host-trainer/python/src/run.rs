//! Long work: other threads of Python run meanwhile, progress goes to a callback, Ctrl-C ends it.

use std::panic::resume_unwind;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread::scope;
use std::time::Duration;

use pyo3::prelude::*;

/// Time between looks for signals and progress.
const INTERVAL: Duration = Duration::from_millis(50);

/// Payload with which interrupted work unwinds.
struct Stopped;

/// Progress of work in another thread.
#[derive(Default)]
pub struct Progress {
    stopped: AtomicBool,
    news: Mutex<Option<(Option<f64>, String)>>,
}

impl Progress {
    /// Takes the share that is done, if known, and a text. Unwinds if the work is to end.
    pub fn report(&self, done: Option<f64>, text: &str) {
        if self.stopped.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Stopped));
        }
        if let Ok(mut news) = self.news.lock() {
            *news = Some((done, text.to_owned()));
        }
    }

    /// Looks for signals and passes news to the callback; what either raises.
    fn attend(&self, callback: Option<&Py<PyAny>>) -> PyResult<()> {
        let news = self.news.lock().ok().and_then(|mut news| news.take());
        Python::attach(|py| {
            py.check_signals()?;
            match (callback, news) {
                (Some(callback), Some(news)) => callback.call1(py, news).map(|_| ()),
                _ => Ok(()),
            }
        })
    }
}

/// Runs work in a thread of its own. `callback(done, text)` gets its progress, `done` from 0 to 1 or None.
///
/// # Errors
/// What a signal or the callback raises; the work then ends at its next report.
pub fn run<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    work: impl FnOnce(&Progress) -> T + Send,
) -> PyResult<T> {
    let progress = Progress::default();
    py.detach(|| {
        scope(|threads| {
            let (ended, end) = sync_channel::<()>(1);
            let progress = &progress;
            let worker = threads.spawn(move || {
                // Dropped at the end, by unwinding too.
                let _ended = ended;
                work(progress)
            });
            let mut raised = None;
            while end.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                if raised.is_none()
                    && let Err(error) = progress.attend(callback.as_ref())
                {
                    progress.stopped.store(true, Ordering::Relaxed);
                    raised = Some(error);
                }
            }
            match (worker.join(), raised) {
                (_, Some(error)) => Err(error),
                (Ok(made), None) => Ok(made),
                (Err(panic), None) => resume_unwind(panic),
            }
        })
    })
}
