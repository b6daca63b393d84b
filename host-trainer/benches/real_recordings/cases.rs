//! What is diagnosed: recordings with their manifests, the rig, and what the source says of the machine.

use std::{
    fs,
    path::{Path, PathBuf},
};

use ballrace::recording::reference_data;

use super::Result;

/// One row.
pub struct Case {
    pub name: String,
    /// The rig's text.
    pub rig: &'static str,
    /// Manifest of the healthy recordings.
    pub baseline: Option<String>,
    /// Manifest of the recordings to diagnose.
    pub recordings: String,
    pub source_says: &'static str,
}

/// Record, file and fault of CWRU's, all at the drive end but the last.
const CWRU: [(&str, &str, &str); 8] = [
    ("130", "130_at_6_0.mat", "outer race"),
    ("144", "144_at_3_0.mat", "outer race"),
    ("105", "105_0.mat", "inner race"),
    ("209", "209_0.mat", "inner race"),
    ("118", "118_0.mat", "ball"),
    ("185", "185_0.mat", "ball"),
    ("222", "222_0.mat", "ball"),
    ("278", "278_0.mat", "inner race of the other bearing"),
];
/// Unit, the motor's speed without load, and a guess of the load on the bearing, which is not stated.
const CWRU_STATED: &str = "unit = \"g\"\nshaft_hz = 29.93\nload_n = 300.0\n";
const CWRU_HEALTHY: &str =
    "variable = \"X097_DE_time\"\nsample_rate_hz = 48000.0\nresample_hz = 12000.0 # as the faulty ones have\n";

/// Race and load in the file's name.
const MFPT: [(&str, u8, &str); 4] =
    [("Outer", 1, "outer race"), ("Outer", 4, "outer race"), ("Inner", 1, "inner race"), ("Inner", 3, "inner race")];
/// The nominal speed, and a guess of the load, which is stated in other terms.
const MFPT_STATED: &str =
    "variable = \"bearing.gs\"\nunit = \"g\"\nsample_rate_hz = 48828.0\nshaft_hz = 25.0\nload_n = 400.0\n";

const FEMTO: &str = "Bearing3_3";
const FEMTO_STATED: &str = "unit = \"g\"\nsample_rate_hz = 25600.0\nshaft_hz = 25.0\nload_n = 5000.0\n";
/// Recordings at the beginning of the life that count as healthy, and at its end that are diagnosed.
const FEMTO_FIRST: usize = 24;
const FEMTO_LAST: usize = 12;

/// Rows of the wanted sets, as far as their recordings are there.
pub fn all(wanted: impl Fn(&str) -> bool) -> Result<Vec<Case>> {
    let mut out = Vec::new();
    for (set, of) in
        [("cwru", cwru as fn(&Path) -> Result<Vec<Case>>), ("mfpt", mfpt), ("femto", femto), ("emps", emps)]
    {
        let Some(folder) = wanted(set).then(|| reference_data::folder(set)).flatten() else { continue };
        // A manifest's files are looked for beside it, and these lie elsewhere.
        out.extend(of(&fs::canonicalize(folder)?)?);
    }
    Ok(out)
}

fn cwru(folder: &Path) -> Result<Vec<Case>> {
    let baseline = entry(&folder.join("97_Normal_0.mat"), &[CWRU_STATED, CWRU_HEALTHY].concat());
    let case = |(record, file, source_says): (&str, &str, _)| Case {
        name: format!("CWRU {record}, baseline 97"),
        rig: include_str!("cwru.toml"),
        baseline: Some(baseline.clone()),
        recordings: entry(
            &folder.join(file),
            &format!("{CWRU_STATED}variable = \"X{record}_DE_time\"\nsample_rate_hz = 12000.0\n"),
        ),
        source_says,
    };
    Ok(CWRU.map(case).into())
}

fn mfpt(folder: &Path) -> Result<Vec<Case>> {
    let case = |(race, load, source_says): (&str, u8, _)| Case {
        name: format!("MFPT {} {load}, no baseline", race.to_lowercase()),
        rig: include_str!("mfpt.toml"),
        baseline: None,
        recordings: entry(&folder.join(format!("{race}RaceFault_vload_{load}.mat")), MFPT_STATED),
        source_says,
    };
    Ok(MFPT.map(case).into())
}

fn femto(folder: &Path) -> Result<Vec<Case>> {
    let mut files = Vec::new();
    for file in fs::read_dir(folder.join(FEMTO))? {
        files.push(file?.path());
    }
    files.retain(|f| f.extension().is_some_and(|e| e == "csv"));
    files.sort();
    if files.len() < FEMTO_FIRST + FEMTO_LAST {
        return Err(format!("{FEMTO}: found {} recordings, expected all of its life", files.len()).into());
    }
    let manifest = |files: &[PathBuf]| files.iter().map(|f| entry(f, FEMTO_STATED)).collect();
    Ok(vec![Case {
        name: format!("FEMTO {FEMTO}, last {FEMTO_LAST} against the first {FEMTO_FIRST}"),
        rig: include_str!("femto.toml"),
        baseline: Some(manifest(&files[..FEMTO_FIRST])),
        recordings: manifest(&files[files.len() - FEMTO_LAST..]),
        source_says: "nothing: never inspected",
    }])
}

fn emps(folder: &Path) -> Result<Vec<Case>> {
    Ok(vec![Case {
        name: "EMPS (rig without friction)".into(),
        rig: include_str!("emps.toml"),
        baseline: None,
        recordings: entry(&folder.join("DATA_EMPS.mat"), "channels = { vir = \"u\", qm = \"q\" }\n"),
        source_says: "203.5 N s/m, 20.39 N",
    }])
}

/// A recording's lines in a manifest.
fn entry(file: &Path, stated: &str) -> String {
    format!("[[recording]]\nfile = {}\n{stated}", toml::Value::from(file.display().to_string()))
}
