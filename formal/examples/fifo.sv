// The properties of fifo.v by the property modules: the rules of the input are assumed, those of the output asserted.
module fifo_properties (
  input wire aclk, input wire aresetn, input wire s_tvalid, input wire [7:0] s_tdata, input wire s_tlast, input wire m_tready
);
  wire s_tready, m_tvalid, m_tlast;
  wire [7:0] m_tdata;
  fifo dut (
    .aclk(aclk), .aresetn(aresetn), .s_tvalid(s_tvalid), .s_tready(s_tready), .s_tdata(s_tdata), .s_tlast(s_tlast),
    .m_tvalid(m_tvalid), .m_tready(m_tready), .m_tdata(m_tdata), .m_tlast(m_tlast)
  );

  axi4_stream #(.BYTES(1), .ASSUMED(1)) into (
    .aclk(aclk), .aresetn(aresetn), .tvalid(s_tvalid), .tready(s_tready), .tdata(s_tdata), .tkeep(1'b1), .tstrb(1'b1),
    .tlast(s_tlast), .side(1'b0)
  );
  wire waited;
  wire [11:0] waiting;
  axi4_stream #(.BYTES(1)) out (
    .aclk(aclk), .aresetn(aresetn), .tvalid(m_tvalid), .tready(m_tready), .tdata(m_tdata), .tkeep(1'b1), .tstrb(1'b1),
    .tlast(m_tlast), .side(1'b0), .waited(waited), .waiting(waiting)
  );
  wire [15:0] inside, ahead;
  wire following;
  wire [8:0] followed;
  stream_order #(.DATA(9), .ENTRIES(4)) beats (
    .clock(aclk), .reset(~aresetn), .take(s_tvalid & s_tready), .taken({s_tlast, s_tdata}),
    .offered(m_tvalid), .leave(m_tvalid & m_tready), .leaving({m_tlast, m_tdata}),
    .inside(inside), .following(following), .ahead(ahead), .followed(followed)
  );

  // The invariants for the induction: relations between the registers of the FIFO and the state of the rules.
  (* hierconn *) wire [2:0] \dut.held ;
  (* hierconn *) wire [2:0] \dut.read_count ;
  (* hierconn *) wire [35:0] \dut.entries ;
  wire [1:0] place = \dut.read_count [1:0] + ahead[1:0];
  reg begun = 0;
  always @(posedge aclk) begin
    begun <= 1;
    if (!begun) assume (!aresetn);
    if (begun) begin
      invariant_held: assert (inside == {13'd0, \dut.held });
      invariant_kept: assert (!following || \dut.entries [9 * place +: 9] == followed);
      full: cover (\dut.held == 3'd4);
      through: cover (m_tvalid && m_tready && m_tlast && m_tdata == 8'd77);
    end
  end
endmodule
