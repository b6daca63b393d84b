//! Networks with random weights in every form that a peer takes, for `peers.sh`, and the error of what a peer gives.
//!
//! `cargo run --example peer_networks -- write DIR HIDDEN` writes DIR: `float.bin` and `fixed.bin` (words of ballrace-core),
//! `sizes.rs`, `network.h` (8- and 16-bit weights of CMSIS-NN, inputs), `weights.txt` (for emlearn), `expected.txt` (outputs
//! in double precision, a line a row of inputs). `... check DIR OUTPUT` prints the root mean square error of a peer's outputs
//! over the root mean square of the outputs.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use ballrace_core::Word;
use ballrace_core::network::{Arithmetic, Network, fixed, float, to_fixed};

#[path = "../tests/common/mod.rs"]
mod common;

const INPUTS: usize = 8;
const OUTPUTS: usize = 8;
const ROWS: usize = 64;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["write", directory, hidden] => write(Path::new(directory), hidden.parse()?),
        ["check", directory, output] => check(Path::new(directory), output),
        _ => Err("expected write DIR HIDDEN, or check DIR OUTPUT".into()),
    }
}

/// Weights row by row, an output each, and biases.
struct Layer {
    weights: Vec<Vec<f32>>,
    biases: Vec<f32>,
}

impl Layer {
    fn random(inputs: usize, outputs: usize, noise: &mut common::Noise) -> Self {
        let mut numbers = |count: usize| (0..count).map(|_| 0.5 * noise.next()).collect::<Vec<_>>();
        Self { weights: (0..outputs).map(|_| numbers(inputs)).collect(), biases: numbers(outputs) }
    }

    fn apply(&self, x: &[f64]) -> Vec<f64> {
        let sum = |row: &Vec<f32>| row.iter().zip(x).map(|(w, x)| f64::from(*w) * x).sum::<f64>();
        self.weights.iter().zip(&self.biases).map(|(row, bias)| sum(row) + f64::from(*bias)).collect()
    }

    fn words(&self, inputs: usize) -> Vec<Word> {
        let outputs = self.weights.len();
        let mut words = vec![[0; 4]; inputs * outputs];
        for (o, row) in self.weights.iter().enumerate() {
            for (i, weight) in row.iter().enumerate() {
                words[float::weight_index(inputs, outputs, o, i)] = weight.to_le_bytes();
            }
        }
        words.extend(self.biases.iter().map(|bias| bias.to_le_bytes()));
        words
    }

    fn greatest(&self) -> f64 {
        greatest(self.weights.iter().flatten().map(|w| f64::from(*w)))
    }
}

fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |greatest, value| greatest.max(value.abs()))
}

fn write(directory: &Path, hidden: usize) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(directory)?;
    let mut noise = common::Noise(11);
    let (up, down) = (Layer::random(INPUTS, hidden, &mut noise), Layer::random(hidden, OUTPUTS, &mut noise));
    let inputs: Vec<Vec<f32>> = (0..ROWS).map(|_| (0..INPUTS).map(|_| 2.0 * noise.next()).collect()).collect();

    let words = [up.words(INPUTS), down.words(hidden)].concat();
    let widths = [INPUTS as u16, hidden as u16, OUTPUTS as u16];
    let network = Network::new(&widths, Arithmetic::Float, &words).ok_or("widths out of range")?;
    let mut fixed_words = vec![[0; 4]; fixed::word_count(&widths).ok_or("no fixed-point form")?];
    to_fixed(&network, &mut fixed_words).map_err(|error| format!("{error:?}"))?;
    fs::write(directory.join("float.bin"), words.as_flattened())?;
    fs::write(directory.join("fixed.bin"), fixed_words.as_flattened())?;

    let doubles: Vec<Vec<f64>> = inputs.iter().map(|row| row.iter().map(|x| f64::from(*x)).collect()).collect();
    let arguments: Vec<Vec<f64>> = doubles.iter().map(|x| up.apply(x)).collect();
    let sigmoid = |a: &f64| 1.0 / (1.0 + (-a).exp());
    let expected: Vec<Vec<f64>> =
        arguments.iter().map(|a| down.apply(&a.iter().map(sigmoid).collect::<Vec<_>>())).collect();
    let line = |row: &Vec<f64>| row.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    fs::write(directory.join("expected.txt"), expected.iter().map(line).collect::<Vec<_>>().join("\n"))?;

    let mut text = String::new();
    for layer in [&up, &down] {
        for row in layer.weights.iter().chain([&layer.biases]) {
            writeln!(text, "{}", row.iter().map(f32::to_string).collect::<Vec<_>>().join(" "))?;
        }
        text.push('\n');
    }
    fs::write(directory.join("weights.txt"), text)?;

    // nalgebra's matrices are column by column.
    let columns = |layer: &Layer, inputs: usize| -> Vec<Vec<f32>> {
        (0..inputs).map(|i| layer.weights.iter().map(|row| row[i]).collect()).collect()
    };
    let sizes = format!(
        "const INPUTS: usize = {INPUTS};\nconst HIDDEN: usize = {hidden};\nconst OUTPUTS: usize = {OUTPUTS};\n\
         #[cfg(any(feature = \"nalgebra\", feature = \"burn\"))]\nconst UP: [[f32; HIDDEN]; INPUTS] = {:?};\n\
         #[cfg(any(feature = \"nalgebra\", feature = \"burn\"))]\nconst UP_BIAS: [f32; HIDDEN] = {:?};\n\
         #[cfg(any(feature = \"nalgebra\", feature = \"burn\"))]\nconst DOWN: [[f32; OUTPUTS]; HIDDEN] = {:?};\n\
         #[cfg(any(feature = \"nalgebra\", feature = \"burn\"))]\nconst DOWN_BIAS: [f32; OUTPUTS] = {:?};\n",
        columns(&up, INPUTS),
        up.biases,
        columns(&down, hidden),
        down.biases
    );
    fs::write(directory.join("sizes.rs"), sizes)?;
    let ranges = Ranges {
        input: greatest(doubles.iter().flatten().copied()),
        argument: greatest(arguments.iter().flatten().copied()),
        output: greatest(expected.iter().flatten().copied()),
    };
    fs::write(directory.join("network.h"), header(&up, &down, &inputs, &ranges)?)?;
    Ok(())
}

/// Greatest magnitudes over the inputs, which the integer networks are scaled by.
struct Ranges {
    input: f64,
    argument: f64,
    output: f64,
}

/// Multiplier in 2⁻³¹ and shift of a scale, as CMSIS-NN takes them.
fn multiplier(scale: f64) -> (i32, i32) {
    let shift = scale.log2().floor() as i32 + 1;
    ((scale / 2f64.powi(shift) * 2f64.powi(31)).round().min(2f64.powi(31) - 1.0) as i32, shift)
}

fn array<T: std::fmt::Display>(kind: &str, name: &str, values: impl Iterator<Item = T>) -> String {
    let values: Vec<_> = values.map(|value| value.to_string()).collect();
    format!("static const {kind} {name}[] __attribute__((unused)) = {{{}}};\n", values.join(","))
}

fn header(up: &Layer, down: &Layer, inputs: &[Vec<f32>], ranges: &Ranges) -> Result<String, std::fmt::Error> {
    let mut text = String::from("#include <stdint.h>\n");
    writeln!(
        text,
        "enum {{ INPUTS = {INPUTS}, HIDDEN = {}, OUTPUTS = {OUTPUTS}, INPUT_ROWS = {ROWS} }};",
        up.biases.len()
    )?;
    let rows =
        inputs.iter().map(|row| format!("{{{}}}", row.iter().map(|x| format!("{x:e}f")).collect::<Vec<_>>().join(",")));
    text += "static const float network_inputs[][INPUTS] __attribute__((unused)) = {";
    text += &rows.collect::<Vec<_>>().join(",");
    text += "};\n";

    let (w1, w2) = (up.greatest() / 127.0, down.greatest() / 127.0);
    let weights = |layer: &Layer, unit: f64| {
        layer.weights.iter().flatten().map(move |w| (f64::from(*w) / unit).round() as i64).collect::<Vec<_>>()
    };
    text += &array("int8_t", "s8_weights1", weights(up, w1).into_iter());
    text += &array("int8_t", "s8_weights2", weights(down, w2).into_iter());
    let biases = |layer: &Layer, unit: f64| {
        layer.biases.iter().map(move |b| (f64::from(*b) / unit).round() as i64).collect::<Vec<_>>()
    };
    // Input, argument of the sigmoid, its value, output: what one integer step is worth.
    let s8 = [ranges.input / 127.0, ranges.argument / 127.0, 1.0 / 256.0, ranges.output / 127.0];
    // The table of the 16-bit sigmoid takes steps of 2⁻¹².
    let s16 = [ranges.input / 32767.0, 1.0 / 4096.0, 1.0 / 32768.0, ranges.output / 32767.0];
    for (name, kind, [x, a, h, y]) in [("s8", "int32_t", s8), ("s16", "int64_t", s16)] {
        text += &array(kind, &format!("{name}_biases1"), biases(up, x * w1).into_iter());
        text += &array(kind, &format!("{name}_biases2"), biases(down, h * w2).into_iter());
        let ((m1, k1), (m2, k2)) = (multiplier(x * w1 / a), multiplier(h * w2 / y));
        let upper = name.to_uppercase();
        writeln!(
            text,
            "enum {{ {upper}_MULTIPLIER1 = {m1}, {upper}_SHIFT1 = {k1}, {upper}_MULTIPLIER2 = {m2}, {upper}_SHIFT2 = {k2} }};"
        )?;
        writeln!(text, "#define {upper}_INPUT_PER_UNIT {:e}f\n#define {upper}_UNIT_PER_OUTPUT {y:e}f", 1.0 / x)?;
    }
    let table = (0..256).map(|i| {
        let argument = f64::from(i as u8 as i8) * s8[1];
        (256.0 / (1.0 + (-argument).exp())).round().min(255.0) as i64 - 128
    });
    text += &array("int8_t", "s8_sigmoid", table);
    Ok(text)
}

fn check(directory: &Path, output: &str) -> Result<(), Box<dyn Error>> {
    let expected = fs::read_to_string(directory.join("expected.txt"))?;
    let expected: Vec<f64> = expected.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
    let output = fs::read_to_string(output)?;
    let words = output.lines().filter(|line| !line.starts_with("stack")).flat_map(str::split_whitespace);
    let found: Vec<f64> = words
        .map(|word| Ok(f64::from(f32::from_bits(u32::from_str_radix(word, 16)?))))
        .collect::<Result<_, std::num::ParseIntError>>()?;
    if found.len() != expected.len() {
        return Err(format!("{} outputs, expected {}", found.len(), expected.len()).into());
    }
    let power = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let error = power(&mut expected.iter().zip(&found).map(|(e, f)| e - f)) / power(&mut expected.iter().copied());
    println!("{:.1e}", error.sqrt());
    Ok(())
}
