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
//! With the argument `cycles=on` it also estimates cycles, by the tables of `cost` and `cache`, and writes a second
//! line, `icycles`: cycles of the whole frame by issue and by latency, misses of the first and of the second level, and
//! the deepest stack so far in bytes. The stack begins at the first store of the program.
//!
//! The functions and types are those of `qemu-plugin.h`, plugin API version 1 (QEMU 4.2 to 8.2).

mod cache;
mod cost;

use cache::Caches;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{LazyLock, Mutex};

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
type OnAccess = extern "C" fn(cpu: c_uint, info: u32, address: u64, data: *mut c_void);

/// `QEMU_PLUGIN_CB_NO_REGS`: the callback does not access registers.
const NO_REGISTERS: c_int = 0;
/// `QEMU_PLUGIN_MEM_RW`: reads and writes.
const READ_AND_WRITE: c_int = 3;
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
    fn qemu_plugin_tb_vaddr(block: *const Block) -> u64;
    fn qemu_plugin_register_vcpu_tb_exec_cb(block: *mut Block, callback: OnExecution, flags: c_int, data: *mut c_void);
    fn qemu_plugin_register_vcpu_mem_cb(
        instruction: *mut Instruction,
        callback: OnAccess,
        flags: c_int,
        access: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_mem_size_shift(info: u32) -> c_uint;
    fn qemu_plugin_mem_is_store(info: u32) -> bool;
    fn qemu_plugin_register_vcpu_insn_exec_inline(
        instruction: *mut Instruction,
        operation: c_int,
        counter: *mut c_void,
        added: u64,
    );
}

/// Number of executed instructions other than marks.
static EXECUTED: AtomicU64 = AtomicU64::new(0);

/// `true` if cycles are estimated.
static WITH_CYCLES: AtomicBool = AtomicBool::new(false);
/// Cycles by issue, and by latency.
static CYCLES: [AtomicU64; 2] = [AtomicU64::new(0), AtomicU64::new(0)];

/// Caches and stack.
struct Memory {
    caches: Caches,
    /// Address of the first store; 0 before it.
    stack_top: u64,
    stack_bytes: u64,
}

static MEMORY: LazyLock<Mutex<Memory>> =
    LazyLock::new(|| Mutex::new(Memory { caches: Caches::new(), stack_top: 0, stack_bytes: 0 }));

/// Largest stack of a process under qemu, bytes.
const MAX_STACK_BYTES: u64 = 8 << 20;

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
    argc: c_int,
    argv: *const *const c_char,
) -> c_int {
    for i in 0..usize::try_from(argc).unwrap_or(0) {
        // SAFETY: qemu passes `argc` strings.
        if unsafe { CStr::from_ptr(*argv.add(i)) } == c"cycles=on" {
            WITH_CYCLES.store(true, Ordering::Relaxed);
        }
    }
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
        let with_cycles = WITH_CYCLES.load(Ordering::Relaxed);
        let count = qemu_plugin_tb_n_insns(block);
        let size = |index| qemu_plugin_insn_size(qemu_plugin_tb_get_insn(block, index));
        // Instructions of two bytes are Thumb; blocks of it are from the C library and are taken as one cycle each.
        let is_thumb = (0..count).any(|index| size(index) == 2);
        if with_cycles {
            let bytes: usize = (0..count).map(size).sum();
            let place = Box::leak(Box::new((qemu_plugin_tb_vaddr(block), bytes as u64)));
            qemu_plugin_register_vcpu_tb_exec_cb(block, fetched, NO_REGISTERS, (&raw mut *place).cast());
        }
        for index in 0..count {
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
                    if with_cycles {
                        let cost = code.filter(|_| !is_thumb).map_or(cost::Cost { issue: 1, latency: 1 }, cost::of);
                        for (cycles, counter) in [cost.issue, cost.latency].into_iter().zip(&CYCLES) {
                            let counter = counter.as_ptr().cast();
                            qemu_plugin_register_vcpu_insn_exec_inline(instruction, INLINE_ADD, counter, cycles);
                        }
                        let none = std::ptr::null_mut();
                        qemu_plugin_register_vcpu_mem_cb(instruction, accessed, NO_REGISTERS, READ_AND_WRITE, none);
                    }
                    qemu_plugin_register_vcpu_insn_exec_inline(instruction, INLINE_ADD, EXECUTED.as_ptr().cast(), 1);
                }
            }
        }
    }
}

/// Fetches a block of code: its address and its bytes are at `data`.
extern "C" fn fetched(_cpu: c_uint, data: *mut c_void) {
    // SAFETY: `translated` has allocated the pair, which is never freed.
    let (address, bytes) = unsafe { *data.cast::<(u64, u64)>() };
    if let Ok(mut memory) = MEMORY.lock() {
        memory.caches.touch(address, bytes, true);
    }
}

/// Reads or writes memory.
extern "C" fn accessed(_cpu: c_uint, info: u32, address: u64, _data: *mut c_void) {
    // SAFETY: the functions decode the number that qemu has passed.
    let (bytes, is_store) = unsafe { (1 << qemu_plugin_mem_size_shift(info), qemu_plugin_mem_is_store(info)) };
    let Ok(mut memory) = MEMORY.lock() else { return };
    memory.caches.touch(address, bytes, false);
    if memory.stack_top == 0 && is_store {
        memory.stack_top = address + bytes;
    }
    match memory.stack_top.checked_sub(address) {
        Some(depth) if depth < MAX_STACK_BYTES => memory.stack_bytes = memory.stack_bytes.max(depth),
        _ => (),
    }
}

/// Writes the cycles of a frame, and starts again.
fn report_cycles() {
    let [issue, latency] = [0, 1].map(|i| CYCLES[i].swap(0, Ordering::Relaxed));
    let Ok(mut memory) = MEMORY.lock() else { return };
    let Memory { caches, stack_bytes, .. } = &mut *memory;
    let misses = [std::mem::take(&mut caches.first_misses), std::mem::take(&mut caches.second_misses)];
    eprintln!("icycles {issue} {latency} {} {} {stack_bytes}", misses[0], misses[1]);
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
        if WITH_CYCLES.load(Ordering::Relaxed) {
            report_cycles();
        }
    }
}
