// The top of a bench that tests Python alone, such as models of PCIe devices that talk to each other.
module empty;
endmodule
