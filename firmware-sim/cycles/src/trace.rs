//! The executed instructions: their stages, times and sums, sample by sample.

use crate::instruction::{Flow, Instruction, Kind};
use crate::stage::{Place, Stage};
use crate::timing::{Access, Bound, Clock, Flash};

/// Number of stages.
pub const STAGES: usize = Stage::ALL.len();
/// Names of the clocks that every trace has; one with wait states may follow.
pub const CLOCKS: [(&str, Bound); 3] =
    [("cycles", Bound::Nominal), ("cycles_low", Bound::Low), ("cycles_high", Bound::High)];

/// Counts of a sample or of many, by stage.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Instructions by stage.
    pub instructions: [u64; STAGES],
    /// Cycles by clock and stage.
    pub cycles: Vec<[u64; STAGES]>,
}

impl Counts {
    fn new(clocks: usize) -> Self {
        Self { instructions: [0; STAGES], cycles: vec![[0; STAGES]; clocks] }
    }

    fn add(&mut self, other: &Self) {
        let sum = |to: &mut [u64; STAGES], from: &[u64; STAGES]| to.iter_mut().zip(from).for_each(|(to, n)| *to += n);
        sum(&mut self.instructions, &other.instructions);
        self.cycles.iter_mut().zip(&other.cycles).for_each(|(to, from)| sum(to, from));
    }

    /// Cycles of all stages by a clock.
    pub fn total(&self, clock: usize) -> u64 {
        self.cycles.get(clock).map_or(0, |cycles| cycles.iter().sum())
    }
}

/// Instructions after which a sample is none: the image does something else after its last.
const SAMPLE_LIMIT: u64 = 2_000_000;
/// First address of peripherals.
const PERIPHERALS: u32 = 0x4000_0000;

/// What ends a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sample {
    /// A reading of the image's instruction counter.
    Lap,
    /// The return from the function at this address; it begins with its call.
    Function(u32),
}

/// A function that has not returned.
#[derive(Clone, Copy, Debug)]
struct Frame {
    /// Where it returns to.
    back: u32,
    /// Stage of its call.
    stage: Stage,
}

/// Instructions of a run.
#[derive(Debug)]
pub struct Trace {
    sample: Sample,
    clocks: Vec<Clock>,
    calls: Vec<Frame>,
    /// Calls that the function to time lies in.
    depth: usize,
    pending: Option<(usize, Stage)>,
    accesses: Vec<Access>,
    /// Stage of the last floating-point division.
    dividing: Stage,
    /// Whether a sample has begun, what it took so far, and its instructions.
    running: bool,
    current: Counts,
    length: u64,
    samples: Vec<Counts>,
}

impl Trace {
    /// Trace before the first instruction; with wait states if there are any.
    pub fn new(sample: Sample, wait_states: u32, flash: Flash) -> Self {
        let mut clocks: Vec<_> = CLOCKS.iter().map(|(_, bound)| Clock::new(*bound)).collect();
        if wait_states > 0 {
            clocks.push(Clock::with_flash(wait_states, flash));
        }
        let current = Counts::new(clocks.len());
        let (calls, accesses, samples) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            sample,
            clocks,
            calls,
            depth: 0,
            pending: None,
            accesses,
            dividing: Stage::Other,
            running: false,
            current,
            length: 0,
            samples,
        }
    }

    /// Takes the next executed instruction, number `next` of `code`.
    pub fn execute(&mut self, code: &[(Instruction, Place)], next: usize) {
        let Some((it, place)) = code.get(next) else { return };
        if let Some((before, stage)) = self.pending
            && let Some((before, before_place)) = code.get(before)
        {
            if self.running {
                let at = stage as usize;
                self.current.instructions[at] += 1;
                for (clock, sums) in self.clocks.iter_mut().zip(&mut self.current.cycles) {
                    let cycles = clock.advance(before, &self.accesses, (it.address, it.size));
                    sums[at] += cycles.own;
                    sums[self.dividing as usize] += cycles.division;
                }
                self.length += 1;
                self.running = self.length < SAMPLE_LIMIT;
            }
            if before.kind == Kind::FloatDivide {
                self.dividing = stage;
            }
            let reads_timer = self.accesses.iter().any(|access| access.address >= PERIPHERALS);
            if self.sample == Sample::Lap && before_place.lap && reads_timer {
                self.end_sample();
            }
            self.follow(before, stage, it.address);
        }
        self.accesses.clear();
        let caller = self.calls.last().map_or(Stage::Other, |frame| frame.stage);
        self.pending = Some((next, place.stage.unwrap_or(caller)));
    }

    /// Takes an access to memory of the instruction executed last.
    pub fn access(&mut self, access: Access) {
        self.accesses.push(access);
    }

    /// Samples in their order.
    pub fn samples(&self) -> &[Counts] {
        &self.samples
    }

    /// Sum over the samples.
    pub fn total(&self) -> Counts {
        let mut total = Counts::new(self.clocks.len());
        self.samples.iter().for_each(|sample| total.add(sample));
        total
    }

    /// Sum over the samples that the model was evaluated for, and their number.
    pub fn evaluated(&self) -> (Counts, usize) {
        let mut sum = Counts::new(self.clocks.len());
        let evaluated = |sample: &&Counts| sample.instructions[Stage::Dynamics as usize] > 0;
        let count = self.samples.iter().filter(evaluated).inspect(|sample| sum.add(sample)).count();
        (sum, count)
    }

    /// Keeps the calls that have not returned.
    fn follow(&mut self, before: &Instruction, stage: Stage, to: u32) {
        let after = before.address.wrapping_add(before.size);
        match before.flow {
            Flow::Call => {
                if self.sample == Sample::Function(to) {
                    self.depth = self.calls.len();
                    // The call itself belongs to the caller.
                    self.current = Counts::new(self.clocks.len());
                    (self.running, self.length) = (true, 0);
                }
                self.calls.push(Frame { back: after, stage });
            }
            Flow::Return if to != after => {
                if let Some(at) = self.calls.iter().rposition(|frame| frame.back == to) {
                    self.calls.truncate(at);
                }
                if let Sample::Function(_) = self.sample
                    && self.running
                    && self.calls.len() <= self.depth
                {
                    self.end_sample();
                    self.running = false;
                }
            }
            _ => {}
        }
    }

    fn end_sample(&mut self) {
        let done = std::mem::replace(&mut self.current, Counts::new(self.clocks.len()));
        self.length = 0;
        // What precedes the first reading is not a sample.
        if self.running {
            self.samples.push(done);
        }
        self.running = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(lines: &[(u32, &str, Place)]) -> Vec<(Instruction, Place)> {
        lines.iter().map(|(address, text, place)| (Instruction::new(*address, 2, text), place.clone())).collect()
    }

    fn of(stage: Stage) -> Place {
        Place { stage: Some(stage), lap: false }
    }

    #[test]
    fn a_function_without_a_stage_is_its_callers() {
        let lap = Place { stage: None, lap: true };
        let code = code(&[
            (0, "ldr r0, [r1]", lap),
            (2, "bl #20", of(Stage::Encoder)),
            (4, "bl #20", of(Stage::Decoder)),
            (6, "b #0", Place::default()),
            (20, "adds r0, r1", Place::default()),
            (22, "bx lr", Place::default()),
        ]);
        let mut trace = Trace::new(Sample::Lap, 0, Flash::Plain);
        for _ in 0..3 {
            for next in [0, 1, 4, 5, 2, 4, 5, 3] {
                trace.execute(&code, next);
                if next == 0 {
                    trace.access(Access { address: 0x4000_0000, size: 4 });
                }
            }
        }
        assert_eq!(trace.samples().len(), 2, "two samples lie between three readings");
        for sample in trace.samples() {
            let count = |stage| sample.instructions[stage as usize];
            assert_eq!((count(Stage::Encoder), count(Stage::Decoder), count(Stage::Other)), (3, 3, 2));
            // bl, adds, bx: 2 + 1 + 3.
            assert_eq!(sample.cycles[0][Stage::Encoder as usize], 6);
        }
        assert_eq!(trace.total().total(0), 2 * trace.samples()[0].total(0));
    }

    #[test]
    fn a_function_counts_from_its_first_to_its_last_instruction() {
        let none = Place::default();
        let lines = [
            (0, "bl #40"),
            (2, "nop"),
            (20, "adds r0, r1"),
            (22, "bx lr"),
            (40, "push {lr}"),
            (42, "bl #20"),
            (44, "pop {pc}"),
        ];
        let code = code(&lines.map(|(address, text)| (address, text, none.clone())));
        let mut trace = Trace::new(Sample::Function(20), 0, Flash::Plain);
        // Called by a function that was called itself.
        [0, 4, 5, 2, 3, 6, 1].into_iter().for_each(|next| trace.execute(&code, next));
        assert_eq!(trace.samples().len(), 1);
        assert_eq!(trace.samples()[0].total(0), 4);
    }
}
