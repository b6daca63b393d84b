//! Long work: other threads of Python run meanwhile, progress goes to a callback or a bar, Ctrl-C ends it.

use std::panic::resume_unwind;
use std::sync::Mutex;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread::scope;
use std::time::Duration;

use ballrace::stats::cancel::{Token, check};
use pyo3::exceptions::{PyKeyboardInterrupt, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyBool;

use crate::error::other;

/// Time between looks for signals and progress.
const INTERVAL: Duration = Duration::from_millis(50);
/// Looks after which a bar shows the time that has passed, without news too.
const LOOKS_PER_REFRESH: usize = 10;

/// Share that is done, if known, and the step in words.
type News = (Option<f64>, String);

/// Progress of work in another thread.
#[derive(Default)]
pub struct Progress {
    news: Mutex<Option<News>>,
}

impl Progress {
    /// Takes the share that is done, if known, and a text. Unwinds if the work is to end.
    pub fn report(&self, done: Option<f64>, text: &str) {
        check();
        if let Ok(mut news) = self.news.lock() {
            *news = Some((done, text.to_owned()));
        }
    }

    fn take(&self) -> Option<News> {
        self.news.lock().ok().and_then(|mut news| news.take())
    }
}

/// Receiver of the progress: what a caller gave as `progress`.
struct Listener {
    call: Py<PyAny>,
    /// Whether the call is a bar, which is refreshed without news and closed at the end.
    is_bar: bool,
    last: Option<News>,
    looks: usize,
}

impl Listener {
    /// Listener of `None` or `False` (nobody), `True` (a bar of tqdm), or a callable.
    fn new(given: Option<Bound<'_, PyAny>>) -> PyResult<Option<Self>> {
        let Some(given) = given else { return Ok(None) };
        let (call, is_bar) = match given.cast::<PyBool>() {
            Ok(wanted) if !wanted.is_true() => return Ok(None),
            Ok(_) => (given.py().import("ballrace._progress")?.getattr("Bar")?.call0()?, true),
            Err(_) if given.is_callable() => (given, false),
            Err(_) => {
                let found = given.get_type().name()?;
                return Err(PyTypeError::new_err(format!("progress: found {found}, expected True or a callable")));
            }
        };
        Ok(Some(Self { call: call.unbind(), is_bar, last: None, looks: 0 }))
    }

    fn tell(&mut self, py: Python<'_>, news: Option<News>) -> PyResult<()> {
        self.looks += 1;
        let repeats = self.is_bar && self.looks.is_multiple_of(LOOKS_PER_REFRESH);
        if news.is_some() && self.is_bar {
            self.last.clone_from(&news);
        }
        match news.or_else(|| self.last.clone().filter(|_| repeats)) {
            Some(news) => self.call.call1(py, news).map(|_| ()),
            None => Ok(()),
        }
    }

    /// Closes a bar.
    fn close(&self, py: Python<'_>, is_done: bool) -> PyResult<()> {
        if self.is_bar { self.call.call_method1(py, "close", (is_done,)).map(|_| ()) } else { Ok(()) }
    }
}

/// Runs work in threads of its own. `progress` is None, True (a bar of tqdm) or a callable of `done`, from 0 to 1 or None, and
/// a text.
///
/// # Errors
/// What a signal or the callable raises; the work ends within milliseconds, at its next check.
pub fn run<T: Send>(
    py: Python<'_>,
    progress: Option<Bound<'_, PyAny>>,
    work: impl FnOnce(&Progress) -> T + Send,
) -> PyResult<T> {
    let mut listener = Listener::new(progress)?;
    let (progress, token) = (Progress::default(), Token::default());
    let made = py.detach(|| {
        scope(|threads| {
            let (ended, end) = sync_channel::<()>(1);
            let (progress, token) = (&progress, &token);
            let worker = threads.spawn(move || {
                // Dropped at the end, by unwinding too.
                let _ended = ended;
                token.run(|| work(progress))
            });
            let mut raised = None;
            while end.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                if raised.is_some() {
                    continue;
                }
                let attended = Python::attach(|py| {
                    py.check_signals()?;
                    listener.as_mut().map_or(Ok(()), |listener| listener.tell(py, progress.take()))
                });
                if let Err(error) = attended {
                    token.cancel();
                    raised = Some(error);
                }
            }
            match (worker.join(), raised) {
                (_, Some(error)) => Err(error),
                (Ok(Ok(Some(made))), None) => Ok(made),
                // Only an error cancels.
                (Ok(Ok(None)), None) => Err(PyKeyboardInterrupt::new_err(())),
                (Ok(Err(error)), None) => Err(other(error)),
                (Err(panic), None) => resume_unwind(panic),
            }
        })
    });
    if let Some(mut listener) = listener {
        if made.is_ok() {
            listener.tell(py, progress.take())?;
        }
        listener.close(py, made.is_ok())?;
    }
    made
}
