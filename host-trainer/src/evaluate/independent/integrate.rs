//! Integration of the five degrees of freedom: classical Runge–Kutta of fourth order at many steps a sample.
//!
//! Written from the equations of the rig, ball by ball, and not from the simulator of the rig: the two share the
//! parameters and nothing else.

use std::f64::consts::TAU;

use super::motion::Moment;
use super::noise::{colour, white};
use super::plant::{DOFS, Each, INNER_X, INNER_Y, Mode, OUTER_X, OUTER_Y, Plant, SENSOR_Y, Signal, Source, Stage};
use super::settings::IntegrationSettings;
use crate::recording::{Channel, Recording};
use crate::rig::{OperatingCondition, RigError};

const SETTINGS: IntegrationSettings = IntegrationSettings::DEFAULT;

/// Contacts at one instant: direction of each ball, and the deflection that it has lost.
#[derive(Clone)]
struct Contacts {
    moment: Moment,
    cos: Vec<f64>,
    sin: Vec<f64>,
    loss: Vec<f64>,
}

/// Runs a machine: channels `ax`, `ay` and `tacho`. Speed and load of the condition are what is stated; those that act
/// are the plant's. Without noise where `seed` is `None`.
///
/// # Errors
/// A run that diverges.
pub fn run(plant: &Plant, condition: &OperatingCondition, seed: Option<u64>) -> Result<Recording, RigError> {
    run_in_steps(plant, condition, seed, SETTINGS.rad_per_step)
}

/// Runs as [`run`], with another turn of the fastest mode in a step, rad.
///
/// # Errors
/// A run that diverges.
pub fn run_in_steps(
    plant: &Plant,
    condition: &OperatingCondition,
    seed: Option<u64>,
    rad_per_step: f64,
) -> Result<Recording, RigError> {
    let rate = condition.sample_rate_hz;
    let settle = (settling_s(plant) * rate).ceil() as usize;
    let count = condition.samples + plant.surplus;
    let std = (0.5 * plant.rig.excitation.process_force_psd_n2_per_hz * rate).sqrt();
    let process = match seed {
        Some(seed) if std > 0.0 => {
            let mut noise = white(seed, 0, settle);
            noise.extend(white(seed, 1, count));
            colour(&plant.colour[0], &mut noise);
            noise.iter_mut().for_each(|v| *v *= std);
            noise
        }
        _ => vec![0.0; settle + count],
    };
    let mut channels = mechanics(plant, rate, steps(plant, rate, rad_per_step), settle, &process)?;
    for alter in &plant.both {
        alter(rate, &mut channels);
    }
    let mut tacho: Vec<f64> = tachometer(plant, rate, count);
    let mut signals: Vec<_> = plant.signals.iter().collect();
    signals.sort_by_key(|(stage, _)| *stage);
    for (index, channel) in channels.iter_mut().enumerate() {
        let (before, after): (Vec<&(Stage, Signal)>, Vec<_>) =
            signals.iter().copied().partition(|(stage, _)| *stage == Stage::Structure);
        before.iter().for_each(|(_, alter)| alter(index, rate, channel));
        if let Some(seed) = seed {
            let mut noise = white(seed, 2 + index as u64, channel.len());
            colour(&plant.colour[1 + index], &mut noise);
            let std = plant.noise[index] * plant.rig.sensor.noise_std_m_per_s2;
            channel.iter_mut().zip(noise).for_each(|(v, n)| *v += std * n);
        }
        channel.iter_mut().for_each(|v| *v += plant.offset[index]);
        after.iter().for_each(|(_, alter)| alter(index, rate, channel));
        channel.truncate(condition.samples);
    }
    signals.iter().filter(|(stage, _)| *stage == Stage::Logger).for_each(|(_, alter)| alter(2, rate, &mut tacho));
    tacho.truncate(condition.samples);
    let [ax, ay] = channels;
    let sensor = &plant.rig.sensor;
    let channel = |name: &str, location: Option<&str>, samples| Channel {
        name: name.into(),
        location: location.map(Into::into),
        samples,
    };
    Ok(Recording {
        channels: vec![
            channel("ax", Some(sensor.horizontal.name()), ax),
            channel("ay", Some(sensor.vertical.name()), ay),
            channel("tacho", None, tacho),
        ],
        sample_rate_hz: rate,
        shaft_hz: Some(condition.shaft_hz),
        load_n: Some(condition.load_n),
        ..Recording::default()
    })
}

/// Accelerations at the two sensors, m/s², from the first sample on.
fn mechanics(
    plant: &Plant,
    rate: f64,
    steps: usize,
    settle: usize,
    process: &[f64],
) -> Result<[Vec<f64>; 2], RigError> {
    let step_s = 1.0 / (rate * steps as f64);
    let measured = plant.measured();
    let standing = plant.standing_forces();
    let offsets: Vec<(f64, f64)> = plant.balls_rad.iter().map(|angle| angle.sin_cos()).collect();
    let time = |sample: usize| (sample as f64 - settle as f64) / rate;
    let (mut q, mut v) = (rest(plant), [0.0; DOFS]);
    let mut modes = vec![[0.0; 2]; plant.modes.len()];
    let mut now = Contacts::new(offsets.len());
    now.put(plant, &offsets, plant.pace.at(time(0)));
    let (mut middle, mut end) = (now.clone(), now.clone());
    let mut out = [Vec::with_capacity(process.len() - settle), Vec::with_capacity(process.len() - settle)];
    let mut driven = Vec::new();
    let mut forced = Vec::new();
    for (sample, &random) in process.iter().enumerate() {
        let motion = Motion { plant, standing: &standing, random };
        let next_sample = plant.pace.at(time(sample + 1));
        let this_sample = now.moment;
        if sample >= settle {
            let (a, contact) = motion.acceleration(&now, &q, &v);
            for (index, channel) in out.iter_mut().enumerate() {
                let mut value = a[measured[index]];
                for (mode, state) in plant.modes.iter().zip(&modes) {
                    value +=
                        mode.gains[index] * mode_acceleration(mode, state, drive(plant, mode, &a, contact, random));
                }
                channel.push(value);
            }
        }
        for step in 0..steps {
            let share = |of: f64| (step as f64 + of) / steps as f64;
            middle.put(plant, &offsets, this_sample.between(&next_sample, share(0.5)));
            let end_at = if step + 1 == steps { next_sample } else { this_sample.between(&next_sample, share(1.0)) };
            end.put(plant, &offsets, end_at);
            let (a1, contact) = motion.acceleration(&now, &q, &v);
            if !modes.is_empty() {
                driven.clear();
                driven.extend(plant.modes.iter().map(|m| drive(plant, m, &a1, contact, random)));
            }
            let h = step_s;
            let (q2, v2) = (moved(&q, &v, 0.5 * h), moved(&v, &a1, 0.5 * h));
            let (a2, _) = motion.acceleration(&middle, &q2, &v2);
            let (q3, v3) = (moved(&q, &v2, 0.5 * h), moved(&v, &a2, 0.5 * h));
            let (a3, _) = motion.acceleration(&middle, &q3, &v3);
            let (q4, v4) = (moved(&q, &v3, h), moved(&v, &a3, h));
            let (a4, _) = motion.acceleration(&end, &q4, &v4);
            for i in 0..DOFS {
                q[i] += h / 6.0 * (v[i] + 2.0 * (v2[i] + v3[i]) + v4[i]);
                v[i] += h / 6.0 * (a1[i] + 2.0 * (a2[i] + a3[i]) + a4[i]);
            }
            if !modes.is_empty() {
                let (a, contact) = motion.acceleration(&end, &q, &v);
                forced.clear();
                forced.extend(plant.modes.iter().map(|m| drive(plant, m, &a, contact, random)));
                for (index, mode) in plant.modes.iter().enumerate() {
                    advance(mode, &mut modes[index], driven[index], forced[index], h);
                }
            }
            std::mem::swap(&mut now, &mut end);
        }
        if !q.iter().chain(&v).all(|x| x.is_finite() && x.abs() < SETTINGS.diverged) {
            return Err(RigError::Diverged { time_s: time(sample) });
        }
    }
    Ok(out)
}

impl Contacts {
    fn new(balls: usize) -> Self {
        let zero = vec![0.0; balls];
        Self { moment: Moment::default(), cos: zero.clone(), sin: zero.clone(), loss: zero }
    }

    fn put(&mut self, plant: &Plant, offsets: &[(f64, f64)], moment: Moment) {
        self.moment = moment;
        let (s, c) = moment.cage_rad.sin_cos();
        for (j, (so, co)) in offsets.iter().enumerate() {
            self.cos[j] = c * co - s * so;
            self.sin[j] = s * co + c * so;
            let at = moment.cage_rad + plant.balls_rad[j];
            self.loss[j] = plant.losses.iter().map(|law| law(&moment, j, at)).sum();
        }
    }
}

struct Motion<'a> {
    plant: &'a Plant,
    standing: &'a Each,
    random: f64,
}

impl Motion<'_> {
    /// Accelerations, and the force of the bearing on the housing.
    fn acceleration(&self, at: &Contacts, q: &Each, v: &Each) -> (Each, [f64; 2]) {
        let plant = self.plant;
        let bearing = &plant.rig.bearing;
        let (dx, dy) = (q[INNER_X] - q[OUTER_X], q[INNER_Y] - q[OUTER_Y]);
        let (mut fx, mut fy) = (0.0, 0.0);
        for ((c, s), loss) in at.cos.iter().zip(&at.sin).zip(&at.loss) {
            let deflection = dx * c + dy * s - bearing.radial_clearance_m - loss;
            if deflection > 0.0 {
                let force = bearing.contact_stiffness_n_per_m1_5 * power(deflection, bearing.contact_exponent);
                fx += force * c;
                fy += force * s;
            }
        }
        let mut f = *self.standing;
        for i in [INNER_X, INNER_Y, OUTER_X, OUTER_Y] {
            f[i] -= plant.stiffness[i] * q[i] + plant.damping[i] * v[i];
        }
        let spring = plant.stiffness[SENSOR_Y] * (q[SENSOR_Y] - q[OUTER_Y])
            + plant.damping[SENSOR_Y] * (v[SENSOR_Y] - v[OUTER_Y]);
        f[SENSOR_Y] -= spring;
        f[OUTER_Y] += spring + fy + self.random;
        f[OUTER_X] += fx;
        f[INNER_X] -= fx;
        f[INNER_Y] -= fy;
        let (s, c) = at.moment.shaft_rad.sin_cos();
        let [along, across] = plant.unbalance;
        let square = at.moment.shaft_rad_per_s * at.moment.shaft_rad_per_s;
        f[INNER_X] += square * (along * c - across * s);
        f[INNER_Y] += square * (along * s + across * c);
        for law in &plant.forces {
            law(&at.moment, q, v, &mut f);
        }
        (std::array::from_fn(|i| f[i] / plant.mass[i]), [fx, fy])
    }
}

fn power(deflection: f64, exponent: f64) -> f64 {
    if exponent == 1.5 { deflection * deflection.sqrt() } else { deflection.powf(exponent) }
}

fn moved(x: &Each, rate: &Each, step: f64) -> Each {
    std::array::from_fn(|i| x[i] + step * rate[i])
}

/// Drive of a mode, m/s².
fn drive(plant: &Plant, mode: &Mode, a: &Each, contact: [f64; 2], random: f64) -> f64 {
    match mode.source {
        Source::ContactX => contact[0] / plant.mass[OUTER_X],
        Source::ContactY => contact[1] / plant.mass[OUTER_Y],
        Source::HousingX => a[OUTER_X],
        Source::HousingY => a[OUTER_Y],
        Source::Process => random / plant.mass[OUTER_Y],
    }
}

fn mode_acceleration(mode: &Mode, [x, v]: &[f64; 2], drive: f64) -> f64 {
    let omega = TAU * mode.frequency_hz;
    drive - 2.0 * mode.damping_ratio * omega * v - omega * omega * x
}

/// Advances a mode by a step over which its drive goes in a straight line.
fn advance(mode: &Mode, state: &mut [f64; 2], from: f64, to: f64, h: f64) {
    let a = |x: [f64; 2], share: f64| mode_acceleration(mode, &x, from + share * (to - from));
    let [x, v] = *state;
    let a1 = a([x, v], 0.0);
    let v2 = v + 0.5 * h * a1;
    let a2 = a([x + 0.5 * h * v, v2], 0.5);
    let v3 = v + 0.5 * h * a2;
    let a3 = a([x + 0.5 * h * v2, v3], 0.5);
    let v4 = v + h * a3;
    let a4 = a([x + h * v3, v4], 1.0);
    *state = [x + h / 6.0 * (v + 2.0 * (v2 + v3) + v4), v + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)];
}

/// Deflections under the standing forces, roughly: the balls are stiff against the supports.
fn rest(plant: &Plant) -> Each {
    let f = plant.standing_forces();
    let y = (f[INNER_Y] + f[OUTER_Y] + f[SENSOR_Y]) / (plant.stiffness[INNER_Y] + plant.stiffness[OUTER_Y]).max(1.0);
    let mut q = [0.0; DOFS];
    [q[INNER_Y], q[OUTER_Y], q[SENSOR_Y]] = [y; 3];
    q
}

/// Steps a sample that follow the fastest mode and law.
fn steps(plant: &Plant, rate: f64, rad_per_step: f64) -> usize {
    let own = |i: usize| (plant.stiffness[i] / plant.mass[i]).sqrt();
    let coupled = (plant.stiffness[SENSOR_Y] * (1.0 / plant.mass[SENSOR_Y] + 1.0 / plant.mass[OUTER_Y])).sqrt();
    let modes = plant.modes.iter().map(|m| TAU * m.frequency_hz).fold(0.0, f64::max);
    let fastest = (0..DOFS).map(own).fold(coupled.max(plant.fastest).max(modes), f64::max);
    let steps = (fastest / (rate * rad_per_step)).ceil();
    steps.clamp(SETTINGS.steps[0], SETTINGS.steps[1]) as usize
}

/// Time for the start's transient to decay, s.
fn settling_s(plant: &Plant) -> f64 {
    let supports = (0..DOFS).map(|i| 0.5 * plant.damping[i] / plant.mass[i]);
    let modes = plant.modes.iter().map(|m| TAU * m.frequency_hz * m.damping_ratio);
    let slowest = supports.chain(modes).fold(f64::INFINITY, f64::min);
    (SETTINGS.settle_time_constants / slowest).clamp(SETTINGS.settle_s[0], SETTINGS.settle_s[1])
}

fn tachometer(plant: &Plant, rate: f64, count: usize) -> Vec<f64> {
    let turn = |sample: f64| (plant.pace.at(sample / rate).shaft_rad / TAU).floor();
    let turns: Vec<f64> = (0..=count).map(|i| turn(i as f64 - 1.0)).collect();
    turns.windows(2).map(|pair| if pair[1] > pair[0] { 1.0 } else { 0.0 }).collect()
}
