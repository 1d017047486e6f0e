`timescale 1ns / 1ps
// A testbench in Verilog around a design, as the templates of TinyTapeout have it.
module tb;
    initial begin
        $dumpfile("tb.vcd");
        $dumpvars(0, tb);
        #1;
    end
    reg clk, rst_n, ena;
    reg [7:0] ui_in;
    wire [7:0] uo_out;
    counts user_project (.ui_in(ui_in), .uo_out(uo_out), .ena(ena), .clk(clk), .rst_n(rst_n));
endmodule

module counts (input wire [7:0] ui_in, output wire [7:0] uo_out, input wire ena, input wire clk, input wire rst_n);
    reg [7:0] count;
    always @(posedge clk or negedge rst_n)
        if (!rst_n) count <= 0;
        else if (ena) count <= count + ui_in;
    assign uo_out = count;
endmodule
