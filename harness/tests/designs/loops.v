// Does not settle while `on`.
module loops (input wire on, output wire x);
    /* verilator lint_off UNOPTFLAT */
    wire y;
    assign y = on ? !x : 1'b0;
    assign x = y;
endmodule
