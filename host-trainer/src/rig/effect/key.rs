//! Names of effects' parameters.

use std::fmt;

macro_rules! keys {
    ($($kind:ident = $name:literal, $doc:literal;)*) => {
        /// Name of a parameter of an effect. Its ending is its unit; in the order of the names.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum ParameterKey {
            $(#[doc = $doc] $kind,)*
        }

        impl ParameterKey {
            /// All keys.
            pub const ALL: &[Self] = &[$(Self::$kind),*];

            /// The name in files.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)*
                }
            }
        }
    };
}

keys! {
    AboveCos = "above_cos", "Amplitude of the cosine of one lobe more, as a share of the lobes' own.";
    AboveSin = "above_sin", "Amplitude of the sine of one lobe more, as a share of the lobes' own.";
    Amplitude = "amplitude", "Amplitude of an electrical line, in the unit of the signal.";
    AmplitudeM = "amplitude_m", "Amplitude of a race's waviness, m.";
    AngleRad = "angle_rad", "Angle of a defect on its race, or of a force from its direction, rad.";
    BelowCos = "below_cos", "Amplitude of the cosine of one lobe less, as a share of the lobes' own.";
    BelowSin = "below_sin", "Amplitude of the sine of one lobe less, as a share of the lobes' own.";
    ChangeN = "change_n", "Change of the load, N.";
    Channel = "channel", "Channel that a fault of the acquisition is in.";
    Component = "component", "Component of the rig that an effect acts on.";
    Count = "count", "Count of samples.";
    CubicNPerM3 = "cubic_n_per_m3", "Coefficient of a cubic spring, N/m³.";
    DampingNSPerM = "damping_n_s_per_m", "Viscous damping, N s/m.";
    DampingRatio = "damping_ratio", "Damping as a fraction of critical damping.";
    DeflectionM = "deflection_m", "Deflection at which a contact of another exponent has the nominal force, m.";
    DepthM = "depth_m", "Depth of a defect, m.";
    DragNS2PerM2 = "drag_n_s2_per_m2", "Quadratic drag, N s²/m².";
    DurationS = "duration_s", "Duration, s.";
    Exponent = "exponent", "Exponent of the contact law.";
    Flank = "flank", "Share of a defect's width that each flank takes; 0 for a half sine over all of it.";
    ForceN = "force_n", "Force, N.";
    Fraction = "fraction", "Fraction of the cage's kinematic speed that slip takes away.";
    FrequencyHz = "frequency_hz", "Frequency, Hz.";
    Gain = "gain", "Modal constant, as a multiple of one over the housing's mass.";
    GainAcross = "gain_across", "Modal constant of the same mode at the sensor across, as a multiple of one over the housing's mass.";
    GapM = "gap_m", "Gap to an end stop, m.";
    ImpulseNS = "impulse_n_s", "Impulse, N s.";
    Lobes = "lobes", "Lobes of a race around its circumference.";
    PhaseRad = "phase_rad", "Phase, rad.";
    PhaseYRad = "phase_y_rad", "Phase of a force's vertical part beyond that of a rotating force, rad.";
    PressureViscosityPerPa = "pressure_viscosity_per_pa", "Pressure–viscosity coefficient of a lubricant, 1/Pa.";
    PsdN2PerHz = "psd_n2_per_hz", "One-sided power spectral density of a random force, N²/Hz.";
    QuadraticNPerM2 = "quadratic_n_per_m2", "Coefficient of a quadratic spring, N/m².";
    RadialClearanceM = "radial_clearance_m", "Radial clearance, m.";
    RatePerS = "rate_per_s", "Relative rate of change, 1/s.";
    RegularisationMPerS = "regularisation_m_per_s", "Speed below which dry friction is rounded, m/s.";
    RiseS = "rise_s", "Duration of a change, s.";
    SaturationPerM2 = "saturation_per_m2", "Saturation of a spring's nonlinear part: one over the square of the displacement at which half of it is left, 1/m².";
    Shape = "shape", "Course of a change over its duration.";
    Source = "source", "What excites a mode of the structure.";
    SpinRad = "spin_rad", "Angle of a ball about its own axis at shaft angle 0, rad.";
    StiffnessNPerM = "stiffness_n_per_m", "Stiffness, N/m.";
    Symmetry = "symmetry", "Whether a law holds along each axis by itself, or is the same in every direction.";
    TimeS = "time_s", "Time from the first sample, s.";
    UnbalanceKgM = "unbalance_kg_m", "Unbalance, kg m.";
    Value = "value", "Value of the quantity that is changed, in its own unit.";
    ViscosityPaS = "viscosity_pa_s", "Dynamic viscosity of a lubricant, Pa s.";
    WidthM = "width_m", "Width of a dead zone, m.";
    WidthRad = "width_rad", "Angular width of a defect, rad.";
}

impl ParameterKey {
    /// The key of this name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|key| key.name() == name)
    }
}

impl fmt::Display for ParameterKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_keys_are_in_the_order_of_their_names() {
        assert!(ParameterKey::ALL.is_sorted_by_key(|key| key.name()));
    }
}
