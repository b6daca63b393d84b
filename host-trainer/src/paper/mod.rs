//! Numbers of the paper whose method this is: Z. Fang et al., "Bearing Dynamics Identification with SINDy-Based Neural Network
//! and Physics Model", Machines 14 (2026) 620.

/// Bearing of the paper's Table 5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgedBearing {
    /// Name of its folder.
    pub folder: &'static str,
    /// Recordings in its aging phase.
    pub aging_recordings: usize,
    /// Mean R² over them.
    pub r2: f64,
    /// Standard deviation of R² over them.
    pub r2_std: f64,
}

/// Bearing of Table 5 by the name of its folder, such as `Bearing3_3`.
pub fn aged_bearing(folder: &str) -> Option<AgedBearing> {
    TABLE_5.into_iter().find(|bearing| bearing.folder == folder)
}

const fn bearing(folder: &'static str, aging_recordings: usize, r2: f64, r2_std: f64) -> AgedBearing {
    AgedBearing { folder, aging_recordings, r2, r2_std }
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
    /// Time of its training, s.
    pub seconds: f64,
}

const fn library(name: &'static str, sizes: [usize; 3], functions: usize, r2: f64, seconds: f64) -> PaperLibrary {
    PaperLibrary { name, sizes, functions, r2, seconds }
}

/// Libraries of Table 3.
pub const TABLE_3: [PaperLibrary; 21] = [
    library("1", [1, 8, 1], 25, 0.9232, 2.37),
    library("2", [1, 8, 2], 41, 0.9237, 4.09),
    library("3", [1, 8, 3], 57, 0.9243, 6.25),
    library("4", [1, 8, 4], 73, 0.9247, 8.29),
    library("5", [1, 8, 5], 89, 0.9253, 9.81),
    library("6", [2, 7, 1], 50, 0.9231, 4.20),
    library("7", [2, 7, 2], 64, 0.9236, 6.03),
    library("8", [2, 7, 3], 78, 0.9241, 7.68),
    library("9", [2, 7, 4], 92, 0.9245, 9.85),
    library("10", [2, 8, 1], 61, 0.9251, 8.47),
    library("11", [2, 8, 2], 77, 0.9256, 9.68),
    library("12", [3, 5, 1], 66, 0.9108, 4.39),
    library("13", [3, 5, 2], 76, 0.9112, 5.17),
    library("14", [3, 5, 3], 86, 0.9116, 6.49),
    library("15", [3, 5, 4], 96, 0.9119, 7.82),
    library("16", [3, 5, 5], 106, 0.9123, 8.71),
    library("17", [3, 5, 6], 116, 0.9127, 9.59),
    library("18", [3, 6, 1], 96, 0.9209, 14.08),
    library("Base_Poly1", [5, 4, 0], 126, 0.9037, 10.40),
    library("Base_Poly2", [9, 4, 0], 715, 0.9243, 660.29),
    library("Base_Fourier", [0, 4, 316], 2528, 0.9032, 2002.42),
];

const TABLE_5: [AgedBearing; 9] = [
    bearing("Bearing1_2", 796, 0.9415, 0.0343),
    bearing("Bearing1_3", 764, 0.9210, 0.0424),
    bearing("Bearing1_4", 343, 0.9351, 0.0247),
    bearing("Bearing2_3", 1543, 0.8768, 0.0576),
    bearing("Bearing2_4", 375, 0.8608, 0.0394),
    bearing("Bearing2_7", 224, 0.8666, 0.0497),
    bearing("Bearing3_1", 46, 0.8937, 0.0350),
    bearing("Bearing3_2", 70, 0.8694, 0.0366),
    bearing("Bearing3_3", 126, 0.9256, 0.0337),
];

/// Model of the paper's Table 4, on Bearing 3_3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperModel {
    /// Name.
    pub name: &'static str,
    /// R².
    pub r2: f64,
    /// Time of its training, s.
    pub seconds: f64,
}

/// Models of Table 4.
pub const TABLE_4: [PaperModel; 4] = [
    PaperModel { name: "LSTM", r2: 0.9747, seconds: 25.54 },
    PaperModel { name: "TCN", r2: 0.5549, seconds: 233.15 },
    PaperModel { name: "PatchTransformer", r2: 0.7526, seconds: 216.20 },
    PaperModel { name: "SINDy-NN", r2: 0.9256, seconds: 9.68 },
];
