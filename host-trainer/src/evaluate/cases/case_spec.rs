//! Which cases there are: every effect at every severity, controls, pairs, and what the vocabulary has no name for, with
//! noise, tachometer and knowledge of the rig drawn for each.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::effects;
use super::outside::Outside;
use crate::rig::effect::EffectKind;

/// What a case is to be, before anything of it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseSpec {
    /// What is hidden.
    pub hidden: Hidden,
    /// Whether sensor noise and process force are several times the usual.
    pub loud: bool,
    /// Whether the tachometer is recorded.
    pub tachometer: bool,
    /// Whether some of the rig's parameters are guesses, with recordings of the healthy machine to fit them to.
    pub guessed: bool,
}

/// What is hidden.
#[derive(Clone, Debug, PartialEq)]
pub enum Hidden {
    /// Nothing: a control.
    Nothing,
    /// One or two effects of the vocabulary.
    Effects(Vec<(EffectKind, Severity)>),
    /// An effect without a name.
    Outside(Outside),
}

/// How strong an effect is, in thirds of its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The weakest third.
    Slight,
    /// The middle.
    Plain,
    /// The strongest.
    Severe,
}

impl Severity {
    /// All.
    pub const ALL: [Self; 3] = [Self::Slight, Self::Plain, Self::Severe];

    /// As a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Slight => "slight",
            Self::Plain => "plain",
            Self::Severe => "severe",
        }
    }

    /// Where its third begins, and how long it is.
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
    /// Two.
    Pair,
    /// One without a name.
    Outside,
}

impl Kind {
    /// All.
    pub const ALL: [Self; 4] = [Self::Control, Self::Single, Self::Pair, Self::Outside];

    /// As a word.
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
    /// What kind of case it is.
    pub fn kind(&self) -> Kind {
        match &self.hidden {
            Hidden::Nothing => Kind::Control,
            Hidden::Effects(names) if names.len() == 1 => Kind::Single,
            Hidden::Effects(_) => Kind::Pair,
            Hidden::Outside(_) => Kind::Outside,
        }
    }
}

/// How many cases there are of each kind for one round.
const CONTROLS: usize = 20;
const OUTSIDE_EACH: usize = 2;

/// The cases of one round. Another round has the same kinds under other circumstances.
pub fn round(number: usize) -> Vec<CaseSpec> {
    let mut hidden = vec![Hidden::Nothing; CONTROLS];
    for severity in Severity::ALL {
        hidden.extend(EffectKind::ALL.iter().map(|kind| Hidden::Effects(vec![(*kind, severity)])));
    }
    hidden.extend(
        pairs(number).into_iter().map(|[a, b]| Hidden::Effects(vec![(a, Severity::Plain), (b, Severity::Plain)])),
    );
    hidden.extend(Outside::ALL.into_iter().flat_map(|kind| vec![Hidden::Outside(kind); OUTSIDE_EACH]));
    // Drawn, so that every how manieth of them has all circumstances.
    let mut rng = ChaCha8Rng::seed_from_u64(number as u64);
    let mut one_in = |of: f64| rng.random_bool(1.0 / of);
    let circumstances = |hidden| CaseSpec { hidden, loud: one_in(3.0), tachometer: one_in(2.0), guessed: one_in(5.0) };
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
