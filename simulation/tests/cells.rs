//! Every cell, and what is built of cells, three ways: bit-true model == rust-hdl's simulator == Verilator on the
//! committed files.

mod three_way;

/// A test for each named check; one that compares the names with the list.
macro_rules! tests {
    ($list:expr => $($check:ident)*; $(#[ignore = $reason:literal] $long:ident)*) => {
        $(
            #[test]
            fn $check() {
                crate::three_way::run(stringify!($check));
            }
        )*

        $(
            #[test]
            #[ignore = $reason]
            fn $long() {
                crate::three_way::run(stringify!($long));
            }
        )*

        #[test]
        fn no_check_is_forgotten() {
            let tested = [$(stringify!($check),)* $(stringify!($long),)*];
            assert_eq!($list.map(|(name, _)| name).to_vec(), tested);
        }
    };
}

tests! { crate::three_way::CHECKS =>
    every_leaf_has_a_check
    lerp_is_the_bit_true_lerp
    difference_rounds_half_up_keeps_the_sign_and_saturates
    window_maxima_are_those_of_the_definition
    maxima_and_comparisons
    every_threshold_moves_as_the_model_says
    the_record_limit_is_the_law_of_the_model
    delays
    lines_of_every_depth
    column_rows
    lines_and_addresses
    borders_and_positions
    samples_side_by_side
    queues_and_records
    sequencer_under_any_stream
    registers_read_back_and_clear;
}

mod structure {
    tests! { crate::three_way::structure::CHECKS =>
        row_stages
        column_look_ahead
        smoothers
        scale_pair;
        #[ignore = "long: rust-hdl's simulator takes a millisecond a cycle"]
        core
    }
}
