//! A white random force that the rig leaves out, as of a flow: in each direction of a component one of its own.

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::Choices,
};
use crate::rig::{assembly::RandomForce, config::Domain, state::DOFS};

pub(super) const EFFECT: Definition = Definition {
    name: "random-force",
    rigs: Rigs::Bearing,
    site: Site::Force,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::PsdN2PerHz, "N²/Hz", Domain::NotNegative, (1e-8, 1e4), Scale::Log),
        Parameter::component(Choices::Supported).usually(ParameterDefault::Name("outer")),
    ],
    library: LibraryTerms::OUTSIDE,
    equation: |v| {
        let psd = v.number(ParameterKey::PsdN2PerHz);
        format!("m q̈ + … = … + w(t), w white of {psd:.4e} N²/Hz, q = {}", v.component().symbols())
    },
    apply: |v, assembly| {
        let psd_n2_per_hz = v.number(ParameterKey::PsdN2PerHz);
        if psd_n2_per_hz > 0.0 {
            for motion in v.component().part_of(&assembly.machine).motions {
                let mut direction = [0.0; DOFS];
                motion.push(1.0, &mut direction);
                assembly.random_forces.push(RandomForce { direction, psd_n2_per_hz });
            }
        }
    },
};
