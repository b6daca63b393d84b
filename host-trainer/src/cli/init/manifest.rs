//! What recordings show, and the `recordings.toml` that says so.

use std::fmt::Write;
use std::io;
use std::path::{Path, PathBuf};

use crate::recording::Recording;
use crate::rig::config::RigKind;
use crate::signal::kinematics::Geometry;
use crate::signal::order::ShaftAngle;
use crate::signal::speed::{SpeedSearch, estimate};

/// Channels that are no accelerations.
const NO_ACCELERATION: [&str; 5] = ["tacho", "u", "q", "qd", "qdd"];
/// Names and locations under which commands for a bearing find their channels.
const FOUND_BY_COMMANDS: [&str; 6] = ["ax", "outer-x", "horizontal", "ay", "resonator-y", "vertical"];

/// What a recording shows.
pub struct Found<'a> {
    recording: &'a Recording,
    speed: Speed,
}

/// Shaft speed with its source, in words.
struct Speed {
    shaft_hz: Option<f64>,
    std_hz: Option<f64>,
    source: String,
}

impl Speed {
    fn new(recording: &Recording, nominal_hz: Option<f64>, geometry: Option<Geometry>) -> Self {
        let rate = recording.sample_rate_hz;
        let tacho = recording.channels.iter().find(|channel| channel.name == "tacho");
        let mut source = String::new();
        match tacho.map(|tacho| ShaftAngle::from_tacho(&tacho.samples, rate)) {
            Some(Ok(angle)) => {
                return Self { shaft_hz: Some(angle.mean_hz()), std_hz: None, source: "mean of channel tacho".into() };
            }
            Some(Err(error)) => source = format!("channel tacho is not used: {error}; "),
            None => {}
        }
        if let Some(hz) = recording.shaft_hz {
            return Self { shaft_hz: Some(hz), std_hz: None, source: source + "as the file states" };
        }
        let Some(nominal_hz) = nominal_hz else {
            return Self { shaft_hz: None, std_hz: None, source: source + "unknown: state it, or give --shaft-hz" };
        };
        let signal = recording.channels.iter().find(|c| !NO_ACCELERATION.contains(&c.name.as_str()));
        let search = SpeedSearch::around(nominal_hz, geometry);
        match signal.map(|signal| estimate(&signal.samples, rate, &search)) {
            Some(Ok(found)) => Self {
                shaft_hz: Some(found.shaft_hz),
                std_hz: Some(found.standard_error_hz),
                source: format!("{source}by {} lines of the signal around {nominal_hz} Hz", found.lines.len()),
            },
            Some(Err(why)) => {
                let source = format!("{source}nominal, not checked: {why}");
                Self { shaft_hz: Some(nominal_hz), std_hz: None, source }
            }
            None => Self { shaft_hz: Some(nominal_hz), std_hz: None, source: source + "nominal, not checked" },
        }
    }
}

impl<'a> Found<'a> {
    /// What a recording shows; the speed is sought around a nominal one where nothing states it.
    pub fn new(recording: &'a Recording, nominal_hz: Option<f64>, geometry: Option<Geometry>) -> Self {
        Self { recording, speed: Speed::new(recording, nominal_hz, geometry) }
    }

    /// A line for the terminal.
    pub fn sentence(&self) -> String {
        let recording = self.recording;
        let speed = match self.speed.shaft_hz {
            Some(hz) => format!("shaft {hz:.4} Hz ({})", self.speed.source),
            None => format!("shaft speed {}", self.speed.source),
        };
        format!(
            "{}: {}, {:.3} s at {} Hz, {speed}",
            recording.name(),
            self.channels(),
            recording.duration_s(),
            rate_hz(recording)
        )
    }

    fn channels(&self) -> String {
        self.recording.channels.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// Channel to take as the vertical one, where several accelerations have names that no command knows.
    fn vertical(&self) -> Option<&str> {
        let known = |c: &crate::recording::Channel| {
            let names = [Some(c.name.as_str()), c.location.as_deref()];
            names.into_iter().flatten().any(|name| FOUND_BY_COMMANDS.contains(&name))
        };
        let all = &self.recording.channels;
        let mut accelerations = all.iter().filter(|c| !NO_ACCELERATION.contains(&c.name.as_str()));
        let first = accelerations.next()?;
        (accelerations.next().is_some() && !all.iter().any(known)).then_some(first.name.as_str())
    }

    fn entry(&self, kind: RigKind, manifest: &Path) -> io::Result<String> {
        let file = relative(&self.recording.source.path, manifest)?;
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let mut out = format!("\n[[recording]]\nfile = {}\n", quoted(&file.to_string_lossy()));
        let _ = writeln!(out, "# channels: {}; {:.3} s", self.channels(), self.recording.duration_s());
        if let Some(variable) = &self.recording.source.variable {
            let _ = writeln!(out, "variable = {}", quoted(variable));
        }
        if kind == RigKind::Sdof {
            return Ok(out);
        }
        let _ = match self.speed.shaft_hz {
            Some(hz) => writeln!(out, "shaft_hz = {hz:?}  # {}", self.speed.source),
            None => writeln!(out, "# shaft_hz = 25.0  # {}", self.speed.source),
        };
        if let Some(std_hz) = self.speed.std_hz {
            let _ = writeln!(out, "shaft_hz_std = {std_hz:?}");
        }
        if let Some(load_n) = self.recording.load_n {
            let _ = writeln!(out, "load_n = {load_n:?}");
        }
        if let Some(name) = self.vertical() {
            let _ = writeln!(out, "# Taken as the vertical channel; name another if the bearing's sensor is another.");
            let _ = writeln!(out, "channels = {{ {} = \"resonator-y\" }}", quoted(name));
        }
        Ok(out)
    }
}

/// Text of the manifest in a folder.
///
/// # Errors
/// A folder or a file whose absolute path the operating system does not tell.
pub fn text(found: &[Found], kind: RigKind, unit: Option<&str>, folder: &Path) -> io::Result<String> {
    let mut out =
        String::from("# The recordings, as `ballrace init` found them. `docs/formats.md` describes every key.\n");
    let rates: Vec<f64> = found.iter().map(|f| rate_hz(f.recording)).collect();
    let common = rates.first().copied().filter(|first| rates.iter().all(|rate| rate == first));
    out += "[defaults]\n";
    if let Some(rate) = common {
        let _ = writeln!(out, "sample_rate_hz = {rate:?}");
    }
    out += &match unit {
        Some(unit) => format!("unit = \"{unit}\"\n"),
        None => {
            "# unit = \"g\"  # of accelerations; as long as it is not stated: the format's own, else m/s^2\n".into()
        }
    };
    if kind == RigKind::Bearing5Dof {
        out += "# load_n = 1000.0  # radial load, N, if known\n";
    }
    for recording in found {
        out += &recording.entry(kind, folder)?;
        if common.is_none() {
            let _ = writeln!(out, "sample_rate_hz = {:?}", rate_hz(recording.recording));
        }
    }
    Ok(out)
}

/// Sample rate, Hz, without the digits that come from the rounding of stored times.
fn rate_hz(recording: &Recording) -> f64 {
    format!("{:.8e}", recording.sample_rate_hz).parse().unwrap_or(recording.sample_rate_hz)
}

/// Path of a file as seen from a folder, which need not exist.
fn relative(file: &Path, folder: &Path) -> io::Result<PathBuf> {
    let name = file.file_name().unwrap_or_default();
    let (file, folder) = (real(file.parent().unwrap_or(Path::new("")))?.join(name), real(folder)?);
    let shared = file.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(shared).map(|_| std::path::Component::ParentDir);
    Ok(up.chain(file.components().skip(shared)).collect())
}

/// Absolute path of a folder without links and `..`; of one that does not exist, as far as it does.
fn real(folder: &Path) -> io::Result<PathBuf> {
    if folder.as_os_str().is_empty() {
        return Path::new(".").canonicalize();
    }
    match (folder.canonicalize(), folder.parent(), folder.file_name()) {
        (Err(_), Some(parent), Some(name)) => Ok(real(parent)?.join(name)),
        (found, ..) => found,
    }
}
