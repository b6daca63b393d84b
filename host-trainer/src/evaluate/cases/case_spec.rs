//! List of cases: every effect at every severity, controls, pairs, and effects outside the vocabulary, with noise,
//! tachometer and knowledge of the rig drawn for each.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::effects;
use super::outside::Outside;
use super::settings::CaseSettings;
use super::simulator::Simulator;
use crate::evaluate::independent;
use crate::rig::effect::EffectKind;

const SETTINGS: CaseSettings = CaseSettings::DEFAULT;

/// Specification of a case, before its draw.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseSpec {
    /// Hidden causes.
    pub hidden: Hidden,
    /// Whether sensor noise and process force are several times the usual.
    pub loud: bool,
    /// Whether the tachometer is recorded.
    pub tachometer: bool,
    /// Whether some of the rig's parameters are guesses, with recordings of the healthy machine to fit them to.
    pub guessed: bool,
}

/// Hidden causes of a case.
#[derive(Clone, Debug, PartialEq)]
pub enum Hidden {
    /// Nothing: a control.
    Nothing,
    /// One or two effects of the vocabulary.
    Effects(Vec<(EffectKind, Severity)>),
    /// An effect outside the vocabulary.
    Outside(Outside),
    /// An effect outside the vocabulary, of the independent simulator.
    OutsideIndependent(independent::outside::Outside),
}

/// Severity of an effect, in thirds of its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The weakest third.
    Slight,
    /// The middle third.
    Plain,
    /// The strongest third.
    Severe,
}

impl Severity {
    /// All severities.
    pub const ALL: [Self; 3] = [Self::Slight, Self::Plain, Self::Severe];

    /// Name in one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Slight => "slight",
            Self::Plain => "plain",
            Self::Severe => "severe",
        }
    }

    /// Start and length of the severity's third, as shares of the range.
    pub fn share(self) -> (f64, f64) {
        (f64::from(self as u8) / 3.0, 1.0 / 3.0)
    }
}

/// A kind of case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Nothing hidden.
    Control,
    /// One effect.
    Single,
    /// Two effects.
    Pair,
    /// One effect outside the vocabulary.
    Outside,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Control, Self::Single, Self::Pair, Self::Outside];

    /// Name in one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Control => "control",
            Self::Single => "single",
            Self::Pair => "pair",
            Self::Outside => "outside",
        }
    }
}

impl CaseSpec {
    /// Names of the hidden effects.
    pub fn names(&self) -> Vec<&'static str> {
        match &self.hidden {
            Hidden::Nothing => Vec::new(),
            Hidden::Effects(effects) => effects.iter().map(|(kind, _)| kind.name()).collect(),
            Hidden::Outside(kind) => vec![kind.name()],
            Hidden::OutsideIndependent(kind) => vec![kind.name()],
        }
    }

    /// Kind of the case.
    pub fn kind(&self) -> Kind {
        match &self.hidden {
            Hidden::Nothing => Kind::Control,
            Hidden::Effects(names) if names.len() == 1 => Kind::Single,
            Hidden::Effects(_) => Kind::Pair,
            Hidden::Outside(_) | Hidden::OutsideIndependent(_) => Kind::Outside,
        }
    }
}

/// Cases of one round of a simulator. Another round has the same kinds under other circumstances.
pub fn round(number: usize, simulator: Simulator) -> Vec<CaseSpec> {
    let mut hidden = vec![Hidden::Nothing; SETTINGS.controls];
    for severity in Severity::ALL {
        hidden.extend(EffectKind::vocabulary().map(|kind| Hidden::Effects(vec![(kind, severity)])));
    }
    hidden.extend(
        pairs(number).into_iter().map(|[a, b]| Hidden::Effects(vec![(a, Severity::Plain), (b, Severity::Plain)])),
    );
    let outside: Vec<Hidden> = match simulator {
        Simulator::Shared => Outside::ALL.map(Hidden::Outside).to_vec(),
        Simulator::Exact | Simulator::Real => {
            independent::outside::Outside::ALL.map(Hidden::OutsideIndependent).to_vec()
        }
    };
    hidden.extend(outside.into_iter().flat_map(|kind| vec![kind; SETTINGS.outside_each]));
    // Drawn, so that any step through the list has all circumstances.
    let mut rng = ChaCha8Rng::seed_from_u64(number as u64);
    let mut one_in = |of: f64| rng.random_bool(1.0 / of);
    let circumstances = |hidden| CaseSpec {
        hidden,
        loud: one_in(SETTINGS.loud_one_in),
        tachometer: one_in(SETTINGS.tachometer_one_in),
        guessed: one_in(SETTINGS.guessed_one_in),
    };
    hidden.into_iter().map(circumstances).collect()
}

/// Effects of different groups together; each round has others.
fn pairs(number: usize) -> Vec<[EffectKind; 2]> {
    let groups = effects::GROUPS;
    let mut out = Vec::new();
    for (g, first) in groups.iter().enumerate() {
        for (h, second) in groups.iter().enumerate().skip(g + 1) {
            let turn = number + g + h;
            out.push([first[turn % first.len()], second[(turn + 1) % second.len()]]);
        }
    }
    out
}
