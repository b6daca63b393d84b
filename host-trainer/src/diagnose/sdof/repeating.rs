//! What repeats in what a model leaves: a force that is a tone or repeats along the travel, or a stiffness or damping that swings.
//!
//! No flexible column (`flexible`) follows it: a tone begins at another phase in each recording, and a force may repeat many times over
//! the travel. It is sought as a line: where the residuals r are white, the power |Σ r w e^{−iωx}|²/Σ (r w)² at a frequency of the time
//! or the position x has an exponential distribution of mean 1, for any weight w of the states (R. A. Fisher, Proc. R. Soc. A 125
//! (1929) 54–59).

use std::f64::consts::LN_2;

use super::acquire::{Acquired, Track};
use super::nominal::Nominal;
use super::settings::SdofSettings;
use super::table::{RIDGE, Table, TermModel};
use crate::identify::force_balance::gram::Rows;
use crate::signal::lines::floor;
use crate::signal::transform::{forward, hann};

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;
/// Kinds of what repeats.
const KINDS: f64 = 4.0;
/// Length of the transform of the travel over its cells.
const PADDED: usize = 8;

/// What repeats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Repeats {
    /// A force in time.
    Force,
    /// A stiffness in time: what is left is in proportion to the position.
    Stiffness,
    /// A damping in time.
    Damping,
    /// A force along the position.
    AlongPosition,
}

/// What repeats, how often, and how much it takes of what is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeating {
    /// What repeats.
    pub what: Repeats,
    /// Frequency, Hz, or pitch in the unit of the position.
    pub often: f64,
    /// Share of the squared residuals.
    pub share: f64,
    /// Probability of as much by chance.
    pub p_value: f64,
}

/// Weights of a line in the samples of a recording.
type Weights = fn(&Track) -> Vec<f64>;

/// Values of a recording, 0 at samples without one, and the weights of a line in them.
struct Series {
    values: Vec<f64>,
    weights: Vec<f64>,
}

/// Powers of lines at the bins of a transform over those around, gamma distributed with as many degrees of freedom as recordings if
/// there is none, and their shares of the squared values.
struct Lines {
    powers: Vec<f64>,
    shares: Vec<f64>,
    recordings: usize,
}

/// What repeats most, beyond chance, and takes more of what a model leaves than a mismatch without a name must.
pub fn find(table: &Table, acquired: &Acquired, model: &TermModel) -> Option<Repeating> {
    let residual = table.residual(model);
    let mut rows = residual.iter();
    let mut tracks = Vec::new();
    for track in &acquired.tracks {
        let of = |bad: &bool| if *bad { 0.0 } else { rows.next().copied().unwrap_or_default() };
        let residual: Vec<f64> = track.bad.iter().map(of).collect();
        // Frequencies of other rates are not the same bins.
        if !track.healthy && track.sample_rate_hz == acquired.tracks[0].sample_rate_hz {
            tracks.push((track, residual));
        }
    }
    let longest = tracks.iter().map(|(track, _)| track.len()).max()?;
    let length = (2 * longest).next_power_of_two();
    let [known, multiples] = known_lines(&tracks, length, acquired.driven);
    let first = SETTINGS.repeats_at_least * length / longest;
    let in_time = |(what, weights): (Repeats, Weights)| {
        let series =
            tracks.iter().map(|(track, residual)| Series { values: residual.clone(), weights: weights(track) });
        // A swing of a stiffness is at no line of the input.
        let known = if what == Repeats::Force { &known } else { &multiples };
        let lines = Lines::new(series, length);
        let bin = greatest(&lines.powers, |bin| bin > first && !known[bin])?;
        let often = bin as f64 * tracks[0].0.sample_rate_hz / length as f64;
        let p_value = (KINDS * lines.p_value(lines.powers[bin])).min(1.0);
        Some(Repeating { what, often, share: lines.shares[bin], p_value })
    };
    let kinds: [(Repeats, Weights); 3] = [
        (Repeats::Force, |track| vec![1.0; track.len()]),
        (Repeats::Stiffness, |track| centred(track, &track.states.position)),
        (Repeats::Damping, |track| centred(track, &track.states.velocity)),
    ];
    let all = kinds.into_iter().filter_map(in_time);
    let is_found = |found: &Repeating| found.p_value < SETTINGS.significance && found.share > SETTINGS.unexplained;
    all.chain(along_position(table, model)).filter(is_found).max_by(|a, b| a.share.total_cmp(&b.share))
}

/// Pitch of a force along the position, in the position's unit, that stands out most of the forces that a rig leaves, which are summed
/// over cells of the travel; `None` without a travel.
pub fn pitch(nominal: &Nominal, acquired: &Acquired) -> Option<f64> {
    let places = || acquired.under_test().flat_map(|track| &track.states.position);
    let low = places().copied().fold(f64::INFINITY, f64::min);
    let travel = places().copied().fold(f64::NEG_INFINITY, f64::max) - low;
    if !(travel > 0.0 && travel.is_finite()) {
        return None;
    }
    let cells = SETTINGS.cells;
    // Padded to many bins a period over the travel: a pitch that is off shifts the phase along it.
    let (mut sums, mut squares) = (vec![0.0; PADDED * cells], 0.0);
    for track in acquired.under_test() {
        let input = track.grid_input(acquired.interpolation);
        let left = track.signal(|q, v, a| nominal.balance(q, v, a));
        for ((position, left), input) in track.states.position.iter().zip(left).zip(input) {
            let left = left - nominal.machine.input_gain_n_per_unit * input;
            let cell = ((position - low) / travel * cells as f64) as usize;
            sums[cell.min(cells - 1)] += left;
            squares += left * left;
        }
    }
    let powers = whitened(forward(&mut sums).iter().map(|bin| bin.norm_sqr() / squares).collect(), 1);
    let bin = greatest(&powers, |bin| bin > PADDED * SETTINGS.repeats_at_least)?;
    Some(PADDED as f64 * travel / bin as f64)
}

/// What the pair of columns of the library's pitch takes of what a model leaves.
fn along_position(table: &Table, model: &TermModel) -> Option<Repeating> {
    let (pitch, columns) = table.library.along?;
    let wider = [model.columns.as_slice(), &columns].concat();
    let values = table.gram.solve(&wider, &[], Rows::All, RIDGE)?;
    let [wide, narrow] = [(&wider, &values), (&model.columns, &model.values)]
        .map(|(columns, values)| table.gram.left_in(columns, values, Rows::All));
    let share = 1.0 - wide / narrow;
    let rows: usize = table.library.rows.iter().sum();
    // The pitch is that of the greatest of as many powers.
    let p_value = KINDS * SETTINGS.cells as f64 * (-0.5 * share * rows as f64).exp();
    Some(Repeating { what: Repeats::AlongPosition, often: pitch, share, p_value })
}

/// State of a recording on the grid at each sample, less its mean.
fn centred(track: &Track, states: &[f64]) -> Vec<f64> {
    let of: Vec<f64> = (0..track.len()).map(|k| states[k * track.fine]).collect();
    let mean = of.iter().sum::<f64>() / of.len().max(1) as f64;
    of.into_iter().map(|state| state - mean).collect()
}

/// Bins at which the input, or a free motion, has lines of its own, where a rig that is right within its tolerances errs; and the
/// multiples of one that is most of it.
fn known_lines(tracks: &[(&Track, Vec<f64>)], length: usize, driven: bool) -> [Vec<bool>; 2] {
    let of = |track: &Track| {
        let motion = if driven { track.input.clone() } else { centred(track, &track.states.position) };
        Series {
            values: motion.iter().zip(hann(motion.len())).map(|(x, shape)| x * shape).collect(),
            weights: vec![1.0; motion.len()],
        }
    };
    let lines = Lines::new(tracks.iter().map(|(track, _)| of(track)), length);
    let bins = lines.powers.len();
    let near = |all: &mut Vec<bool>, bin: usize| {
        all[bin.saturating_sub(SETTINGS.near_bins)..=(bin + SETTINGS.near_bins).min(bins - 1)].fill(true);
    };
    let (mut own, mut multiples) = (vec![false; bins], vec![false; bins]);
    let is_line = |bin: &usize| lines.p_value(lines.powers[*bin]) < SETTINGS.significance;
    (1..bins).filter(is_line).for_each(|bin| near(&mut own, bin));
    // Of a tone at most two thirds of the power are in the middle bin of a Hann window's three.
    let strongest = greatest(&lines.powers, |bin| bin > SETTINGS.near_bins);
    if let Some(tone) = strongest.filter(|bin| lines.shares[*bin] > 0.5) {
        (0..bins).step_by(tone).for_each(|bin| near(&mut multiples, bin));
    }
    multiples.iter().zip(&mut own).for_each(|(multiple, own)| *own |= multiple);
    [own, multiples]
}

impl Lines {
    fn new(series: impl Iterator<Item = Series>, length: usize) -> Self {
        let bins = length / 2 + 1;
        let (mut powers, mut explained) = (vec![0.0; bins], vec![0.0; bins]);
        let (mut recordings, mut squares) = (0, 0.0);
        for Series { values, weights } in series {
            let square = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
            let mut product: Vec<f64> = values.iter().zip(&weights).map(|(r, w)| r * w).collect();
            let [of_product, of_weights] = [square(&product), square(&weights)];
            if of_product == 0.0 {
                continue;
            }
            product.resize(length, 0.0);
            for (bin, x) in forward(&mut product).into_iter().enumerate() {
                powers[bin] += x.norm_sqr() / of_product;
                explained[bin] += 2.0 * x.norm_sqr() / of_weights;
            }
            recordings += 1;
            squares += square(&values);
        }
        let shares = explained.into_iter().map(|part| part / squares).collect();
        Self { powers: whitened(powers, recordings), shares, recordings }
    }

    /// Probability of a power somewhere among the bins by chance.
    fn p_value(&self, power: f64) -> f64 {
        let terms = (1..self.recordings).scan(1.0, |term, n| {
            *term *= power / n as f64;
            Some(*term)
        });
        let tail = (-power).exp() * (1.0 + terms.sum::<f64>());
        (self.powers.len() as f64 * tail).min(1.0)
    }
}

/// Powers over those around, as far as these are above the usual: no colour of the values makes a line.
fn whitened(mut powers: Vec<f64>, recordings: usize) -> Vec<f64> {
    // Median of a sum of exponential powers, over that of one.
    let usual = (recordings as f64 - 1.0) / LN_2 + 1.0;
    let floor = floor(&powers, SETTINGS.floor_bins);
    powers.iter_mut().zip(floor).for_each(|(power, floor)| *power *= (usual / floor).min(1.0));
    powers
}

/// Bin of the greatest power among some bins.
fn greatest(powers: &[f64], is_asked: impl Fn(usize) -> bool) -> Option<usize> {
    let asked = (0..powers.len()).filter(|bin| is_asked(*bin));
    asked.max_by(|a, b| powers[*a].total_cmp(&powers[*b]))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::tests::forced;
    use crate::diagnose::result::{DiagnosisResult, Verdict};
    use crate::identify::force_balance::testing;

    fn assert_unexplained(found: &DiagnosisResult, what: &str) {
        assert_eq!(found.diagnosis.verdict, Verdict::Unexplained, "{:?}", found.diagnosis);
        assert!(found.caveats.iter().any(|c| c.contains("repeat") && c.contains(what)), "{:?}", found.caveats);
    }

    #[test]
    fn a_force_in_time_that_is_not_the_input_is_unexplained() {
        let tone = |_: f64, _: f64, sample: f64, n: u64| 0.5 * (TAU * 7.8 * sample / testing::RATE + n as f64).sin();
        assert_unexplained(&forced(tone), "a force in time that is not the input, frequency 7.8");
    }

    #[test]
    fn a_stiffness_that_swings_is_unexplained() {
        let swing =
            |q: f64, _: f64, sample: f64, n: u64| 80.0 * q * (TAU * 5.0 * sample / testing::RATE + n as f64).sin();
        assert_unexplained(&forced(swing), "a stiffness that swings in time, frequency ");
    }

    #[test]
    fn a_force_that_repeats_along_the_position_is_unexplained() {
        let cogging = |q: f64, _: f64, _: f64, _: u64| 0.6 * (TAU * q / 1.5e-3).sin();
        assert_unexplained(&forced(cogging), "a force along the position, pitch 1.5");
    }

    /// Neither a rig without a mismatch nor a random force repeats.
    #[test]
    fn null_noise_and_a_random_force_do_not_repeat() {
        let noise: Vec<Vec<f64>> = (0..4).map(|n| testing::white(n + 90, 0.5, 3000)).collect();
        let random = |_: f64, _: f64, sample: f64, n: u64| noise[n as usize][sample as usize];
        for found in [forced(|_, _, _, _| 0.0), forced(random)] {
            assert_eq!(found.diagnosis.verdict, Verdict::NoMismatch, "{:?}", found.diagnosis);
            assert!(found.caveats.iter().all(|c| !c.contains("repeat")), "{:?}", found.caveats);
        }
    }
}
