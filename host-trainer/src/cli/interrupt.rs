//! What a command says when it is interrupted: whether the same command goes on where it was.

/// What a second run of a command does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Again {
    /// Goes on where the first was.
    Resumes,
    /// Begins anew; the first wrote nothing.
    BeginsAnew,
}

/// No signals here.
#[cfg(not(unix))]
pub fn announce(_: Again) {}

/// Says at SIGINT and SIGTERM what a second run does, then ends the process as without a handler.
#[cfg(unix)]
pub fn announce(again: Again) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;

    let text = match again {
        Again::Resumes => "stopped: what is finished is kept, and the same command goes on from there",
        Again::BeginsAnew => "stopped: nothing was written, and the same command begins anew",
    };
    // Without a handler the command ends all the same, in silence.
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else { return };
    std::thread::spawn(move || {
        for signal in &mut signals {
            eprintln!("\n{text}");
            let _ = emulate_default_handler(signal);
        }
    });
}
