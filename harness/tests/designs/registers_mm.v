// Eight registers behind Avalon-MM; STALL cycles of waitrequest, LATENCY cycles to the data, byte enables.
module registers_mm #(parameter STALL = 0, parameter LATENCY = 1) (
    input  wire        clk,
    input  wire        rst,
    input  wire [2:0]  csr_address,
    input  wire        csr_read,
    input  wire        csr_write,
    input  wire [31:0] csr_writedata,
    input  wire [3:0]  csr_byteenable,
    output wire [31:0] csr_readdata,
    output wire        csr_readdatavalid,
    output wire        csr_waitrequest
);
    reg [31:0] word [0:7];
    reg [7:0] waited;
    reg [31:0] data [0:7];
    reg [7:0] valid;
    integer i;
    wire command = csr_read || csr_write;
    assign csr_waitrequest = command && waited < STALL;
    assign csr_readdata = data[LATENCY-1];
    assign csr_readdatavalid = valid[LATENCY-1];
    always @(posedge clk) begin
        waited <= (command && csr_waitrequest) ? waited + 1'b1 : 8'd0;
        valid <= {valid[6:0], csr_read && !csr_waitrequest};
        data[0] <= word[csr_address];
        for (i = 1; i < 8; i = i + 1) data[i] <= data[i-1];
        if (rst) begin
            valid <= 0;
            waited <= 0;
            for (i = 0; i < 8; i = i + 1) word[i] <= 0;
        end else if (csr_write && !csr_waitrequest)
            for (i = 0; i < 4; i = i + 1)
                if (csr_byteenable[i]) word[csr_address][8*i +: 8] <= csr_writedata[8*i +: 8];
    end
endmodule
