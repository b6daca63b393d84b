use crate::rig::effect::EffectKind;
use std::collections::BTreeMap;

use super::table::{Summary, confusion, markdown};
use super::*;
use crate::diagnose::result::{Diagnosis, Location, SCHEMA};
use crate::evaluate::cases::case_spec::Severity;
use crate::evaluate::cases::{HiddenEffect, Truth};

fn config(kinds: &[&str], effects: &[&str], every: usize) -> Config {
    let strings = |of: &[&str]| of.iter().map(|s| String::from(*s)).collect();
    Config {
        seed: 0,
        rounds: 1,
        simulator: Simulator::Shared,
        seconds: 0.4,
        kinds: strings(kinds),
        severities: strings(&["severe"]),
        effects: strings(effects),
        every,
    }
}

/// Short form of the whole evaluation: a control, and effects that nobody should miss.
#[test]
fn short_form_names_what_is_severe_and_is_quiet_on_a_control() {
    let folder = tempfile::tempdir().unwrap();
    let run = |config: &Config| evaluate(config, folder.path(), 1, &|_, _, _| ());
    let severe = config(&["single"], &["unbalance", "sensor-bias", "outer-race-defect"], 1);
    let mut scores = run(&severe).unwrap();
    scores.extend(run(&config(&["control"], &[], 20)).unwrap());
    assert_eq!(scores.len(), 4);
    for score in &scores {
        assert!(score.right, "{}: {:?} called {:?} {}", score.case, score.truth.causes, score.said, score.verdict);
    }
    // Finished cases are not diagnosed again.
    let ran = |score: &Score| folder.path().join("diagnoses").join(&score.case).join("run.json");
    let before = std::fs::metadata(ran(&scores[0])).unwrap().modified().unwrap();
    assert_eq!(run(&severe).unwrap(), scores[..3]);
    assert_eq!(std::fs::metadata(ran(&scores[0])).unwrap().modified().unwrap(), before);
    // Another evaluation's folder is left alone.
    let refused = run(&Config { seed: 1, ..severe }).unwrap_err();
    assert!(matches!(refused, EvaluateError::Another { .. }), "{refused}");
}

#[test]
fn no_case_at_all_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let refused = evaluate(&config(&["control"], &["unbalance"], 1), folder.path(), 1, &|_, _, _| ()).unwrap_err();
    assert!(matches!(refused, EvaluateError::Nothing), "{refused}");
}

/// Every name that `--effect` lists has a case; effects that only a fit takes, such as a random force, are none.
#[test]
fn effects_that_are_listed_have_cases() {
    for simulator in [Simulator::Shared, Simulator::Exact] {
        let names = Config::effect_names(simulator);
        assert!(names.contains(&"unbalance") && !names.contains(&"random-force"));
        assert!(names.iter().all(|name| !Config { simulator, ..config(&[], &[name], 1) }.specs().is_empty()));
    }
}

fn truth(causes: &[&str]) -> Truth {
    let effect = |name: &&str| HiddenEffect {
        name: (*name).into(),
        numbers: BTreeMap::from([("force_n".into(), 10.0)]),
        ..HiddenEffect::default()
    };
    let named = causes.iter().filter(|c| **c != "unexplained");
    let effects = named.map(effect).collect();
    let outside = causes.contains(&"unexplained").then(|| "echo".into());
    Truth { causes: causes.iter().map(|c| (*c).into()).collect(), accept: Vec::new(), effects, outside, change: 0.1 }
}

fn said(verdict: &str, causes: &[&str], interval: [f64; 2]) -> Diagnosis {
    let cause = |name: &&str| {
        serde_json::json!({ "name": name, "probability": 0.9, "parameters": { "force_n": 10.5 },
            "interval95": { "force_n": interval }, "evidence": "", "equation": "" })
    };
    let causes: Vec<_> = causes.iter().map(cause).collect();
    let fit = serde_json::json!({ "metric": "", "held_out": "", "before": 2.0, "after": 1.0, "noise_floor": 1.0,
        "p_value": 0.0 });
    let nowhere = serde_json::to_value(Location::default()).unwrap();
    let document = serde_json::json!({ "schema": SCHEMA, "verdict": verdict, "causes": causes, "rejected": [],
        "location": nowhere, "fit": fit });
    serde_json::from_value(document).unwrap()
}

fn scored(hidden: Hidden, causes: &[&str], said: &Diagnosis) -> Score {
    let spec = CaseSpec { hidden, loud: false, tachometer: false, guessed: false };
    let ran = Ran { seconds: 1.0, error: None };
    let outcome = Outcome { said: Some(said), distance: Some([9.0, 8.0]), ran: &ran };
    Score::new("case000".into(), &spec, truth(causes), &outcome)
}

#[test]
fn a_score_tells_right_from_first_right_from_wrong() {
    let single = |name| Hidden::Effects(vec![(name, Severity::Plain)]);
    let misalignment = single(EffectKind::Misalignment);
    let one = scored(misalignment.clone(), &["misalignment"], &said("mismatch", &["misalignment"], [9.0, 11.0]));
    assert!(one.right && one.first_right && one.parameters[0].held == Some(true));
    let two = said("mismatch", &["misalignment", "shock"], [10.2, 11.0]);
    let two = scored(misalignment.clone(), &["misalignment"], &two);
    assert!(!two.right && two.first_right && two.parameters[0].held == Some(false));
    let wrong = scored(misalignment, &["misalignment"], &said("mismatch", &["shock"], [9.0, 11.0]));
    assert!(!wrong.right && !wrong.first_right && wrong.parameters.is_empty());
    let alarm = scored(Hidden::Nothing, &[], &said("mismatch", &["shock"], [9.0, 11.0]));
    let quiet = scored(Hidden::Nothing, &[], &said("no-mismatch", &[], [9.0, 11.0]));
    assert!(!alarm.right && quiet.right);
    let outside = Hidden::Outside(crate::evaluate::cases::outside::Outside::Echo);
    let honest = scored(outside.clone(), &["unexplained"], &said("unexplained", &[], [9.0, 11.0]));
    let bluff = scored(outside, &["unexplained"], &said("mismatch", &["shock"], [9.0, 11.0]));
    assert!(honest.right && !bluff.right);
    let both = Hidden::Effects(vec![(EffectKind::Misalignment, Severity::Plain), (EffectKind::Shock, Severity::Plain)]);
    let half = scored(both.clone(), &["misalignment", "shock"], &said("mismatch", &["shock"], [9.0, 11.0]));
    let whole = said("mismatch", &["shock", "misalignment"], [9.0, 11.0]);
    let whole = scored(both, &["misalignment", "shock"], &whole);
    assert!(!half.right && half.first_right && whole.right);

    let all = [one, two, wrong, alarm, quiet, honest, bluff, half, whole];
    let summary = Summary::from_scores(&all);
    assert_eq!((summary.first_right.of, summary.first_right.all), (2, 3));
    assert_eq!((summary.only_right.of, summary.quiet.of, summary.honest.of, summary.both.of), (1, 1, 1, 1));
    assert_eq!((summary.improved.of, summary.improved.all), (7, 7));
    assert!(markdown(&all, 100).contains("| misalignment | – | 2/3 | – | misalignment + shock (case000, plain)"));
    assert_eq!((summary.nothing_beside.of, summary.nothing_beside.all), (3, 4));
    assert_eq!((summary.sure_and_wrong.of, summary.sure_and_wrong.all), (0, 9));
    assert_eq!((summary.nearer.of, summary.nearer.all), (4, 4));
    // Probability 0.9: right in 5 of 9 names.
    let brier = (5.0 * 0.01 + 4.0 * 0.81) / 9.0;
    assert!((summary.brier.unwrap() - brier).abs() < 1e-12, "{:?}", summary.brier);
    assert!(markdown(&all, 100).contains("seed 100 | scoring"));
    assert!(confusion(&all).starts_with("hidden,misalignment,misalignment + shock,no-mismatch"));
}
