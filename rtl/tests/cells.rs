//! Every cell, and what is built of them, three ways: bit-true reference == rust-hdl's simulator == Verilator on the committed files.

mod leaf;

macro_rules! gates {
    ($($gate:ident)*) => {
        $(
            #[test]
            fn $gate() {
                leaf::$gate();
            }
        )*

        #[test]
        fn no_gate_is_forgotten() {
            let run = [$(stringify!($gate)),*];
            assert!(leaf::GATES.iter().all(|(name, _)| run.contains(name)));
        }
    };
}

gates! {
    every_leaf_has_a_gate
    lerp_is_the_bit_true_lerp
    difference_rounds_half_up_keeps_the_sign_and_saturates
    window_maxima_are_those_of_the_definition
    maxima_and_comparisons
    delays
    lines_of_every_depth
    lines_and_addresses
    borders_and_places
    every_threshold_moves_as_the_model_says
    words_side_by_side
    queues_and_records
    sequencer_under_any_stream
    registers_read_back_and_clear
}

mod structure {
    use crate::leaf::structure;

    #[test]
    fn row_stages() {
        structure::row_stages();
    }

    #[test]
    fn column_stage() {
        structure::column_stage();
    }

    #[test]
    fn layer() {
        structure::layer();
    }

    #[test]
    fn smoothers() {
        structure::smoothers();
    }

    #[test]
    #[ignore = "long: rust-hdl's simulator takes a millisecond a cycle"]
    fn core() {
        structure::core();
    }

    #[test]
    fn no_gate_is_forgotten() {
        assert_eq!(
            structure::GATES.map(|(name, _)| name),
            ["row_stages", "column_stage", "smoothers", "layer", "core"]
        );
    }
}
