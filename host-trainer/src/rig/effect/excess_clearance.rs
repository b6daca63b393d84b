//! Radial clearance c above nominal: a narrower load zone, fewer and more heavily loaded balls, more vibration at
//! BPFO (M. Tiwari, K. Gupta, O. Prakash, "Effect of radial internal clearance of a ball bearing on the dynamics of a
//! balanced horizontal rotor", J. Sound Vib. 238 (2000) 723–756).

use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "excess-clearance",
    rigs: Rigs::Bearing,
    site: Site::Contact,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[Parameter::number(ParameterKey::RadialClearanceM, "m", Domain::Any, (1e-6, 2e-4), Scale::Log)],
    library: LibraryTerms::EVEN,
    equation: |v| {
        format!("δ_j = (x_s−x_p) cos φ_j + (y_s−y_p) sin φ_j − {:.4e} m", v.number(ParameterKey::RadialClearanceM))
    },
    apply: |v, assembly| {
        if let Some(rig) = assembly.bearing() {
            rig.bearing.radial_clearance_m = v.number(ParameterKey::RadialClearanceM);
        }
    },
};
