//! What rust-hdl 0.46 gets wrong, reproduced: the reason for the rules the sources keep. A test that fails here after
//! an upgrade says which rule may be relaxed.

use hoverlock_harness::build::Build;
use rust_hdl::prelude::*;

/// One expression per trap.
#[derive(LogicBlock, Default)]
struct Traps {
    x: Signal<In, Bits<4>>,
    y: Signal<In, Bits<4>>,
    a: Signal<In, Signed<16>>,
    b: Signal<In, Signed<16>>,
    accumulator: Signal<In, Signed<40>>,
    carried: Signal<Out, Bits<8>>,
    precedence: Signal<Out, Bit>,
    p: Signal<In, Bit>,
    q: Signal<In, Bit>,
    r: Signal<In, Bit>,
    product: Signal<Out, Signed<40>>,
}

impl Logic for Traps {
    #[hdl_gen]
    fn update(&mut self) {
        self.carried.next = bit_cast::<8, 4>(self.x.val() + self.y.val());
        self.precedence.next = self.p.val() & self.q.val() == self.r.val();
        self.product.next = self.accumulator.val() + signed_bit_cast::<40, 32>(self.a.val() * self.b.val());
    }
}

#[test]
fn simulator_and_verilog_disagree_on_widths_and_precedence() {
    let mut traps = Traps::default();
    traps.connect_all();
    traps.x.next = 15u64.into();
    traps.y.next = 15u64.into();
    traps.a.next = 1000.into();
    traps.b.next = Signed::from(-1000);
    // Rust reads (p & q) == r.
    (traps.p.next, traps.q.next, traps.r.next) = (false, true, false);
    assert!(simulate(&mut traps, 10));
    assert_eq!(traps.carried.val().to_u64(), 14);
    assert!(traps.precedence.val());
    assert_eq!(traps.product.val(), Signed::from(-1_000_000));

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("top.v");
    std::fs::write(&file, generate_verilog_unchecked(&traps)).unwrap();
    let library = Build::new("top").source(&file).compile().unwrap();
    let mut model = library.instance().unwrap();
    let mut set = |name: &str, value: u64| {
        let signal = model.find(name).unwrap();
        model.set(signal, value).unwrap();
    };
    set("x", 15);
    set("y", 15);
    set("a", 1000);
    set("b", 0x1_0000 - 1000);
    set("p", 0);
    set("q", 1);
    set("r", 0);
    set("accumulator", 0);
    model.eval().unwrap();
    let get = |name: &str| model.get(model.find(name).unwrap());
    // The sum takes the width of its carried: the carry that Rust drops is kept.
    assert_eq!(get("carried"), 30);
    // Verilog reads p & (q == r).
    assert_eq!(get("precedence"), 0);
    // The product is cut to 16 bits before it is extended: -1000000 mod 2^16 as a signed word is -16960.
    assert_eq!(get("product"), (1 << 40) - 16_960);
}

/// A constant of the type used in a body.
#[derive(LogicBlock, Default)]
struct Leaky<const W: usize> {
    x: Signal<In, Bits<W>>,
    y: Signal<Out, Bits<8>>,
}

impl<const W: usize> Logic for Leaky<W> {
    #[hdl_gen]
    fn update(&mut self) {
        self.y.next = self.x.val().get_bits::<8>(W - 8);
    }
}

#[test]
fn a_constant_of_the_type_leaks_its_name() {
    let mut leaky = Leaky::<16>::default();
    leaky.connect_all();
    assert!(generate_verilog_unchecked(&leaky).contains('W'));
}

/// Two equal children.
#[derive(LogicBlock, Default)]
struct Twins {
    one: Leaky<16>,
    two: Leaky<16>,
    x: Signal<In, Bits<16>>,
    y: Signal<Out, Bits<8>>,
}

impl Logic for Twins {
    #[hdl_gen]
    fn update(&mut self) {
        self.one.x.next = self.x.val();
        self.two.x.next = self.x.val();
        self.y.next = self.one.y.val() & self.two.y.val();
    }
}

#[test]
fn equal_instances_become_modules_of_their_own_and_names_hold_dollars() {
    let mut twins = Twins::default();
    twins.connect_all();
    let printed = generate_verilog_unchecked(&twins);
    assert!(printed.contains("module top$one(") && printed.contains("module top$two("));
    assert!(printed.contains("module top("));
}

/// Whether a type has an operator, asked without an error where it has not.
struct Ask<T>(std::marker::PhantomData<T>);

trait No {
    const SHIFTS_RIGHT: bool = false;
    const MULTIPLIES: bool = false;
}

impl<T> No for Ask<T> {}

/// The same for one operator each: an answer of the type itself goes before that of the trait.
macro_rules! ask {
    ($($question:ident: $operator:ident<$with:ty>;)*) => {$(
        impl<T: std::ops::$operator<$with>> Ask<T> {
            const $question: bool = true;
        }
    )*};
}

ask! {
    SHIFTS_RIGHT: Shr<Bits<16>>;
    MULTIPLIES: Mul<T>;
}

#[test]
fn signed_words_do_not_shift_and_only_sixteen_bits_multiply() {
    let shifts = [Ask::<Bits<18>>::SHIFTS_RIGHT, Ask::<Signed<18>>::SHIFTS_RIGHT];
    assert_eq!(shifts, [true, false]);
    let sixteen = [Ask::<Bits<16>>::MULTIPLIES, Ask::<Signed<16>>::MULTIPLIES];
    let others = [Ask::<Bits<15>>::MULTIPLIES, Ask::<Bits<18>>::MULTIPLIES, Ask::<Signed<18>>::MULTIPLIES];
    assert_eq!((sixteen, others), ([true; 2], [false; 3]));
}

#[test]
fn registers_of_the_emission_have_resets_and_no_first_values() {
    // What rust-hdl's own flip-flop prints is `initial` and no reset; none of it is used here.
    let files = hoverlock_rtl::emission::files().unwrap();
    for file in files.iter().filter(|file| file.path.ends_with(".v")) {
        // A module with parameters checks them at the beginning, and sets nothing.
        let lines: Vec<&str> = file.text.lines().collect();
        for (at, _) in lines.iter().enumerate().filter(|(_, line)| line.contains("initial")) {
            let is_check = lines[at].starts_with("initial if (") && lines[at + 1].starts_with("  $error(");
            assert!(is_check && lines[at + 2..at + 4] == ["  $finish;", "end"], "{} relies on first values", file.path);
        }
        // Signed words never leave the sources: the datapath is unsigned.
        assert!(!file.text.contains("signed ") && !file.text.contains(">>>"), "{} is signed", file.path);
    }
    // Registers that say what is going on are reset; those that hold data need not be.
    for name in ["sequencer", "csr", "cursor", "candidate_queue", "record_fifo", "record_writer", "tail_counter"] {
        let file = files.iter().find(|file| file.path == format!("verilog/{name}.v")).unwrap();
        assert!(file.text.contains("if (reset)"), "{name} has no reset");
    }
}
