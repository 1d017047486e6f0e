//! Counts the instructions of an ARM program under `qemu-arm`, by the marks that the program passes.
//!
//! A mark is the instruction `and rN, rN, rN` with `N` 1 to 8: it does nothing, and no compiler makes it. `N` names the
//! part of the work that begins; `and r8, r8, r8` ends the last. At each end the plugin writes one line to the standard
//! error, `icount` and the counts of parts 1 to 7, and starts from 0. The counts are the same in every run, because
//! they are those of guest instructions, and neither translation nor time is in them.
//!
//! ```text
//! qemu-arm -cpu cortex-a9 -plugin libhoverlock_icount.so hoverlock-nav flight.hln
//! ```
//!
//! The functions and types are those of `qemu-plugin.h`, plugin API version 1 (QEMU 4.2 to 8.2).

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// The version of the API that qemu looks for.
#[unsafe(no_mangle)]
pub static qemu_plugin_version: c_int = 1;

/// `and rN, rN, rN` for `N` of 0, without a condition; `N` is added three times.
const MARK: u32 = 0xe000_0000;
/// What one more `N` adds: the two operands and the destination.
const REGISTER: u32 = 1 | 1 << 12 | 1 << 16;
/// Marks 1 to 8.
const MARKS: usize = 8;

/// A block of translated code; qemu's own.
#[repr(C)]
pub struct Block(c_void);

/// An instruction of a block; qemu's own.
#[repr(C)]
struct Instruction(c_void);

type OnTranslation = extern "C" fn(id: u64, block: *mut Block);
type OnExecution = extern "C" fn(cpu: c_uint, data: *mut c_void);

/// `QEMU_PLUGIN_CB_NO_REGS`: the callback does not look at registers.
const NO_REGISTERS: c_int = 0;
/// `QEMU_PLUGIN_INLINE_ADD_U64`: translated code adds to a counter by itself.
const ADD: c_int = 0;

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

/// Instructions that are no mark, since the start.
static EXECUTED: AtomicU64 = AtomicU64::new(0);

/// Where the instructions go.
struct Parts {
    /// The part that is counted now, 0 before the first mark.
    now: usize,
    /// `EXECUTED` when it began.
    begun: u64,
    /// Instructions of each part.
    counts: [u64; MARKS],
}

static PARTS: Mutex<Parts> = Mutex::new(Parts { now: 0, begun: 0, counts: [0; MARKS] });

/// Called by qemu when it loads the plugin.
///
/// # Safety
/// To be called by qemu only, with the identity it gave the plugin.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: u64,
    _info: *const c_void,
    _argc: c_int,
    _argv: *const *const c_char,
) -> c_int {
    // SAFETY: the identity is qemu's, the function stays as long as the plugin.
    unsafe { qemu_plugin_register_vcpu_tb_trans_cb(id, translated) };
    0
}

/// The mark that an instruction is.
fn mark(code: u32) -> Option<usize> {
    (1..=MARKS).find(|n| code == MARK + REGISTER * *n as u32)
}

/// Each instruction counts by itself: a block can be left before its end, so that counting whole blocks would not be
/// exact.
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
                    qemu_plugin_register_vcpu_insn_exec_inline(instruction, ADD, EXECUTED.as_ptr().cast(), 1);
                }
            }
        }
    }
}

extern "C" fn marked(_cpu: c_uint, data: *mut c_void) {
    let executed = EXECUTED.load(Ordering::Relaxed);
    // The lock is never held by a thread that panics: nothing between here and its end does.
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
