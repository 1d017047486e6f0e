// Four registers behind Avalon-MM, with a wait state in each access.
module registers (
    input  wire        clk,
    input  wire [1:0]  csr_address,
    input  wire        csr_read,
    input  wire        csr_write,
    input  wire [31:0] csr_writedata,
    output reg  [31:0] csr_readdata,
    output wire        csr_waitrequest
);
    reg [31:0] words [0:3];
    reg waited;
    integer i;
    initial begin
        waited = 0;
        for (i = 0; i < 4; i = i + 1) words[i] = 0;
    end
    assign csr_waitrequest = (csr_read || csr_write) && !waited;
    always @(posedge clk) begin
        waited <= (csr_read || csr_write) && !waited;
        if (csr_write && waited) words[csr_address] <= csr_writedata;
        csr_readdata <= words[csr_address];
    end
endmodule
