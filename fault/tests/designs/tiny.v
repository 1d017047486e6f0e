// One register for each outcome of an upset, so that every outcome is known.
module tiny (
    input clk,
    input rst,
    input [3:0] in,
    output [3:0] out,
    output reg [7:0] total,
    output alarm
);
    reg [3:0] unread; // no one reads it: masked
    reg [3:0] stage; // written in each cycle: the output is wrong in one cycle
    reg [3:0] guarded; // wrong in one cycle, and its parity shows it
    reg guard;
    reg [3:0] words[0:3]; // never written after the reset, and one is read in each cycle
    reg [1:0] at;
    reg armed; // ends the simulation

    assign out = stage ^ guarded ^ words[at];
    assign alarm = ^guarded != guard;

    always @(posedge clk)
        if (rst) begin
            unread <= 0;
            stage <= 0;
            guarded <= 0;
            guard <= 0;
            words[0] <= 1;
            words[1] <= 2;
            words[2] <= 3;
            words[3] <= 4;
            at <= 0;
            armed <= 0;
            total <= 0;
        end else begin
            unread <= unread + in;
            stage <= in;
            guarded <= in;
            guard <= ^in;
            at <= at + 1;
            total <= total + {4'd0, in};
            armed <= armed;
            if (armed) $finish;
        end
endmodule
