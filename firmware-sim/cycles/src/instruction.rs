//! An instruction as its disassembly says: what it does, the registers it reads and writes, and its address.

use crate::registers::{PC, Registers, SP};

/// What an instruction does, as far as its time depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Data processing in the core, one cycle; so are single and dual multiply-accumulates.
    Data,
    /// `IT`, which may be folded into its neighbour.
    IfThen,
    /// Integer division.
    Divide,
    /// Load of one register.
    Load,
    /// Load of several registers.
    LoadMany,
    /// Store of one register; with an immediate offset it takes one cycle.
    Store {
        /// Whether the address has a register offset.
        register_offset: bool,
    },
    /// Store of several registers.
    StoreMany,
    /// Branch to an address in the instruction.
    Branch,
    /// Branch to an address in a register or in memory.
    BranchIndirect,
    /// `TBB`, `TBH`.
    TableBranch,
    /// Floating-point arithmetic whose result is late by a cycle.
    Float,
    /// Multiply-accumulate in floating point.
    FloatAccumulate,
    /// Floating-point division or square root.
    FloatDivide,
    /// Floating-point comparison.
    FloatCompare,
    /// Any other floating-point instruction: moves, signs, status.
    FloatMove {
        /// Words moved.
        words: u32,
    },
}

/// How the flow of control goes on after an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// To the next instruction, or wherever a branch leads.
    On,
    /// Into a function that will return.
    Call,
    /// Back out of a function.
    Return,
}

/// An instruction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// Its address.
    pub address: u32,
    /// Its length, bytes.
    pub size: u32,
    /// What it does.
    pub kind: Kind,
    /// How control goes on.
    pub flow: Flow,
    /// Registers it writes.
    pub writes: Registers,
    /// Registers it reads as operands.
    pub reads: Registers,
    /// Registers that make its address.
    pub address_reads: Registers,
    /// Whether it uses the floating-point unit.
    pub float: bool,
}

const CONDITIONS: [&str; 17] =
    ["eq", "ne", "hs", "cs", "lo", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le", "al"];
/// Arithmetic "such as add, subtract, multiply, divide, square-root, all forms of multiply with accumulate, in addition
/// to conversions", whose result is late.
const FLOAT_ARITHMETIC: [&str; 5] = ["vadd", "vsub", "vmul", "vnmul", "vcvt"];
const FLOAT_ACCUMULATE: [&str; 8] = ["vmla", "vmls", "vfma", "vfms", "vfnma", "vfnms", "vnmla", "vnmls"];

impl Instruction {
    /// Reads a disassembled instruction, such as `ldr.w r0, [r1, #4]`.
    pub fn new(address: u32, size: u32, text: &str) -> Self {
        let (mnemonic, operands) = text.trim().split_once(char::is_whitespace).unwrap_or((text.trim(), ""));
        let mnemonic = mnemonic.to_ascii_lowercase();
        let is = |prefixes: &[&str]| prefixes.iter().any(|prefix| mnemonic.starts_with(prefix));
        let mut it = Self {
            address,
            size,
            kind: Kind::Data,
            flow: Flow::On,
            writes: Registers::default(),
            reads: Registers::default(),
            address_reads: Registers::default(),
            float: mnemonic.starts_with('v'),
        };
        let name = mnemonic.trim_end_matches(".w").trim_end_matches(".n");
        if let Some(flow) = it.branch(name, operands) {
            it.flow = flow;
            return it;
        }
        if is(&["ldr", "vldr", "str", "vstr", "ldm", "stm", "vldm", "vstm", "push", "pop", "vpush", "vpop"]) {
            it.memory(&mnemonic, operands);
            return it;
        }
        let (first, rest) = operands.split_once(',').unwrap_or((operands, ""));
        it.writes = Registers::named(first);
        it.reads = Registers::named(rest);
        it.kind = match () {
            () if is(&["cmp", "cmn", "tst", "teq"]) => {
                it.reads = it.reads.and(it.writes);
                it.writes = Registers::default();
                Kind::Data
            }
            () if is(&["vcmp"]) => {
                it.reads = it.reads.and(it.writes);
                it.writes = Registers::default();
                Kind::FloatCompare
            }
            () if is(&["udiv", "sdiv"]) => Kind::Divide,
            () if is(&["vdiv", "vsqrt"]) => Kind::FloatDivide,
            () if is(&FLOAT_ACCUMULATE) => Kind::FloatAccumulate,
            () if is(&FLOAT_ARITHMETIC) => Kind::Float,
            () if it.float => {
                let moved = operands.split(',').count();
                if moved > 2 {
                    // Two words to or from the core: the first half is written.
                    let at = operands.match_indices(',').nth(moved / 2 - 1).map_or(operands.len(), |(at, _)| at);
                    it.writes = Registers::named(operands.get(..at).unwrap_or(operands));
                    it.reads = Registers::named(operands.get(at..).unwrap_or(""));
                }
                Kind::FloatMove { words: if moved > 2 { 2 } else { 1 } }
            }
            () if is(&["smull", "umull", "smlal", "umlal", "umaal", "smlsl"]) => {
                let (second, sources) = rest.split_once(',').unwrap_or((rest, ""));
                it.writes = it.writes.and(Registers::named(second));
                it.reads = Registers::named(sources);
                Kind::Data
            }
            () if is_if_then(&mnemonic) => Kind::IfThen,
            () => Kind::Data,
        };
        if it.writes.meets(PC) {
            it.kind = Kind::BranchIndirect;
            it.flow = if it.reads.meets(Registers::named("lr")) { Flow::Return } else { Flow::On };
        }
        it
    }

    /// Sets the kind of a branch; `None` for any other instruction.
    fn branch(&mut self, name: &str, operands: &str) -> Option<Flow> {
        let conditional =
            |stem: &str| name.strip_prefix(stem).is_some_and(|rest| rest.is_empty() || CONDITIONS.contains(&rest));
        self.reads = Registers::named(operands);
        let (kind, flow) = match () {
            () if name == "tbb" || name == "tbh" => (Kind::TableBranch, Flow::On),
            () if conditional("blx") => (Kind::BranchIndirect, Flow::Call),
            () if conditional("bx") => {
                let back = self.reads.meets(Registers::named("lr"));
                (Kind::BranchIndirect, if back { Flow::Return } else { Flow::On })
            }
            () if name == "cbz" || name == "cbnz" || conditional("b") => (Kind::Branch, Flow::On),
            () if conditional("bl") => (Kind::Branch, Flow::Call),
            () => {
                self.reads = Registers::default();
                return None;
            }
        };
        Some(flow).inspect(|_| self.kind = kind)
    }

    fn memory(&mut self, mnemonic: &str, operands: &str) {
        let load = mnemonic.starts_with("ld") || mnemonic.starts_with("vld") || mnemonic.contains("pop");
        let (data, many) = if let Some(at) = operands.find('{') {
            let (base, list) = operands.split_at(at);
            self.address_reads = if base.trim().is_empty() { SP } else { Registers::named(base) };
            (Registers::named(list), true)
        } else {
            let (data, address) = operands.split_once('[').unwrap_or((operands, ""));
            self.address_reads = Registers::named(address);
            let data = Registers::named(data);
            (data, data.words() > 1)
        };
        let register_offset = !many && self.address_reads.words() > 1;
        if load {
            self.writes = data;
        } else {
            self.reads = data;
        }
        self.kind = match (load, many) {
            (true, false) => Kind::Load,
            (true, true) => Kind::LoadMany,
            (false, false) => Kind::Store { register_offset },
            (false, true) => Kind::StoreMany,
        };
        if load && data.meets(PC) {
            // What is popped or loaded into the program counter is a return address.
            self.flow = Flow::Return;
        }
    }
}

fn is_if_then(mnemonic: &str) -> bool {
    mnemonic.strip_prefix('i').is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|b| b == b't' || b == b'e'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(text: &str) -> Kind {
        Instruction::new(0, 2, text).kind
    }

    #[test]
    fn instructions_are_what_their_mnemonics_say() {
        for (text, expected) in [
            ("smlad r0, r1, r2, r0", Kind::Data),
            ("bics r0, r1", Kind::Data),
            ("bfi r0, r1, #2, #3", Kind::Data),
            ("itte ne", Kind::IfThen),
            ("udiv r0, r1, r2", Kind::Divide),
            ("ldrb.w r0, [r1, r2]", Kind::Load),
            ("ldrd r0, r1, [sp, #8]", Kind::LoadMany),
            ("ldm.w r0!, {r4, r5}", Kind::LoadMany),
            ("vldr d0, [r1]", Kind::LoadMany),
            ("vldr s0, [r1]", Kind::Load),
            ("str r0, [r1, #4]", Kind::Store { register_offset: false }),
            ("str.w r0, [r1, r2, lsl #2]", Kind::Store { register_offset: true }),
            ("vpush {d8, d9}", Kind::StoreMany),
            ("bls.w #0x1234", Kind::Branch),
            ("bl #0x1234", Kind::Branch),
            ("cbnz r3, #0x20", Kind::Branch),
            ("bx lr", Kind::BranchIndirect),
            ("blx r3", Kind::BranchIndirect),
            ("tbb [pc, r0]", Kind::TableBranch),
            ("vmla.f32 s0, s1, s2", Kind::FloatAccumulate),
            ("vmul.f32 s0, s1, s2", Kind::Float),
            ("vsqrt.f32 s0, s1", Kind::FloatDivide),
            ("vcmp.f32 s0, #0", Kind::FloatCompare),
            ("vmov s0, r1", Kind::FloatMove { words: 1 }),
            ("vmov r0, r1, d0", Kind::FloatMove { words: 2 }),
            ("vmrs apsr_nzcv, fpscr", Kind::FloatMove { words: 1 }),
        ] {
            assert_eq!(kind(text), expected, "{text}");
        }
    }

    #[test]
    fn control_goes_into_functions_and_back() {
        for (text, expected) in [
            ("bl #4", Flow::Call),
            ("blx r3", Flow::Call),
            ("blt #4", Flow::On),
            ("bx lr", Flow::Return),
            ("pop {r4, pc}", Flow::Return),
            ("pop {r4, r7}", Flow::On),
            ("ldr pc, [sp], #4", Flow::Return),
        ] {
            assert_eq!(Instruction::new(0, 2, text).flow, expected, "{text}");
        }
    }

    #[test]
    fn registers_are_read_written_or_an_address() {
        let load = Instruction::new(0, 4, "ldr r0, [r1, r2, lsl #2]");
        assert_eq!((load.writes, load.address_reads), (Registers(1), Registers(0b110)));
        let store = Instruction::new(0, 4, "str r0, [r1], #4");
        assert_eq!((store.reads, store.writes), (Registers(1), Registers(0)));
        let long = Instruction::new(0, 4, "umull r0, r1, r2, r3");
        assert_eq!((long.writes, long.reads), (Registers(3), Registers(0b1100)));
        let pair = Instruction::new(0, 4, "vmov s0, s1, r2, r3");
        assert_eq!((pair.writes, pair.reads), (Registers(3 << 16), Registers(0b1100)));
    }
}
