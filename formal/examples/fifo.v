// A FIFO of four bytes, AXI4-Stream on both sides: the example of ../README.md#properties-for-every-design.
module fifo (
  input  wire aclk,
  input  wire aresetn,
  input  wire s_tvalid,
  output wire s_tready,
  input  wire [7:0] s_tdata,
  input  wire s_tlast,
  output wire m_tvalid,
  input  wire m_tready,
  output wire [7:0] m_tdata,
  output wire m_tlast
);
  reg [35:0] entries;
  reg [2:0] write_count, read_count;
  wire [2:0] held = write_count - read_count;

  assign s_tready = held != 3'd4;
  assign m_tvalid = held != 3'd0;
  assign {m_tlast, m_tdata} = entries[9 * read_count[1:0] +: 9];

  always @(posedge aclk)
    if (~aresetn) begin
      write_count <= 3'd0;
      read_count <= 3'd0;
    end else begin
      write_count <= write_count + {2'd0, s_tvalid & s_tready};
      read_count <= read_count + {2'd0, m_tvalid & m_tready};
    end

  always @(posedge aclk)
    if (s_tvalid & s_tready)
      entries[9 * write_count[1:0] +: 9] <= {s_tlast, s_tdata};
endmodule
