//! Times of the Cortex-M4: Arm, *Cortex-M4 Processor Technical Reference Manual*, r0p1 (Arm 100166), tables 3-1 and 7-1,
//! section 3.3.2 on pairs of loads and stores, section 7.2.3 on late results of the floating-point unit.
//!
//! Where the manual gives a range, [`Bound`] says which end is taken; [`Bound::Nominal`] is what is published as
//! measured. Not modelled: contention of fetch and data on a bus, exceptions, a full write buffer.

use crate::instruction::{Instruction, Kind};
use crate::registers::Registers;

/// Which end of the manual's ranges is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// Refill of the pipeline P = 1 after a branch to an address in the instruction, which is known early, and 2 after any
    /// other, 1 more for a 32-bit instruction that is not word-aligned; loads pipelined where the manual says "when possible".
    Nominal,
    /// The shortest: P = 1, `IT` folded, divisions in 2 cycles.
    Low,
    /// The longest: P = 3, no load pipelined, divisions in 12 cycles, nothing beside a floating-point division.
    High,
}

/// How code and constants are read from flash, whose lines have [`LINE`] bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flash {
    /// One line of code and one of data are held; any other costs the wait states.
    Plain,
    /// As `Plain`, and the next line of code is fetched while one is executed.
    Prefetch,
    /// As `Prefetch`, with 64 lines of code and 8 of data in caches, least recently used out first: an STM32F4's.
    Cached,
}

/// Bytes of a line of flash.
pub const LINE: u32 = 16;
/// First address that is not flash.
const FLASH_END: u32 = 0x2000_0000;
const CODE_LINES: usize = 64;
const DATA_LINES: usize = 8;

/// An access to memory.
#[derive(Clone, Copy, Debug)]
pub struct Access {
    /// Address.
    pub address: u32,
    /// Bytes.
    pub size: u32,
}

/// Time of an instruction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cycles {
    /// Cycles of its own.
    pub own: u64,
    /// Cycles before it in which the floating-point unit still divided.
    pub division: u64,
}

/// Time of a stream of instructions.
#[derive(Debug)]
pub struct Clock {
    bound: Bound,
    now: u64,
    /// Registers that data processing of the instruction before wrote.
    computed: Registers,
    /// Registers that floating-point arithmetic of the instruction before wrote.
    late: Registers,
    /// Register that a load, directly before, wrote.
    loaded: Option<Registers>,
    compared: bool,
    /// When a floating-point division is done.
    float_free: u64,
    memory: Option<FlashReader>,
}

impl Clock {
    /// Clock at 0 with code and constants in memory without wait states.
    pub fn new(bound: Bound) -> Self {
        let none = Registers::default();
        Self { bound, now: 0, computed: none, late: none, loaded: None, compared: false, float_free: 0, memory: None }
    }

    /// Clock at 0, nominal, with code and constants in flash.
    pub fn with_flash(wait_states: u32, flash: Flash) -> Self {
        Self { memory: Some(FlashReader::new(wait_states, flash)), ..Self::new(Bound::Nominal) }
    }

    /// Cycles of an instruction, its accesses to memory, and the one executed after it (address and size).
    pub fn advance(&mut self, it: &Instruction, accesses: &[Access], next: (u32, u32)) -> Cycles {
        let before = self.now;
        let mut division = 0;
        if let Some(memory) = &mut self.memory {
            self.now += memory.fetch(it, self.now);
        }
        if it.float {
            division = self.float_free.saturating_sub(self.now);
            self.now += division;
            let addend = if it.kind == Kind::FloatAccumulate { it.reads } else { it.reads.and(it.address_reads) };
            self.now += u64::from(self.late.meets(addend));
        }
        let pipelined = self.loaded.is_some_and(|loaded| !loaded.meets(it.address_reads)) && self.bound != Bound::High;
        // An address from the data processing before: nothing is forwarded to it.
        self.now += u64::from(self.computed.meets(it.address_reads));
        let taken = next.0 != it.address.wrapping_add(it.size);
        self.now += match it.kind {
            Kind::Data => 1,
            Kind::IfThen => u64::from(self.bound != Bound::Low),
            Kind::Divide => self.one_of(7, 2, 12),
            Kind::Load => 2 - u64::from(pipelined),
            Kind::Store { register_offset: true } => 2 - u64::from(pipelined),
            Kind::Store { register_offset: false } => 1,
            Kind::LoadMany | Kind::StoreMany => 1 + u64::from(it.reads.and(it.writes).words()),
            Kind::Branch | Kind::BranchIndirect => 1,
            Kind::TableBranch => 2,
            Kind::Float => 1,
            Kind::FloatAccumulate => 3,
            Kind::FloatDivide if self.bound == Bound::High => 14,
            Kind::FloatDivide => {
                self.float_free = self.now + 14;
                1
            }
            Kind::FloatCompare => 1,
            Kind::FloatMove { words } => u64::from(words) + u64::from(self.compared && self.bound == Bound::High),
        };
        if taken {
            self.now += self.refill(it.kind, next);
        }
        for access in accesses {
            // An access that is not aligned is made in parts.
            let part = access.address % 4;
            self.now += match (access.size, part) {
                (4, 1 | 3) => 2,
                (4, 2) | (2, 1 | 3) => 1,
                _ => 0,
            };
            if let Some(memory) = &mut self.memory {
                self.now += memory.data(access.address);
            }
        }
        let none = Registers::default();
        self.computed = if matches!(it.kind, Kind::Data | Kind::Divide) { it.writes } else { none };
        let arithmetic = matches!(it.kind, Kind::Float | Kind::FloatAccumulate | Kind::FloatDivide);
        self.late = if arithmetic { it.writes } else { none };
        self.loaded = (it.kind == Kind::Load && !taken).then_some(it.writes);
        self.compared = it.kind == Kind::FloatCompare;
        Cycles { own: self.now - before - division, division }
    }

    fn refill(&self, kind: Kind, (address, size): (u32, u32)) -> u64 {
        let split = u64::from(size == 4 && !address.is_multiple_of(4));
        let known_early = kind == Kind::Branch;
        self.one_of(if known_early { 1 } else { 2 } + split, 1, 3)
    }

    const fn one_of(&self, nominal: u64, low: u64, high: u64) -> u64 {
        match self.bound {
            Bound::Nominal => nominal,
            Bound::Low => low,
            Bound::High => high,
        }
    }
}

/// Lines of flash at hand.
#[derive(Debug)]
struct FlashReader {
    wait_states: u64,
    flash: Flash,
    line: u32,
    /// When the line that is executed was entered.
    entered: u64,
    code: Lines<CODE_LINES>,
    data_line: u32,
    data: Lines<DATA_LINES>,
}

impl FlashReader {
    fn new(wait_states: u32, flash: Flash) -> Self {
        let (line, data_line) = (u32::MAX, u32::MAX);
        let (code, data) = (Lines::new(), Lines::new());
        Self { wait_states: wait_states.into(), flash, line, entered: 0, code, data_line, data }
    }

    /// Cycles that an instruction is waited for.
    fn fetch(&mut self, it: &Instruction, now: u64) -> u64 {
        if it.address >= FLASH_END {
            return 0;
        }
        let mut waited = 0;
        for address in [it.address, it.address + it.size - 1] {
            let line = address / LINE;
            if line == self.line {
                continue;
            }
            let hit = self.flash == Flash::Cached && self.code.holds(line);
            let follows = line == self.line.wrapping_add(1) && self.flash != Flash::Plain;
            let done = if follows { now + waited - self.entered } else { 0 };
            waited += if hit { 0 } else { self.wait_states.saturating_sub(done) };
            (self.line, self.entered) = (line, now + waited);
        }
        waited
    }

    /// Cycles that a constant is waited for.
    fn data(&mut self, address: u32) -> u64 {
        let line = address / LINE;
        if address >= FLASH_END || line == self.data_line {
            return 0;
        }
        self.data_line = line;
        if self.flash == Flash::Cached && self.data.holds(line) { 0 } else { self.wait_states }
    }
}

/// A cache of lines, fully associative.
#[derive(Debug)]
struct Lines<const N: usize> {
    lines: [(u32, u64); N],
    age: u64,
}

impl<const N: usize> Lines<N> {
    fn new() -> Self {
        Self { lines: [(u32::MAX, 0); N], age: 0 }
    }

    /// Whether a line is held; it is, afterwards.
    fn holds(&mut self, line: u32) -> bool {
        self.age += 1;
        let age = self.age;
        if let Some(found) = self.lines.iter_mut().find(|(held, _)| *held == line) {
            found.1 = age;
            return true;
        }
        if let Some(oldest) = self.lines.iter_mut().min_by_key(|(_, used)| *used) {
            *oldest = (line, age);
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cycles of 16-bit instructions one after the other, from address 0; a last one follows.
    fn cycles(clock: &mut Clock, code: &[&str]) -> u64 {
        let address = |i: usize| 2 * i as u32;
        let step = |(i, text): (usize, &&str)| {
            let it = Instruction::new(address(i), 2, text);
            let cycles = clock.advance(&it, &[], (address(i + 1), 2));
            cycles.own + cycles.division
        };
        code.iter().enumerate().map(step).sum()
    }

    fn nominal(code: &[&str]) -> u64 {
        cycles(&mut Clock::new(Bound::Nominal), code)
    }

    /// The manual's examples of section 3.3.2, in its words "normally three cycles total" and so on.
    #[test]
    fn literature_pairs_of_loads_and_stores() {
        for (code, expected) in [
            (&["ldr r0, [r1]", "ldr r2, [r3]"][..], 3),
            (&["ldr r0, [r1, r2]", "str r0, [r3, #20]"], 3),
            (&["ldr r0, [r1, r2]", "str r1, [r3, r2]"], 3),
            (&["ldr r0, [r1, r5]", "ldr r1, [r2]", "ldr r2, [r3, #4]"], 4),
            (&["ldr r0, [r1]", "ldr r2, [r0]"], 4),
            (&["str r0, [r1, #4]", "str r0, [r1, #8]"], 2),
            (&["ldm r0!, {r4, r5, r6, r7}"], 5),
            (&["push {r4, lr}"], 3),
        ] {
            assert_eq!(nominal(code), expected, "{code:?}");
        }
    }

    #[test]
    fn literature_floating_point() {
        for (code, expected) in [
            (&["vmul.f32 s0, s1, s2", "vmul.f32 s3, s1, s2"][..], 2),
            (&["vmul.f32 s0, s1, s2", "vadd.f32 s3, s0, s2"], 3),
            (&["vmla.f32 s0, s1, s2", "vmla.f32 s0, s3, s4"], 6),
            (&["vdiv.f32 s0, s1, s2", "adds r0, r1", "adds r0, r1"], 3),
            (&["vdiv.f32 s0, s1, s2", "vadd.f32 s3, s1, s2"], 15),
            (&["vldr s0, [r1]"], 2),
            (&["vldr d0, [r1]"], 3),
        ] {
            assert_eq!(nominal(code), expected, "{code:?}");
        }
    }

    #[test]
    fn addresses_wait_for_the_data_processing_before() {
        assert_eq!(nominal(&["adds r1, r2", "ldr r0, [r1]"]), 4);
        assert_eq!(nominal(&["adds r1, r2", "nop", "ldr r0, [r1]"]), 4);
        assert_eq!(nominal(&["uxtb r1, r2", "str r0, [r1, #4]"]), 3);
    }

    #[test]
    fn a_branch_taken_refills_the_pipeline() {
        let branch = Instruction::new(0, 2, "bne #8");
        let back = Instruction::new(0, 2, "bx lr");
        for (bound, it, next, expected) in [
            (Bound::Nominal, &branch, (2, 2), 1),
            (Bound::Nominal, &branch, (8, 2), 2),
            (Bound::Nominal, &branch, (10, 4), 3),
            (Bound::Low, &branch, (10, 4), 2),
            (Bound::High, &branch, (8, 2), 4),
            (Bound::Nominal, &back, (8, 2), 3),
        ] {
            assert_eq!(Clock::new(bound).advance(it, &[], next).own, expected, "{bound:?} {it:?} {next:?}");
        }
    }

    #[test]
    fn flash_is_waited_for_by_the_line() {
        let code = ["nop"; 32];
        // Four lines; prefetched, a line of eight instructions hides five wait states.
        assert_eq!(cycles(&mut Clock::with_flash(5, Flash::Plain), &code), 32 + 4 * 5);
        assert_eq!(cycles(&mut Clock::with_flash(5, Flash::Prefetch), &code), 32 + 5);
        assert_eq!(cycles(&mut Clock::with_flash(9, Flash::Prefetch), &code), 32 + 9 + 3);
        let mut cached = Clock::with_flash(5, Flash::Cached);
        assert_eq!(cycles(&mut cached, &code), 32 + 5);
        assert_eq!(cycles(&mut cached, &code), 32, "all lines are held");
        let load = Instruction::new(0, 2, "ldr r0, [r1]");
        let mut read = |address| cached.advance(&load, &[Access { address, size: 4 }], (2, 2)).own;
        assert_eq!([read(0x100), read(0x104), read(0x2000_0000)], [7, 1, 1]);
    }

    #[test]
    fn an_access_that_is_not_aligned_takes_longer() {
        let load = Instruction::new(0, 2, "ldr r0, [r1]");
        let cycles = |address| Clock::new(Bound::Nominal).advance(&load, &[Access { address, size: 4 }], (2, 2)).own;
        assert_eq!([cycles(0), cycles(1), cycles(2), cycles(3)], [2, 4, 3, 4]);
    }
}
