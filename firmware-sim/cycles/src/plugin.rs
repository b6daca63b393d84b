//! QEMU's side: its plugin interface, version 1 (`qemu-plugin.h` of QEMU 4.2 to 8.2), and the state behind its callbacks.
//!
//! Arguments: `elf=FILE`, `out=FILE`, and optionally `waits=N`, `flash=plain|prefetch|cached`, `json=on`,
//! `kernel=ADDRESS` (a function to time, instead of the samples of the image).

use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::sync::Mutex;

use addr2line::Loader;

use crate::instruction::Instruction;
use crate::report::{self, Setting};
use crate::stage::{self, Place};
use crate::timing::{Access, Flash};
use crate::trace::{Sample, Trace};

/// Version of the interface, which QEMU checks.
#[unsafe(no_mangle)]
#[allow(non_upper_case_globals)]
pub static qemu_plugin_version: c_int = 1;

const NO_REGISTERS: c_int = 0;
const READS_AND_WRITES: c_int = 3;

unsafe extern "C" {
    fn qemu_plugin_register_vcpu_tb_trans_cb(id: u64, callback: extern "C" fn(u64, *mut c_void));
    fn qemu_plugin_register_atexit_cb(id: u64, callback: extern "C" fn(u64, *mut c_void), data: *mut c_void);
    fn qemu_plugin_tb_n_insns(block: *const c_void) -> usize;
    fn qemu_plugin_tb_get_insn(block: *const c_void, at: usize) -> *mut c_void;
    fn qemu_plugin_insn_vaddr(insn: *const c_void) -> u64;
    fn qemu_plugin_insn_size(insn: *const c_void) -> usize;
    fn qemu_plugin_insn_disas(insn: *const c_void) -> *mut c_char;
    fn qemu_plugin_register_vcpu_insn_exec_cb(
        insn: *mut c_void,
        callback: extern "C" fn(u32, *mut c_void),
        flags: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_register_vcpu_mem_cb(
        insn: *mut c_void,
        callback: extern "C" fn(u32, u32, u64, *mut c_void),
        flags: c_int,
        accesses: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_mem_size_shift(info: u32) -> u32;
    fn free(text: *mut c_void);
}

struct State {
    debug: Loader,
    out: String,
    json: bool,
    setting: Setting,
    /// Instructions in the order of their first translation, and their numbers by address.
    code: Vec<(Instruction, Place)>,
    numbers: HashMap<u32, usize>,
    trace: Trace,
    error: Option<String>,
}

// SAFETY: QEMU calls a plugin of a machine with one processor from one thread at a time, and the lock is held.
unsafe impl Send for State {}

static STATE: Mutex<Option<State>> = Mutex::new(None);

fn with(act: impl FnOnce(&mut State)) {
    if let Ok(mut state) = STATE.lock()
        && let Some(state) = state.as_mut()
    {
        act(state);
    }
}

/// Entry of the plugin.
///
/// # Safety
/// `argv` holds `argc` texts that end in 0, as QEMU's do.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: u64,
    _info: *const c_void,
    argc: c_int,
    argv: *const *const c_char,
) -> c_int {
    let count = usize::try_from(argc).unwrap_or(0);
    // SAFETY: the caller's promise.
    let arguments = (0..count).map(|i| unsafe { CStr::from_ptr(*argv.add(i)) }.to_string_lossy().into_owned());
    match start(arguments) {
        Ok(state) => {
            if let Ok(mut place) = STATE.lock() {
                *place = Some(state);
            }
        }
        Err(error) => {
            eprintln!("ballrace-cycles: {error}");
            return 1;
        }
    }
    // SAFETY: callbacks of the types that the interface states.
    unsafe {
        qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
        qemu_plugin_register_atexit_cb(id, ended, std::ptr::null_mut());
    }
    0
}

fn start(arguments: impl Iterator<Item = String>) -> Result<State, String> {
    let (mut elf, mut out, mut json) = (None, None, false);
    let mut setting = Setting { wait_states: 0, flash: Flash::Cached };
    let mut sample = Sample::Lap;
    for argument in arguments {
        let (key, value) = argument.split_once('=').ok_or(format!("found {argument:?}, expected KEY=VALUE"))?;
        let wrong = |expected: &str| format!("{key}: found {value:?}, expected {expected}");
        match key {
            "elf" => elf = Some(value.to_owned()),
            "out" => out = Some(value.to_owned()),
            "json" => json = value == "on" || value == "true",
            "waits" => setting.wait_states = value.parse().map_err(|_| wrong("a number of wait states"))?,
            "flash" => {
                setting.flash = match value {
                    "plain" => Flash::Plain,
                    "prefetch" => Flash::Prefetch,
                    "cached" => Flash::Cached,
                    _ => return Err(wrong("plain, prefetch or cached")),
                }
            }
            "kernel" => {
                let address = u32::from_str_radix(value.trim_start_matches("0x"), 16);
                // The lowest bit of a Thumb function's address is no part of it.
                sample = Sample::Function(address.map_err(|_| wrong("a hexadecimal address"))? & !1);
            }
            _ => return Err(format!("found {key:?}, expected elf, out, json, waits, flash or kernel")),
        }
    }
    let elf = elf.ok_or("expected elf=FILE")?;
    let debug = Loader::new(&elf).map_err(|error| format!("{elf}: {error}"))?;
    let trace = Trace::new(sample, setting.wait_states, setting.flash);
    let out = out.ok_or("expected out=FILE")?;
    Ok(State { debug, out, json, setting, code: Vec::new(), numbers: HashMap::new(), trace, error: None })
}

extern "C" fn translated(_id: u64, block: *mut c_void) {
    with(|state| {
        // SAFETY: the block is QEMU's and lives through this call; so do its instructions.
        unsafe {
            for at in 0..qemu_plugin_tb_n_insns(block) {
                let insn = qemu_plugin_tb_get_insn(block, at);
                let number = state.number(insn) as *mut c_void;
                qemu_plugin_register_vcpu_insn_exec_cb(insn, executed, NO_REGISTERS, number);
                qemu_plugin_register_vcpu_mem_cb(insn, accessed, NO_REGISTERS, READS_AND_WRITES, number);
            }
        }
    });
}

impl State {
    /// Number of an instruction of the image.
    ///
    /// # Safety
    /// `insn` is an instruction of the block that QEMU translates.
    unsafe fn number(&mut self, insn: *const c_void) -> usize {
        // SAFETY: the caller's promise; the text is ours to free.
        let (address, size, text) = unsafe {
            let text = qemu_plugin_insn_disas(insn);
            let copy = CStr::from_ptr(text).to_string_lossy().into_owned();
            free(text.cast());
            (qemu_plugin_insn_vaddr(insn) as u32, qemu_plugin_insn_size(insn) as u32, copy)
        };
        if let Some(number) = self.numbers.get(&address) {
            return *number;
        }
        let place = stage::place(&self.debug, address).unwrap_or_else(|error| {
            self.error.get_or_insert(error);
            Place::default()
        });
        let number = self.code.len();
        self.code.push((Instruction::new(address, size, &text), place));
        self.numbers.insert(address, number);
        number
    }
}

extern "C" fn executed(_cpu: u32, number: *mut c_void) {
    with(|state| state.trace.execute(&state.code, number as usize));
}

extern "C" fn accessed(_cpu: u32, info: u32, address: u64, _number: *mut c_void) {
    // SAFETY: a pure function of its argument.
    let size = 1 << unsafe { qemu_plugin_mem_size_shift(info) };
    with(|state| state.trace.access(Access { address: address as u32, size }));
}

extern "C" fn ended(_id: u64, _data: *mut c_void) {
    with(|state| {
        let json = report::json(&state.trace, state.setting);
        let text = if state.json { format!("{json}\n") } else { report::table(&json) };
        let written = match &state.error {
            Some(error) => Err(error.clone()),
            None => std::fs::write(&state.out, text).map_err(|error| format!("{}: {error}", state.out)),
        };
        if let Err(error) = written {
            eprintln!("ballrace-cycles: {error}");
        }
    });
}
