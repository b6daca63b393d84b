//! A force against the motion that grows with the square of the speed, −d v |v|, as of a fluid pushed aside
//! (A. H. Nayfeh, D. T. Mook, "Nonlinear Oscillations", 1979, section 3.3): of each direction's speed by itself, or of the
//! whole speed.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_2_PI, FRAC_PI_2, TAU};

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::{Choices, Motion, Part},
    erf::erf,
};
use crate::rig::assembly::Assembly;
use crate::rig::config::Domain;
use crate::rig::state::VelocityCovariance;

pub(super) const EFFECT: Definition = Definition {
    name: "quadratic-drag",
    rigs: Rigs::Both,
    site: Site::Force,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::DragNS2PerM2, "N s²/m²", Domain::NotNegative, (1e-1, 1e9), Scale::Log),
        Parameter::component(Choices::Supported).usually(ParameterDefault::Name("outer")),
        Parameter::symmetry(),
    ],
    library: LibraryTerms::ODD,
    equation: |v| {
        let of = if v.is_isotropic() { ", |q̇|: speed over all directions" } else { "" };
        let drag = v.number(ParameterKey::DragNS2PerM2);
        format!("… + {drag:.4e} N s²/m² · q̇ |q̇| = …, q = {}{of}", v.component().symbols())
    },
    apply: |v, assembly| {
        let drag = v.number(ParameterKey::DragNS2PerM2);
        let part = v.component().part_of(&assembly.machine);
        if drag != 0.0 && v.is_isotropic() && part.motions.len() > 1 {
            isotropic(part, drag, assembly);
        } else if drag != 0.0 {
            part.speed_law(
                assembly,
                move |v| -drag * v * v.abs(),
                |scatter| move |v| -drag * mean_square(v, scatter),
                // The mean's slope at rest, and the law's at a standard deviation.
                move |scatter| 2.0 * drag * scatter,
            );
        }
    },
};

/// Drag of the whole speed, −d |v| v. Where noise scatters the velocity its mean is that of a speed √(|v|² + s²), with the mean's
/// own slope at rest, d s, theory (47).
fn isotropic(part: Part, drag: f64, assembly: &mut Assembly) {
    assembly.depends_on_velocity_noise = true;
    let rest = match &assembly.velocity_covariance {
        Some(covariance) => slopes_at_rest(&part.motions, covariance),
        None => vec![0.0; part.motions.len()],
    };
    rest.iter().for_each(|slope| assembly.declare_rate(drag * slope / part.mass));
    let each: Vec<(Motion, f64)> = part.motions.into_iter().zip(rest).collect();
    assembly.force(move |_, _, v, force| {
        let square = each.iter().map(|(motion, _)| motion.relative(v).powi(2)).sum::<f64>();
        for (motion, slope) in &each {
            motion.push(-drag * (square + slope * slope).sqrt() * motion.relative(v), force);
        }
    });
}

/// Slope of the mean of |v| v at rest in each of two motions, m/s: the mean of |v| + v_i²/|v| over normal velocities, whose length
/// in whitened directions is Rayleigh's.
fn slopes_at_rest(motions: &[Motion], covariance: &VelocityCovariance) -> Vec<f64> {
    const DIRECTIONS: u32 = 64;
    let [first, second] = [motions[0], motions[1]];
    let of = |a: Motion, b: Motion| a.covariance(b, covariance);
    let std = of(first, first).max(0.0).sqrt();
    let along = if std > 0.0 { of(first, second) / std } else { 0.0 };
    let across = (of(second, second) - along * along).max(0.0).sqrt();
    let mut slopes = vec![0.0; 2];
    for n in 0..DIRECTIONS {
        let (sin, cos) = (f64::from(n) * TAU / f64::from(DIRECTIONS)).sin_cos();
        let v = [std * cos, along * cos + across * sin];
        let speed = v[0].hypot(v[1]).max(f64::MIN_POSITIVE);
        let rayleigh = FRAC_PI_2.sqrt() / f64::from(DIRECTIONS);
        slopes.iter_mut().zip(v).for_each(|(slope, v)| *slope += rayleigh * (speed + v * v / speed));
    }
    slopes
}

/// Mean of v |v| over a normal distribution about v.
fn mean_square(v: f64, scatter: f64) -> f64 {
    if scatter == 0.0 {
        return v * v.abs();
    }
    let z = v / scatter;
    let density = (-0.5 * z * z).exp() * FRAC_2_PI.sqrt();
    scatter.powi(2) * ((z * z + 1.0) * erf(z * FRAC_1_SQRT_2) + z * density)
}
