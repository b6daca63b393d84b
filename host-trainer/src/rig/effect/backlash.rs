//! Play in the support: its spring does nothing over a width and pulls beyond it, k dz(q) instead of k q
//! (A. Kahraman, R. Singh, "Non-linear dynamics of a spur gear pair", J. Sound Vib. 142 (1990) 49–75).

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::Choices,
};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "backlash",
    rigs: Rigs::Both,
    site: Site::Structure,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::WidthM, "m", Domain::NotNegative, (1e-7, 1e-1), Scale::Log),
        Parameter::component(Choices::Supported).usually(ParameterDefault::Name("outer")),
    ],
    library: LibraryTerms::ODD,
    equation: |v| {
        let half = 0.5 * v.number(ParameterKey::WidthM);
        format!("k q becomes k (q − clamp(q, ±{half:.4e} m)), q = {}", v.component().symbols())
    },
    apply: |v, assembly| {
        let half = 0.5 * v.number(ParameterKey::WidthM);
        if half == 0.0 {
            return;
        }
        let part = v.component().part_of(&assembly.machine);
        let stiffness = part.stiffness;
        assembly.declare_rate(3.0 * (stiffness / part.mass).sqrt());
        // Gives back what the linear part of the rig takes off inside the play.
        part.law(assembly, move |q, _| stiffness * q.clamp(-half, half));
    },
};
