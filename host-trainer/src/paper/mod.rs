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

/// Library of the paper's Table 3, fitted to Bearing 3_3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperLibrary {
    /// Name.
    pub name: &'static str,
    /// n_D, n_MD, n_F.
    pub sizes: [usize; 3],
    /// Number of functions.
    pub functions: usize,
    /// R².
    pub r2: f64,
}

const fn library(name: &'static str, sizes: [usize; 3], functions: usize, r2: f64) -> PaperLibrary {
    PaperLibrary { name, sizes, functions, r2 }
}

/// Libraries of Table 3.
pub const TABLE_3: [PaperLibrary; 21] = [
    library("1", [1, 8, 1], 25, 0.9232),
    library("2", [1, 8, 2], 41, 0.9237),
    library("3", [1, 8, 3], 57, 0.9243),
    library("4", [1, 8, 4], 73, 0.9247),
    library("5", [1, 8, 5], 89, 0.9253),
    library("6", [2, 7, 1], 50, 0.9231),
    library("7", [2, 7, 2], 64, 0.9236),
    library("8", [2, 7, 3], 78, 0.9241),
    library("9", [2, 7, 4], 92, 0.9245),
    library("10", [2, 8, 1], 61, 0.9251),
    library("11", [2, 8, 2], 77, 0.9256),
    library("12", [3, 5, 1], 66, 0.9108),
    library("13", [3, 5, 2], 76, 0.9112),
    library("14", [3, 5, 3], 86, 0.9116),
    library("15", [3, 5, 4], 96, 0.9119),
    library("16", [3, 5, 5], 106, 0.9123),
    library("17", [3, 5, 6], 116, 0.9127),
    library("18", [3, 6, 1], 96, 0.9209),
    library("Base_Poly1", [5, 4, 0], 126, 0.9037),
    library("Base_Poly2", [9, 4, 0], 715, 0.9243),
    library("Base_Fourier", [0, 4, 316], 2528, 0.9032),
];

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
