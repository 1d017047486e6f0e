# For a Makefile written for cocotb: this line in place of the include of Makefile.sim,
#
#     include $(shell python3 -m hoverlock --makefile)
#
# and `make` runs the benches here, with the alias. Heeded: VERILOG_SOURCES, VERILOG_INCLUDE_DIRS, TOPLEVEL, MODULE, TESTCASE,
# EXTRA_ARGS, COMPILE_ARGS, PLUSARGS, WAVES, RANDOM_SEED, COCOTB_RESULTS_FILE, and cocotb 2's names for them.
# HOVERLOCK_ARGS are further options of `python -m hoverlock`.

ifeq ($(TOPLEVEL_LANG),vhdl)
    $(error TOPLEVEL_LANG=vhdl: Verilator reads Verilog only)
endif
ifneq ($(strip $(VHDL_SOURCES)),)
    $(error VHDL_SOURCES: Verilator reads Verilog only)
endif

PYTHON ?= python3
COCOTB_RESULTS_FILE ?= results.xml
hoverlock_comma := ,
hoverlock_top := $(or $(COCOTB_TOPLEVEL),$(TOPLEVEL))
hoverlock_modules := $(subst $(hoverlock_comma), ,$(or $(COCOTB_TEST_MODULES),$(MODULE)))
hoverlock_tests := $(or $(COCOTB_TESTCASE),$(TESTCASE))
hoverlock_seed := $(or $(COCOTB_RANDOM_SEED),$(RANDOM_SEED))
hoverlock_plusargs := $(or $(COCOTB_PLUSARGS),$(PLUSARGS))

.PHONY: all sim regression clean
all sim regression:
	$(if $(hoverlock_top),,$(error TOPLEVEL is not set))
	$(if $(hoverlock_modules),,$(error MODULE is not set))
	$(PYTHON) -m hoverlock --as-cocotb --junit $(COCOTB_RESULTS_FILE) --hoverlock-top $(hoverlock_top) \
	    $(addprefix --hoverlock-source ,$(VERILOG_SOURCES)) \
	    $(foreach flag,$(COMPILE_ARGS) $(EXTRA_ARGS) $(addprefix -I,$(VERILOG_INCLUDE_DIRS)),'--hoverlock-flag=$(flag)') \
	    $(foreach plusarg,$(hoverlock_plusargs),'--hoverlock-plusarg=$(plusarg)') \
	    $(if $(filter-out 0,$(WAVES)),--hoverlock-waves vcd) \
	    $(if $(hoverlock_seed),--hoverlock-seed $(hoverlock_seed)) \
	    $(if $(hoverlock_tests),--test $(hoverlock_tests)) \
	    $(HOVERLOCK_ARGS) $(hoverlock_modules)

clean:
	rm -rf $(COCOTB_RESULTS_FILE) hoverlock-output
