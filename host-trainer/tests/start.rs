//! The first hour: `init`, `completions` and `man` as a user meets them, and the catalogue of bearings.

use std::f64::consts::PI;
use std::path::Path;

use ballrace::Rig;
use ballrace::recording::load_all;
use ballrace::recording::manifest::Manifest;
use ballrace::signal::bearings::{CATALOGUE, CatalogueBearing};

mod support;
use support::{done, refused, text};

/// Multiples of the shaft's speed that others published: BPFO and BPFI.
const PUBLISHED: [(&str, f64, f64); 5] = [
    // Case Western Reserve University Bearing Data Center, "Bearing information".
    ("6203", 3.0530, 4.9469),
    ("6205", 3.5848, 5.4152),
    // Huang, Baddour 2018.
    ("ER16K", 3.572, 5.43),
    // XJTU-SY: 107.91 Hz and 172.09 Hz at 35 Hz.
    ("UER204", 3.0831, 4.9169),
    // IMS: 236.4 Hz and 296.9 Hz at 2000 rpm.
    ("ZA2115", 7.092, 8.907),
];

#[test]
fn literature_bearings_of_the_catalogue_have_their_published_frequencies() {
    for (designation, bpfo, bpfi) in PUBLISHED {
        let orders = CatalogueBearing::find(designation).expect(designation).geometry().orders();
        let close = |got: f64, published: f64| (got - published).abs() < 1e-3 * published;
        assert!(close(orders.bpfo, bpfo) && close(orders.bpfi, bpfi), "{designation}: {orders:?}");
    }
}

#[test]
fn invariant_bearings_of_the_catalogue_can_be_built() {
    for bearing in CATALOGUE {
        let CatalogueBearing { designation, balls, ball_mm, pitch_mm, contact_angle_deg, .. } = *bearing;
        assert!(balls as f64 * ball_mm < PI * pitch_mm, "{designation}: the balls do not fit on their circle");
        assert!((0.0..45.0).contains(&contact_angle_deg) && !bearing.source.is_empty(), "{designation}");
        if let Some([bore, outside]) = bearing.bore_and_outside_mm {
            let fits = bore < pitch_mm - ball_mm && pitch_mm + ball_mm < outside;
            assert!(fits, "{designation}: {ball_mm} on {pitch_mm} between {bore} and {outside}");
        }
        assert_eq!(CatalogueBearing::find(designation), Some(bearing));
    }
}

#[test]
fn a_designation_is_found_among_maker_and_suffixes() {
    for written in ["6205", "SKF 6205-2RS1/C3", "6205ZZ", "fag 6205.c3"] {
        assert_eq!(CatalogueBearing::find(written).map(|b| b.designation), Some("6205"), "{written}");
    }
    assert_eq!(CatalogueBearing::find("ER-16K").map(|b| b.designation), Some("ER16K"));
    for other in ["62052", "16205", "7205", "", "9,7.94,39.04"] {
        assert_eq!(CatalogueBearing::find(other), None, "{other}");
    }
}

/// 0.2 s of a wave at 10 kHz, with 25 pulses a second of a tachometer in the second file.
fn recordings(folder: &Path) {
    std::fs::create_dir_all(folder).expect("a folder");
    for (name, header, tacho) in [("r1.csv", "time_s,left,right", false), ("r2.csv", "time_s,ay,tacho", true)] {
        let rows = (0..2000).map(|k| {
            let second = if tacho { i32::from(k % 400 == 0) } else { k % 7 };
            format!("{},{:?},{second}\n", f64::from(k) / 10_000.0, (0.3 * f64::from(k)).sin())
        });
        std::fs::write(folder.join(name), format!("{header}\n{}", rows.collect::<String>())).expect("a file");
    }
}

#[test]
fn init_writes_what_the_recordings_show_and_the_readers_read_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    recordings(&folder.join("data"));
    let told =
        done(folder, &["init", "--from", "data", "--bearing", "SKF 6205-2Z", "--shaft-hz", "24", "--out", "made"]);
    assert!(told.contains("r2: ay, tacho, 0.200 s at 10000 Hz, shaft 25.0000 Hz (mean of channel tacho)"), "{told}");
    let rig = Rig::read(&folder.join("made/rig.toml")).expect("a rig");
    let expected = CatalogueBearing::find("6205").expect("6205").geometry();
    let ballrace::rig::Machine::Bearing(bearing) = &rig.model else { panic!("a bearing rig") };
    let got = bearing.bearing.geometry();
    assert_eq!(got.balls, 9);
    assert!((got.ball_diameter_m - expected.ball_diameter_m).abs() < 1e-7);
    assert!((got.pitch_diameter_m - expected.pitch_diameter_m).abs() < 1e-7);
    let manifest = folder.join("made/recordings.toml");
    let read = load_all(&manifest).expect("recordings");
    assert_eq!(read.iter().map(|r| r.sample_rate_hz).collect::<Vec<_>>(), [10_000.0; 2]);
    // The first states a nominal speed that 0.2 s cannot check, the second one by its tachometer.
    assert_eq!(read[0].shaft_hz, Some(24.0));
    assert!((read[1].shaft_hz.expect("a speed") - 25.0).abs() < 1e-9);
    assert_eq!(read[0].channel("resonator-y").map(|c| c.name.as_str()), Some("left"));
    assert_eq!(read[1].channel("resonator-y").map(|c| c.name.as_str()), Some("ay"));
}

#[test]
fn init_finds_its_recordings_from_a_folder_beside_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let inside = folder.path().join("work");
    recordings(&inside.join("data"));
    done(&inside, &["init", "--from", "data", "--bearing", "6205", "--shaft-hz", "24", "--out", "../made"]);
    assert_eq!(load_all(&folder.path().join("made/recordings.toml")).expect("recordings").len(), 2);
}

#[test]
fn init_never_replaces_a_file_without_force_and_writes_both_or_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::write(folder.join("recordings.toml"), "mine").expect("a file");
    let error = refused(folder, &["init", "--bearing", "6205"]);
    assert!(error.contains("recordings.toml: found a file, expected none"), "{error}");
    assert!(!folder.join("rig.toml").exists());
    assert_eq!(std::fs::read_to_string(folder.join("recordings.toml")).expect("kept"), "mine");
    done(folder, &["init", "--bearing", "9,7.94,39.04", "--force"]);
    assert_eq!(Manifest::read(&folder.join("recordings.toml")).expect("a manifest").entries.len(), 4);
    // A manifest that describes the recordings is never replaced.
    recordings(&folder.join("data"));
    let own = "[[recording]]\nfile = \"r2.csv\"\nunit = \"g\"\n";
    std::fs::write(folder.join("data/recordings.toml"), own).expect("a file");
    let told = done(folder, &["init", "--from", "data", "--bearing", "6203", "--out", "data", "--force"]);
    assert!(told.contains("is kept"), "{told}");
    assert_eq!(std::fs::read_to_string(folder.join("data/recordings.toml")).expect("kept"), own);
}

#[test]
fn init_says_what_it_lacks() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let error = refused(folder, &["init", "--bearing", "6399"]);
    assert!(error.contains("--bearing: found `6399`, expected one of 6203, 6204"), "{error}");
    // Forty balls of 8 mm do not fit on a circle of 39 mm.
    for bad in ["40,8,39", "9,7.94", "8.5,7.94,39", "9,-1,39"] {
        assert!(refused(folder, &["init", "--bearing", bad]).contains("--bearing: found"), "{bad}");
    }
    assert!(refused(folder, &["init", "--kind", "gearbox"]).contains("expected bearing-5dof or sdof"));
    let told = done(folder, &["init"]);
    assert!(told.contains("no rig.toml: --bearing names the bearing"), "{told}");
    assert!(!folder.join("rig.toml").exists());
    done(folder, &["init", "--kind", "sdof"]);
    assert!(!Rig::read(&folder.join("rig.toml")).expect("a rig").unknown.is_empty());
}

#[test]
fn completions_and_manual_pages_know_every_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for shell in ["bash", "zsh", "fish"] {
        let script = done(folder, &["completions", shell]);
        assert!(script.contains("diagnose") && script.contains("completions"), "{shell}");
    }
    done(folder, &["man", "--out", "man1"]);
    let page = text(&std::fs::read(folder.join("man1/ballrace-diagnose.1")).expect("a page"));
    assert!(page.contains("rig.toml") && page.contains("ballrace diagnose"), "{page}");
    let top = text(&std::fs::read(folder.join("man1/ballrace.1")).expect("a page"));
    for entry in std::fs::read_dir(folder.join("man1")).expect("a folder") {
        let name = entry.expect("an entry").file_name().to_string_lossy().replace("ballrace-", "").replace(".1", "");
        assert!(top.contains(&name), "{name}");
    }
}
