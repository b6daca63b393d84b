//! A stop on one side: nothing up to q = gap, a spring beyond (S. W. Shaw, P. J. Holmes, "A periodically forced
//! piecewise linear oscillator", J. Sound Vib. 90 (1983) 129–155; rub and looseness alike: P. Goldman, A. Muszynska,
//! "Chaotic behavior of rotor/stator systems with rubs", J. Eng. Gas Turbines Power 116 (1994) 692–701). The gap is
//! counted from the unloaded position in the direction of +q, which for y is that of the load.

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
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
    ],
    library: LibraryTerms::EVEN,
    equation: |v| {
        let (gap, stiffness) = (v.number(ParameterKey::GapM), v.number(ParameterKey::StiffnessNPerM));
        format!("… + {stiffness:.4e} N/m · max(q − {gap:.4e} m, 0) = …, q = {}", v.component().symbols())
    },
    apply: |v, assembly| {
        let (gap, stiffness) = (v.number(ParameterKey::GapM), v.number(ParameterKey::StiffnessNPerM));
        if stiffness == 0.0 {
            return;
        }
        let part = v.component().part_of(&assembly.machine);
        // Landing and leaving are corners: several steps in the time the stop takes to throw the mass back.
        assembly.declare_rate(3.0 * (stiffness / part.mass).sqrt());
        part.law(assembly, move |q, _| -stiffness * (q - gap).max(0.0));
    },
};
