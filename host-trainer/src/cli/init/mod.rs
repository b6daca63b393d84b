//! Command `ballrace init`: `rig.toml` and `recordings.toml` to begin with.

mod bearing;
mod manifest;

use std::path::{Path, PathBuf};

use self::bearing::Chosen;
use self::manifest::Found;
use super::input::parse_unit;
use super::{Failure, line, write};
use crate::recording::manifest::FILE_NAME;
use crate::recording::{LoadOptions, Recording, load};
use crate::rig::Rig;
use crate::rig::config::RigKind;

const RIG: &str = "rig.toml";

/// Begin a rig.toml and a recordings.toml from recordings and a bearing's designation
///
/// recordings.toml states what the files show: sample rate, channels, and the shaft's speed by a
/// channel `tacho`, by the file, or by the signal around --shaft-hz. rig.toml states the bearing and
/// leaves the structure unknown, which is enough for `diagnose` to name a fault of a race.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Example:\n  ballrace init --from data --bearing 6205 --shaft-hz 29.5\n  ballrace diagnose --rig rig.toml --recordings recordings.toml --out diagnosis"
)]
pub struct Args {
    /// Kind of rig: bearing-5dof or sdof
    #[arg(long, default_value = "bearing-5dof")]
    kind: String,
    /// Recordings: a folder or a file [default: none; a bearing's recordings.toml is then an example]
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
    /// Bearing: a designation such as 6205, or BALLS,BALL_MM,PITCH_MM[,CONTACT_DEGREES]
    #[arg(long, value_name = "BEARING")]
    bearing: Option<String>,
    /// Nominal shaft speed of recordings that state none
    #[arg(long, value_name = "HZ")]
    shaft_hz: Option<f64>,
    /// Sample rate, if the files do not state it
    #[arg(long, value_name = "HZ")]
    sample_rate: Option<f64>,
    /// Unit of the accelerations: g or m/s^2
    #[arg(long)]
    unit: Option<String>,
    /// Variable of .mat files, such as X130_DE_time
    #[arg(long)]
    variable: Option<String>,
    /// Folder to write to
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// Replace files that exist
    #[arg(long)]
    force: bool,
}

/// Runs `init`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let kind = RigKind::parse(&args.kind).ok_or_else(|| Failure::option("kind", &args.kind, "bearing-5dof or sdof"))?;
    if let Some(hz) = args.shaft_hz.filter(|hz| !(hz.is_finite() && *hz > 0.0)) {
        return Err(Failure::option("shaft-hz", hz, "a positive number of Hz"));
    }
    let chosen = args.bearing.as_deref().map(Chosen::parse).transpose()?;
    let rig = match (kind, &chosen) {
        (RigKind::Sdof, None) => Some(include_str!("sdof.toml").to_owned()),
        (RigKind::Sdof, Some(_)) => return Err(Failure::option("bearing", "--kind sdof", "a rig with a bearing")),
        (RigKind::Bearing5Dof, chosen) => chosen.as_ref().map(Chosen::rig),
    };
    let mut files = Vec::new();
    if let Some(text) = rig {
        Rig::parse(&text, Path::new(RIG)).map_err(Failure::input)?;
        files.push((args.out.join(RIG), text));
    }
    let mut notes = Vec::new();
    match &args.from {
        None if kind == RigKind::Sdof => {}
        None => files.push((args.out.join(FILE_NAME), include_str!("recordings.toml").to_owned())),
        Some(from) => {
            let recordings = read(args, from)?;
            let geometry = chosen.as_ref().map(|chosen| chosen.geometry);
            let nominal_hz = args.shaft_hz.filter(|_| kind == RigKind::Bearing5Dof);
            let found: Vec<Found> = recordings.iter().map(|r| Found::new(r, nominal_hz, geometry)).collect();
            notes.extend(found.iter().map(Found::sentence));
            if let Some(manifest) = described_by(from) {
                notes.push(format!("{} is kept: it describes these recordings already", manifest.display()));
            } else {
                let text = manifest::text(&found, kind, args.unit.as_deref(), &args.out).map_err(Failure::other)?;
                files.push((args.out.join(FILE_NAME), text));
            }
        }
    }
    if kind == RigKind::Bearing5Dof && chosen.is_none() {
        notes.push(format!("no {RIG}: --bearing names the bearing, without which no fault of a race can be named"));
    }
    if let Some((path, _)) = files.iter().find(|(path, _)| path.exists() && !args.force) {
        let found = path.display();
        return Err(Failure::Input(format!(
            "{found}: found a file, expected none; nothing is written (--force replaces it)"
        )));
    }
    std::fs::create_dir_all(&args.out)
        .map_err(|e| Failure::option("out", format!("{} ({e})", args.out.display()), "a folder"))?;
    for note in notes {
        line(note)?;
    }
    for (path, text) in &files {
        write(path, text.as_bytes())?;
        line(format_args!("wrote {}", path.display()))?;
    }
    Ok(())
}

fn read(args: &Args, from: &Path) -> Result<Vec<Recording>, Failure> {
    let options = LoadOptions {
        sample_rate_hz: args.sample_rate,
        unit: args.unit.as_deref().map(parse_unit).transpose()?,
        variable: args.variable.clone(),
        ..LoadOptions::default()
    };
    Ok(load(&[from.to_owned()], &options).map_err(Failure::input)?.recordings)
}

/// Manifest that describes the recordings already.
fn described_by(from: &Path) -> Option<PathBuf> {
    let inside = from.join(FILE_NAME);
    let is_manifest = from.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    if inside.is_file() { Some(inside) } else { is_manifest.then(|| from.to_owned()) }
}
