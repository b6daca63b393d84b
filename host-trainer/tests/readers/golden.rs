//! Golden: values of the real recordings, taken with `head`, `tail` and `scipy.io.loadmat`.

use ballrace::recording::{LoadOptions, STANDARD_GRAVITY, load, reference_data};

const GOLDEN_130: (f64, f64) = (0.008527844311377245, -0.10274021956087824);
const GOLDEN_278: (f64, f64) = (0.0982838575667656, -0.06648850642927795);
const GOLDEN_QM: (f64, f64) = (7.45e-06, 0.00361505);
const GOLDEN_VIR: (f64, f64) = (2.5532241817066916, -0.88986481605249);
/// File, first and last sample in g, load in pounds.
const GOLDEN_MFPT: [(&str, f64, f64, f64); 4] = [
    ("InnerRaceFault_vload_1.mat", -0.1762558, -0.3933298, 0.0),
    ("InnerRaceFault_vload_3.mat", -3.603589, -1.264026, 100.0),
    ("OuterRaceFault_vload_1.mat", -0.06989686, 0.05329636, 25.0),
    ("OuterRaceFault_vload_4.mat", -0.6417344, -1.351225, 150.0),
];

/// First and last sample in g, to the rounding of the conversion.
fn assert_ends_g(samples: &[f64], (first, last): (f64, f64)) {
    assert_eq!(samples[0], first * STANDARD_GRAVITY);
    assert_eq!(samples[samples.len() - 1], last * STANDARD_GRAVITY);
}

#[test]
fn femto_separated_by_comma() {
    let Some(femto) = reference_data::folder("femto") else {
        return;
    };
    let loaded = load(&[femto.join("Bearing3_3")], &LoadOptions::default()).unwrap();
    assert_eq!(loaded.recordings.len(), 434);
    assert!(loaded.recordings.iter().all(|r| r.len() == 2560 && r.channels.len() == 2));
    let (first, last) = (&loaded.recordings[0], &loaded.recordings[433]);
    assert_eq!(first.name(), "acc_00001");
    assert_eq!(first.sample_rate_hz, 25_600.0);
    assert_eq!((first.shaft_hz, first.load_n), (Some(25.0), Some(5000.0)));
    // 8:27:33.21254
    assert_eq!(first.start_s, Some(30_453.212_54));
    assert_ends_g(&first.channel("horizontal").unwrap().samples, (-0.043, 0.328));
    assert_ends_g(&first.channel("vertical").unwrap().samples, (-0.084, -0.177));
    assert_eq!(last.name(), "acc_00434");
    // A recording every 10 s.
    let length = last.start_s.unwrap() - first.start_s.unwrap();
    assert!((length - 4330.0).abs() < 1.0, "{length}");
}

#[test]
fn femto_separated_by_semicolon() {
    let Some(femto) = reference_data::folder("femto") else {
        return;
    };
    let options =
        LoadOptions { channels: Some(vec!["vertical".into()]), recordings: Some(38..60), ..LoadOptions::default() };
    let loaded = load(&[femto.join("Bearing1_4")], &options).unwrap();
    assert_eq!(loaded.recordings.len(), 2);
    let only = load(&[femto.join("Bearing1_4/acc_00001.csv")], &LoadOptions::default()).unwrap();
    let first = &only.recordings[0];
    assert_eq!((first.shaft_hz, first.load_n), (Some(30.0), Some(4000.0)));
    assert_ends_g(&first.channel("horizontal").unwrap().samples, (0.065, 0.58));
    assert_ends_g(&first.channel("vertical").unwrap().samples, (-0.058, 0.265));
    assert_eq!(loaded.recordings[1].channels.len(), 1);
    assert_eq!(loaded.recordings[1].channels[0].name, "vertical");
    assert_eq!(loaded.recordings[1].name(), "acc_00040");
}

#[test]
fn cwru() {
    let Some(cwru) = reference_data::folder("cwru") else {
        return;
    };
    let read = |file: &str, variable: Option<&str>| {
        let options = LoadOptions {
            sample_rate_hz: Some(12_000.0),
            variable: variable.map(String::from),
            ..LoadOptions::default()
        };
        load(&[cwru.join(file)], &options).unwrap().recordings.remove(0)
    };
    let outer = read("130_at_6_0.mat", Some("X130_DE_time"));
    assert_eq!(outer.channels.len(), 1);
    assert_eq!(outer.len(), 121_991);
    assert_eq!(outer.shaft_hz, Some(1796.0 / 60.0));
    assert_ends_g(&outer.channels[0].samples, GOLDEN_130);

    // Without a variable all signals of the record, but not the index vector `i` of this file.
    let inner = read("278_0.mat", None);
    let names: Vec<&str> = inner.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["X278_DE_time", "X278_FE_time", "X278_BA_time"]);
    assert_eq!(inner.len(), 121_535);
    assert_ends_g(&inner.channels[2].samples, GOLDEN_278);
}

#[test]
fn mfpt() {
    let Some(mfpt) = reference_data::folder("mfpt") else {
        return;
    };
    for (file, first, last, pounds) in GOLDEN_MFPT {
        let loaded = load(&[mfpt.join(file)], &LoadOptions::default()).unwrap();
        let recording = &loaded.recordings[0];
        assert_eq!(recording.len(), 146_484, "{file}");
        assert_eq!(recording.sample_rate_hz, 48_828.0);
        assert_eq!(recording.shaft_hz, Some(25.0));
        assert!((recording.load_n.unwrap() - pounds * 4.448_221_6).abs() < 1e-3, "{file}");
        assert_ends_g(&recording.channel("bearing.gs").unwrap().samples, (first, last));
    }
}

#[test]
fn emps() {
    let Some(emps) = reference_data::folder("emps") else {
        return;
    };
    let read = |file: &str, channels: &[&str]| {
        let channels = Some(channels.iter().map(|c| (*c).into()).collect());
        let options = LoadOptions { channels, ..LoadOptions::default() };
        load(&[emps.join(file)], &options).unwrap().recordings.remove(0)
    };
    let first = read("DATA_EMPS.mat", &["qm"]);
    assert_eq!((first.len(), first.channels.len()), (24_841, 1));
    // The rate comes from `t`; positions are not converted.
    assert!((first.sample_rate_hz - 1000.0).abs() < 0.01, "{}", first.sample_rate_hz);
    assert_eq!(first.gaps, [0_usize; 0]);
    let samples = &first.channels[0].samples;
    assert_eq!((samples[0], samples[24_840]), GOLDEN_QM);

    let pulses = read("DATA_EMPS_PULSES.mat", &["vir", "pulses_N"]);
    let ends = |name: &str| {
        let samples = &pulses.channel(name).unwrap().samples;
        (samples[0], samples[24_840])
    };
    assert_eq!(ends("vir"), GOLDEN_VIR);
    assert_eq!(ends("pulses_N"), (0.0, 5.0));
}

#[test]
fn the_rig() {
    let Some(rig) = reference_data::folder("rig-reference") else {
        return;
    };
    let loaded = load(&[rig.join("rigA_0.csv")], &LoadOptions::default()).unwrap();
    let recording = &loaded.recordings[0];
    assert!((recording.sample_rate_hz - 25_600.0).abs() < 1e-6, "{}", recording.sample_rate_hz);
    assert_eq!(recording.channel("resonator-y").unwrap().name, "ay_m_s2");
    assert_eq!(recording.channel("ay_m_s2").unwrap().samples[0], -0.014_960_798_44);
    assert_eq!(recording.channel("fy_n").unwrap().samples[2], 336.683_418_5);

    let Some(concealed) = reference_data::folder("concealed") else {
        return;
    };
    let loaded = load(&[concealed.join("case05")], &LoadOptions::default()).unwrap();
    assert_eq!(loaded.recordings.len(), 4);
    let recording = &loaded.recordings[0];
    assert_eq!(recording.len(), 25_600);
    assert_eq!((recording.shaft_hz, recording.load_n), (Some(29.87), Some(1646.7)));
    assert_eq!(recording.channel("outer-x").unwrap().samples[0], -0.020_431_6);
    let turns: f64 = recording.channel("tacho").unwrap().samples.iter().sum();
    assert!((turns - 29.87).abs() <= 1.0, "{turns} turns in a second at 29.87 Hz");
}
