# Two commands on a fresh machine: `make demo` and `make test`. Each installs what it needs, and is quick the second time.

SHELL := /bin/bash
export PATH := $(HOME)/.cargo/bin:$(PATH)

PICTURES := $(if $(XDG_CACHE_HOME),$(XDG_CACHE_HOME),$(HOME)/.cache)/hoverlock/pictures
HOVERLOCK := $(if $(CARGO_TARGET_DIR),$(CARGO_TARGET_DIR),target)/release/hoverlock
PYTHON := .venv/bin/python
# Real ground for the accuracy benchmark; its textures are in the folder of that name.
HOVERLOCK_DATA ?= ../shared/data
# One flight in so many: 1 takes all 208.
EVERY ?= 1
# A picture of at least 1024 x 768, for timing only; name aerial ones where you have them.
BENCH_PICTURES ?= $(PICTURES)/aloeL.jpg

.PHONY: demo test bench bench-accuracy bench-harness setup build

## On a real aerial photograph: the RTL under Verilator against the bit-true model, then the quantisation report with it as rtl.
demo: build
	$(HOVERLOCK) sim $(PICTURES)/aero1.jpg
	$(HOVERLOCK) report $(PICTURES)/aero1.jpg --out out/demo
	@echo "The report: $(CURDIR)/out/demo/index.html"

## Format, lints, and every test; the ignored ones take minutes each: real pictures, all frame sizes, faults put into the RTL.
test: setup
	cargo fmt --all -- --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	cargo test --workspace --locked
	cargo run --quiet --locked --package hoverlock-cli -- rtl check
	cargo test --workspace --locked -- --ignored
	VIRTUAL_ENV=$(CURDIR)/.venv .venv/bin/maturin develop --quiet --locked --manifest-path harness/python/Cargo.toml
	$(PYTHON) -m pytest --quiet -n 2 harness/python/tests

## Float features against OpenCV's ORB, by turns in one run; then bit_true in pixels a second, with and without AVX2.
bench: setup
	$(PYTHON) reference/benches/vs_orb.py $(BENCH_PICTURES)
	cargo bench --locked --package hoverlock-fixed-point --bench bit_true

## Accuracy over simulated flights above real ground, beside OpenCV's ORB, AKAZE, BRISK, SIFT and phase correlation.
bench-accuracy: setup
	$(PYTHON) reference/benches/accuracy.py --every $(EVERY) $(HOVERLOCK_DATA)/textures target/accuracy

## The harness against cocotb 1.9 on Verilator, cocotb 2 on Icarus and the plain C++ loop, equal outputs checked.
bench-harness:
	@setup/bootstrap.sh iverilog
	VIRTUAL_ENV=$(CURDIR)/.venv .venv/bin/maturin develop --profile wheel --quiet --locked --manifest-path harness/python/Cargo.toml
	$(PYTHON) harness/bench/run.py --runs 5

setup:
	@setup/bootstrap.sh

build: setup
	cargo build --release --locked --package hoverlock-cli
