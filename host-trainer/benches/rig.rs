//! Time to simulate the 9-ball rig: ours beside DOPRI5 of `ode_solvers` and SciPy's `solve_ivp`, on the same equations
//! to the same error, in one run.
//!
//! `cargo bench -p ballrace --bench rig`, with `BALLRACE_PYTHON` a Python that has SciPy (default `python3`).
//!
//! DOPRI5 rather than the crate's DOP853, whose step control takes √10 times the steps for each decade of tolerance here
//! and needs a hundred times as long for 1e-5 m/s².
//!
//! Beside these, ours with one step a sample, as a search takes it, alone and with effects of each kind.
//!
//! Everyone runs from rest over the same time; the error is the RMS of both acceleration channels over the second half
//! against ours at 64 steps a sample (which the unit tests hold to 1e-8 m/s² of an independent implementation's
//! trajectories). The adaptive solvers get the loosest tolerance of a list that keeps to the target.

use ballrace::rig::effect::{EffectKind, ParameterKey};
use std::{
    env,
    io::Write,
    path::Path,
    process::Command,
    time::{Duration, Instant},
};

use ballrace::rig::{
    EffectEntry, Machine, OperatingCondition, Rig, Run, Start, bearing::GRAVITY, simulate, simulate_many,
};
use ode_solvers::{Dopri5, SVector, System, dop_shared::OutputType};

const RIG: &str = include_str!("rig.toml");
const RATE: f64 = 25_600.0;
/// Samples that count; as many go before.
const SAMPLES: usize = 2560;
const TARGET: f64 = 1e-6;
const RUNS: usize = 7;
const TOLERANCES: [f64; 10] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12];
/// Positions are of the order of 10 µm, of which the resonator's spring makes m/s² of 1e-15 m.
const ABSOLUTE_PER_RELATIVE: f64 = 1e-8;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;
type State = SVector<f64, 10>;
type Accelerations = [Vec<f64>; 2];

fn main() -> Result<()> {
    let rig = Rig::parse(RIG, Path::new("benches/rig.toml"))?;
    let condition = OperatingCondition { shaft_hz: 29.95, load_n: 500.0, sample_rate_hz: RATE, samples: SAMPLES };
    let start = Start { settle_s: SAMPLES as f64 / RATE, ..Start::noise_free(0.3, 0.7) };
    let seconds = 2.0 * SAMPLES as f64 / RATE;
    let fine = ours(&rig, &condition, &Start { substeps: Some(64), ..start })?;

    let mut rows: Vec<(String, f64, f64)> = Vec::new();
    let alone = median(|| ours(&rig, &condition, &start).map(|_| ()))?;
    let error = difference(&ours(&rig, &condition, &start)?, &fine);
    rows.push(("ballrace, one run".into(), alone, error));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    for count in [8, 64] {
        let runs = vec![Run { rig: &rig, condition, start }; count];
        let together = median(|| pool.install(|| simulate_many(&runs)).map(|_| ()).map_err(Into::into))?;
        rows.push((format!("ballrace, {count} runs side by side"), together / count as f64, error));
    }
    let start_as_in_a_search = Start { substeps: Some(1), ..start };
    let nothing = std::iter::once(("nothing".into(), rig.clone()));
    for (name, rig) in nothing.chain(effects().map(|effect| (effect.kind.to_string(), rig.clone().with_effect(effect))))
    {
        let fine = ours(&rig, &condition, &Start { substeps: Some(64), ..start })?;
        let error = difference(&ours(&rig, &condition, &start_as_in_a_search)?, &fine);
        let runs = vec![Run { rig: &rig, condition, start: start_as_in_a_search }; 8];
        let together = median(|| pool.install(|| simulate_many(&runs)).map(|_| ()).map_err(Into::into))?;
        rows.push((format!("one step a sample, 8 with {name}"), together / 8.0, error));
    }
    let problem = Problem::new(&rig, &condition, &start);
    for tolerance in TOLERANCES {
        let Ok(solution) = problem.solve(tolerance) else { continue };
        let error = difference(&solution, &fine);
        if error <= TARGET || tolerance == TOLERANCES[TOLERANCES.len() - 1] {
            let took = median(|| problem.solve(tolerance).map(|_| ()))?;
            rows.push((format!("ode_solvers DOPRI5, rtol {tolerance:.0e}"), took, error));
            break;
        }
    }
    match scipy(&problem, &fine) {
        Ok(peers) => rows.extend(peers),
        Err(error) => eprintln!("SciPy left out: {error}"),
    }

    println!("9 balls, {seconds} s at {RATE} Hz on one core, median of {RUNS} runs (SciPy: of 3)");
    println!("{:<44}{:>14}{:>14}{:>14}{:>10}", "", "s per run", "x real time", "RMS m/s^2", "ratio");
    for (name, took, error) in &rows {
        println!("{name:<44}{took:>14.5}{:>14.1}{error:>14.1e}{:>10.1}", seconds / took, took / alone);
    }
    Ok(())
}

/// What acts within the loop: on forces, or on what each ball has.
fn effects() -> [EffectEntry; 4] {
    [
        EffectEntry::new(EffectKind::LoadStep, &[(ParameterKey::TimeS, 0.05), (ParameterKey::ChangeN, 100.0)]),
        EffectEntry::new(EffectKind::HardeningStiffness, &[(ParameterKey::CubicNPerM3, 1e16)])
            .with_text(ParameterKey::Component, "outer"),
        EffectEntry::new(
            EffectKind::OuterRaceWaviness,
            &[(ParameterKey::Lobes, 7.0), (ParameterKey::AmplitudeM, 1e-7)],
        ),
        EffectEntry::new(
            EffectKind::OuterRaceDefect,
            &[(ParameterKey::AngleRad, 4.7), (ParameterKey::WidthRad, 0.05), (ParameterKey::DepthM, 5e-6)],
        ),
    ]
}

fn ours(rig: &Rig, condition: &OperatingCondition, start: &Start) -> Result<Accelerations> {
    let recording = simulate(rig, condition, start)?;
    let mut channels = recording.channels.into_iter().map(|c| c.samples);
    Ok([channels.next().unwrap_or_default(), channels.next().unwrap_or_default()])
}

fn difference(a: &Accelerations, b: &Accelerations) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    (pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / (2 * SAMPLES) as f64).sqrt()
}

fn median(mut run: impl FnMut() -> Result<()>) -> Result<f64> {
    let mut took = [Duration::ZERO; RUNS];
    run()?;
    for took in &mut took {
        let start = Instant::now();
        run()?;
        *took = start.elapsed();
    }
    took.sort();
    Ok(took[RUNS / 2].as_secs_f64())
}

/// The rig's numbers in the order in which both peers take them.
#[derive(Clone, Copy)]
struct Problem {
    balls: usize,
    /// m_s, k_s, c_s, m_p, k_p, c_p, m_r, k_r, c_r.
    supports: [f64; 9],
    /// k_b, c, m e, F_load, ω, ω_c, ψ₀, φ₀ at the start.
    drive: [f64; 8],
}

impl Problem {
    fn new(rig: &Rig, condition: &OperatingCondition, start: &Start) -> Self {
        let Machine::Bearing(rig) = &rig.model else { panic!("a bearing rig") };
        let omega = std::f64::consts::TAU * condition.shaft_hz;
        let cage = omega * rig.bearing.geometry().orders().ftf;
        let [s, p, r] =
            [&rig.inner, &rig.outer, &rig.resonator].map(|s| [s.mass_kg, s.stiffness_n_per_m, s.damping_n_s_per_m]);
        Self {
            balls: rig.bearing.balls,
            supports: [s[0], s[1], s[2], p[0], p[1], p[2], r[0], r[1], r[2]],
            drive: [
                rig.bearing.contact_stiffness_n_per_m1_5,
                rig.bearing.radial_clearance_m,
                rig.excitation.unbalance_kg_m,
                condition.load_n,
                omega,
                cage,
                start.shaft_angle0_rad - omega * start.settle_s,
                start.cage_angle0_rad - cage * start.settle_s,
            ],
        }
    }

    /// Positions x_s, x_p, y_s, y_p, y_b, then velocities.
    fn derivative(&self, t: f64, z: &State) -> State {
        let [ms, ks, cs, mp, kp, cp, mr, kr, cr] = self.supports;
        let [kb, clearance, unbalance, load, omega, cage, shaft0, cage0] = self.drive;
        let (x, y) = (z[0] - z[1], z[2] - z[3]);
        let (mut fx, mut fy) = (0.0, 0.0);
        for j in 0..self.balls {
            let (s, c) = (cage0 + cage * t + std::f64::consts::TAU * j as f64 / self.balls as f64).sin_cos();
            let deflection = x * c + y * s - clearance;
            if deflection > 0.0 {
                let force = kb * deflection * deflection.sqrt();
                fx += force * c;
                fy += force * s;
            }
        }
        let (s, c) = (shaft0 + omega * t).sin_cos();
        let centrifugal = unbalance * omega * omega;
        let spring = kr * (z[4] - z[3]) + cr * (z[9] - z[8]);
        let a = [
            (centrifugal * c - fx - cs * z[5] - ks * z[0]) / ms,
            (fx - cp * z[6] - kp * z[1]) / mp,
            (load - ms * GRAVITY + centrifugal * s - fy - cs * z[7] - ks * z[2]) / ms,
            (fy - cp * z[8] - kp * z[3] + spring) / mp,
            -spring / mr - GRAVITY,
        ];
        State::from_fn(|k, _| if k < 5 { z[k + 5] } else { a[k - 5] })
    }

    fn solve(&self, tolerance: f64) -> Result<Accelerations> {
        let end = (2 * SAMPLES) as f64 / RATE;
        let absolute = tolerance * ABSOLUTE_PER_RELATIVE;
        // The defaults, but for the test that would call this stiff at its first corner and give up.
        let (steps, output) = (10_000_000, OutputType::Dense);
        let mut solver = Dopri5::from_param(
            *self,
            0.0,
            end,
            1.0 / RATE,
            State::zeros(),
            tolerance,
            absolute,
            0.9,
            0.04,
            0.2,
            10.0,
            end,
            0.0,
            steps,
            u32::MAX,
            output,
        );
        solver.integrate().map_err(|error| error.to_string())?;
        let rows = solver.x_out().iter().zip(solver.y_out()).skip(SAMPLES).take(SAMPLES);
        let accelerations = rows.map(|(t, z)| self.derivative(*t, z)).map(|d| (d[6], d[9]));
        let (ax, ay) = accelerations.unzip();
        Ok([ax, ay])
    }
}

impl System<f64, State> for Problem {
    fn system(&self, t: f64, z: &State, derivative: &mut State) {
        *derivative = self.derivative(t, z);
    }
}

/// Name, seconds and error of each SciPy method.
fn scipy(problem: &Problem, fine: &Accelerations) -> Result<Vec<(String, f64, f64)>> {
    let python = env::var_os("BALLRACE_PYTHON").unwrap_or_else(|| "python3".into());
    let mut reference = tempfile::NamedTempFile::new()?;
    for value in fine.iter().flatten() {
        reference.write_all(&value.to_le_bytes())?;
    }
    reference.flush()?;
    let numbers =
        problem.supports.iter().chain(&problem.drive).chain([&GRAVITY, &RATE, &TARGET, &ABSOLUTE_PER_RELATIVE]);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/rig_peer.py");
    let output = Command::new(python)
        .arg(script)
        .arg(reference.path())
        .arg(problem.balls.to_string())
        .args(numbers.map(|v| format!("{v:?}")))
        .env("OMP_NUM_THREADS", "1")
        .output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
    }
    let rows = String::from_utf8(output.stdout)?;
    rows.lines()
        .map(|row| {
            let mut fields = row.split('\t');
            let mut next = || fields.next().ok_or("a short row");
            Ok((next()?.to_owned(), next()?.parse()?, next()?.parse()?))
        })
        .collect()
}
