# The rules of a Makefile written for cocotb. `cocotb-config --makefiles` of this package names the folder in which `Makefile.sim`
# includes this file, so that such a Makefile needs no change. The variables are those of cocotb 1.9 and 2; they are read when a
# recipe runs, so that they may be set after the include. HOVERLOCK_ARGS are further options of `python -m hoverlock`.

PYTHON ?= python3
COCOTB_RESULTS_FILE ?= results.xml
SIM_BUILD ?= sim_build
export TOPLEVEL_LANG ?= verilog
export COCOTB_RESULTS_FILE
hoverlock_top = $(or $(COCOTB_TOPLEVEL),$(TOPLEVEL))
hoverlock_modules = $(or $(COCOTB_TEST_MODULES),$(MODULE))
hoverlock_timescale = $(COCOTB_HDL_TIMEUNIT)$(if $(COCOTB_HDL_TIMEPRECISION),/$(COCOTB_HDL_TIMEPRECISION))

.PHONY: all sim regression clean hoverlock_run
all: sim
regression: sim

# The results of an earlier run are removed before the sources are made: a build that stops leaves none. The second call of make
# makes the sources that the Makefile generates.
sim:
	@rm -f $(COCOTB_RESULTS_FILE)
	@$(MAKE) --no-print-directory -f $(firstword $(MAKEFILE_LIST)) hoverlock_run

# Sources are read at the second expansion: they may be added after the include. The shell expands their globs and quotes.
.SECONDEXPANSION:
hoverlock_run: $$(VERILOG_SOURCES) $$(CUSTOM_COMPILE_DEPS) $$(CUSTOM_SIM_DEPS)
	@PYTHONPATH="$(CURDIR)$(if $(PYTHONPATH),:$(PYTHONPATH))" $(PYTHON) -m hoverlock make \
	    @simulator $(SIM) @language $(TOPLEVEL_LANG) @top $(hoverlock_top) @modules $(hoverlock_modules) \
	    @sources $(VERILOG_SOURCES) @vhdl $(VHDL_SOURCES) @includes $(VERILOG_INCLUDE_DIRS) \
	    @compile $(COMPILE_ARGS) $(EXTRA_ARGS) @run $(SIM_ARGS) $(EXTRA_ARGS) @plusargs $(or $(COCOTB_PLUSARGS),$(PLUSARGS)) \
	    @timescale $(hoverlock_timescale) @waves $(WAVES) @seed $(or $(COCOTB_RANDOM_SEED),$(RANDOM_SEED)) \
	    @tests $(or $(COCOTB_TESTCASE),$(TESTCASE)) @filter '$(subst ','\'',$(COCOTB_TEST_FILTER))' \
	    @results $(COCOTB_RESULTS_FILE) @options $(HOVERLOCK_ARGS)

define check_for_results_file
    @test -f $(COCOTB_RESULTS_FILE) || { echo "no $(COCOTB_RESULTS_FILE): the run ended without results" >&2; exit 1; }
endef

clean::
	rm -rf $(SIM_BUILD) $(COCOTB_RESULTS_FILE) hoverlock-output
