//! Numbers of the paper whose method this is: Z. Fang et al., "Bearing Dynamics Identification with SINDy-Based Neural Network
//! and Physics Model", Machines 14 (2026) 620.

/// Bearing of the paper's Table 5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgedBearing {
    /// Name of its folder.
    pub folder: &'static str,
    /// Recordings in its aging phase.
    pub aging_recordings: usize,
}

/// Bearing of Table 5 by the name of its folder, such as `Bearing3_3`.
pub fn aged_bearing(folder: &str) -> Option<AgedBearing> {
    TABLE_5.into_iter().find(|bearing| bearing.folder == folder)
}

const fn bearing(folder: &'static str, aging_recordings: usize) -> AgedBearing {
    AgedBearing { folder, aging_recordings }
}

const TABLE_5: [AgedBearing; 9] = [
    bearing("Bearing1_2", 796),
    bearing("Bearing1_3", 764),
    bearing("Bearing1_4", 343),
    bearing("Bearing2_3", 1543),
    bearing("Bearing2_4", 375),
    bearing("Bearing2_7", 224),
    bearing("Bearing3_1", 46),
    bearing("Bearing3_2", 70),
    bearing("Bearing3_3", 126),
];
