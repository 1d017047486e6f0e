// 64 words on an Avalon-MM slave with bursts: it makes every command and every word of a write wait STALL cycles.
module burst_ram #(parameter STALL = 0) (
    input  wire        clk,
    input  wire        rst,
    input  wire [5:0]  mem_address,
    input  wire        mem_read,
    input  wire        mem_write,
    input  wire [31:0] mem_writedata,
    input  wire [3:0]  mem_burstcount,
    output wire        mem_waitrequest,
    output reg         mem_readdatavalid,
    output reg  [31:0] mem_readdata
);
    reg [31:0] words [0:63];
    reg [5:0]  at;
    reg [3:0]  writes, reads;
    reg [7:0]  waited;
    // A new command waits until the reads before it are answered.
    assign mem_waitrequest = rst || reads != 0 || waited < STALL;
    wire asked = mem_read || mem_write;
    always @(posedge clk) begin
        mem_readdatavalid <= 0;
        if (rst) begin
            writes <= 0;
            reads <= 0;
            waited <= 0;
        end else begin
            waited <= (asked && mem_waitrequest && reads == 0) ? waited + 1'b1 : 8'd0;
            if (mem_write && !mem_waitrequest) begin
                words[writes == 0 ? mem_address : at] <= mem_writedata;
                at <= (writes == 0 ? mem_address : at) + 1'b1;
                writes <= (writes == 0 ? mem_burstcount : writes) - 1'b1;
            end else if (mem_read && !mem_waitrequest) begin
                at <= mem_address;
                reads <= mem_burstcount;
            end else if (reads != 0) begin
                mem_readdata <= words[at];
                mem_readdatavalid <= 1;
                at <= at + 1'b1;
                reads <= reads - 1'b1;
            end
        end
    end
endmodule
