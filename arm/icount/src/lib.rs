//! A qemu plugin that counts the instructions of an ARM program between marks in its code.
//!
//! A mark is the instruction `and rN, rN, rN` with `N` 1 to 8: it has no effect, and compilers do not generate it. Mark
//! `N` starts part `N` of the work; mark 8 ends the last part. At each end the plugin writes one line to standard
//! error, `icount` and the counts of parts 1 to 7, and restarts from 0. The counts are the same in every run, because
//! they are numbers of guest instructions, independent of translation and time.
//!
//! ```text
//! qemu-arm -cpu cortex-a9 -plugin libhoverlock_icount.so hoverlock-nav flight.hln
//! ```
//!
//! The functions and types are those of `qemu-plugin.h`, plugin API version 1 (QEMU 4.2 to 8.2).

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// API version of the plugin, which qemu checks when it loads it.
#[unsafe(no_mangle)]
pub static qemu_plugin_version: c_int = 1;

/// Encoding of `and r0, r0, r0` without a condition; for `rN`, `N` times [`REGISTER_STEP`] is added.
const MARK_0: u32 = 0xe000_0000;
/// Difference of the encodings of mark `N + 1` and mark `N`: both operands and the destination.
const REGISTER_STEP: u32 = 1 | 1 << 12 | 1 << 16;
/// Number of marks.
const MARKS: usize = 8;

/// A block of translated code, opaque type of qemu.
#[repr(C)]
pub struct Block(c_void);

/// An instruction of a block, opaque type of qemu.
#[repr(C)]
struct Instruction(c_void);

type OnTranslation = extern "C" fn(id: u64, block: *mut Block);
type OnExecution = extern "C" fn(cpu: c_uint, data: *mut c_void);

/// `QEMU_PLUGIN_CB_NO_REGS`: the callback does not access registers.
const NO_REGISTERS: c_int = 0;
/// `QEMU_PLUGIN_INLINE_ADD_U64`: translated code increments a counter without a callback.
const INLINE_ADD: c_int = 0;

unsafe extern "C" {
    fn qemu_plugin_register_vcpu_tb_trans_cb(id: u64, callback: OnTranslation);
    fn qemu_plugin_tb_n_insns(block: *const Block) -> usize;
    fn qemu_plugin_tb_get_insn(block: *const Block, index: usize) -> *mut Instruction;
    fn qemu_plugin_insn_data(instruction: *const Instruction) -> *const c_void;
    fn qemu_plugin_insn_size(instruction: *const Instruction) -> usize;
    fn qemu_plugin_register_vcpu_insn_exec_cb(
        instruction: *mut Instruction,
        callback: OnExecution,
        flags: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_register_vcpu_insn_exec_inline(
        instruction: *mut Instruction,
        operation: c_int,
        counter: *mut c_void,
        added: u64,
    );
}

/// Number of executed instructions other than marks.
static EXECUTED: AtomicU64 = AtomicU64::new(0);

/// The instruction counts of the parts.
struct Parts {
    /// Part that is being counted, 0 before the first mark.
    now: usize,
    /// Value of `EXECUTED` at the start of that part.
    begun: u64,
    /// Instructions of each part so far.
    counts: [u64; MARKS],
}

static PARTS: Mutex<Parts> = Mutex::new(Parts { now: 0, begun: 0, counts: [0; MARKS] });

/// Installs the plugin; qemu calls it when it loads the library.
///
/// # Safety
/// Only qemu may call it, with the id that it gave the plugin.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: u64,
    _info: *const c_void,
    _argc: c_int,
    _argv: *const *const c_char,
) -> c_int {
    // SAFETY: the id is from qemu, and the function exists as long as the plugin.
    unsafe { qemu_plugin_register_vcpu_tb_trans_cb(id, translated) };
    0
}

/// Returns the number of the mark if the instruction is one.
fn mark(code: u32) -> Option<usize> {
    (1..=MARKS).find(|n| code == MARK_0 + REGISTER_STEP * *n as u32)
}

/// Instruments the instructions of a block when qemu translates it. Instructions are counted individually, because a
/// block can be left before its end.
extern "C" fn translated(_id: u64, block: *mut Block) {
    // SAFETY: qemu gives a block that is valid during the call, its instructions and their bytes too. The counter is
    // static, and the number of a mark is handed on as data without being a pointer to anything.
    unsafe {
        for index in 0..qemu_plugin_tb_n_insns(block) {
            let instruction = qemu_plugin_tb_get_insn(block, index);
            let code = (qemu_plugin_insn_size(instruction) == 4)
                .then(|| qemu_plugin_insn_data(instruction).cast::<u32>().read_unaligned());
            match code.and_then(mark) {
                Some(n) => qemu_plugin_register_vcpu_insn_exec_cb(
                    instruction,
                    marked,
                    NO_REGISTERS,
                    std::ptr::without_provenance_mut(n),
                ),
                None => {
                    qemu_plugin_register_vcpu_insn_exec_inline(instruction, INLINE_ADD, EXECUTED.as_ptr().cast(), 1);
                }
            }
        }
    }
}

/// Ends the current part at a mark and starts the next; prints the counts at mark 8.
extern "C" fn marked(_cpu: c_uint, data: *mut c_void) {
    let executed = EXECUTED.load(Ordering::Relaxed);
    // The lock cannot be poisoned: nothing panics while it is held.
    let Ok(mut parts) = PARTS.lock() else { return };
    let now = parts.now;
    parts.counts[now] += executed - parts.begun;
    parts.begun = executed;
    let next = data.addr();
    if next < MARKS {
        parts.now = next;
    } else {
        eprintln!("icount {}", parts.counts[1..].iter().map(u64::to_string).collect::<Vec<_>>().join(" "));
        (parts.now, parts.counts) = (0, [0; MARKS]);
    }
}
