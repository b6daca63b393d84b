//! Lobes on the inner race, turning with the shaft: lines at multiples of BPFI, and with lobes one off a multiple of
//! the number of balls at these ± the shaft speed
//! (F. P. Wardle, "Vibration forces produced by waviness of the rolling surfaces of thrust loaded ball bearings,
//! Part 1: theory", Proc. IMechE C 202 (1988) 305–312; S. P. Harsha et al., "Non-linear dynamic behaviors of rolling
//! element bearings due to surface waviness", J. Sound Vib. 272 (2004) 557–580). A load zone adds its own multiples.

use super::{Definition, LibraryTerms, Phase, Rigs, Site, Timing, waviness};

pub(super) const EFFECT: Definition = Definition {
    name: "inner-race-waviness",
    rigs: Rigs::Bearing,
    site: Site::Contact,
    timing: Timing::Persistent,
    phase: Phase::Shaft,
    is_deterministic: true,
    parameters: waviness::PARAMETERS,
    library: LibraryTerms::ANGLE,
    equation: |v| waviness::equation(v, "(φ_j − ψ)"),
    apply: |v, assembly| waviness::apply(v, assembly, |at| at.cage_rad - at.shaft_rad),
};
