//! A stop on one side: nothing up to q = gap, a spring beyond (S. W. Shaw, P. J. Holmes, "A periodically forced
//! piecewise linear oscillator", J. Sound Vib. 90 (1983) 129–155; rub and looseness alike: P. Goldman, A. Muszynska,
//! "Chaotic behavior of rotor/stator systems with rubs", J. Eng. Gas Turbines Power 116 (1994) 692–701). The gap is
//! counted from the unloaded position in the direction of +q, which for y is that of the load. A damper beside the spring takes
//! energy from the impact (Kelvin–Voigt; the force ends where it would pull: K. H. Hunt, F. R. E. Crossley, "Coefficient of
//! restitution interpreted as damping in vibroimpact", J. Appl. Mech. 42 (1975) 440–445).

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing, Values,
    component::Choices,
};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "end-stop-contact",
    rigs: Rigs::Both,
    site: Site::Force,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::GapM, "m", Domain::Any, (1e-7, 1e-1), Scale::Log),
        Parameter::number(ParameterKey::StiffnessNPerM, "N/m", Domain::NotNegative, (1e3, 1e10), Scale::Log),
        Parameter::component(Choices::Supported).usually(ParameterDefault::Name("outer-y")),
        Parameter::number(ParameterKey::DampingNSPerM, "N s/m", Domain::NotNegative, (1e-1, 1e6), Scale::Log)
            .usually(ParameterDefault::Number(0.0)),
    ],
    library: LibraryTerms::EVEN,
    equation: |v| {
        let [gap, stiffness, damping] = numbers(v);
        let into = format!("q − {gap:.4e} m");
        let law = if damping == 0.0 {
            format!("{stiffness:.4e} N/m · max({into}, 0)")
        } else {
            format!("max({stiffness:.4e} N/m · ({into}) + {damping:.4e} N s/m · q̇, 0) where q > {gap:.4e} m")
        };
        format!("… + {law} = …, q = {}", v.component().symbols())
    },
    apply: |v, assembly| {
        let [gap, stiffness, damping] = numbers(v);
        if stiffness == 0.0 {
            return;
        }
        let part = v.component().part_of(&assembly.machine);
        // Landing and leaving are corners: several steps in the time the stop takes to throw the mass back.
        assembly.declare_rate((3.0 * (stiffness / part.mass).sqrt()).max(2.0 * damping / part.mass));
        part.law(assembly, move |q, v| {
            let into = q - gap;
            if into > 0.0 { -(stiffness * into + damping * v).max(0.0) } else { 0.0 }
        });
    },
};

/// Gap, m, stiffness, N/m, and damping, N s/m.
fn numbers(v: &Values) -> [f64; 3] {
    [ParameterKey::GapM, ParameterKey::StiffnessNPerM, ParameterKey::DampingNSPerM].map(|key| v.number(key))
}
