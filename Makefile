# `make help` lists the targets.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help

TARGET := thumbv7em-none-eabihf
BOARD_BUILD := --target $(TARGET) --profile firmware
# Programs that only QEMU runs: the same code, optimised crate by crate as on the host, whose macros serve for both. The bits are
# the same.
QEMU_BUILD := --target $(TARGET) --release
OUT := target/$(TARGET)/firmware
# Panics name their file: not where this machine keeps it, so that the firmware is the same everywhere.
export CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS := \
	--remap-path-prefix=$(or $(CARGO_HOME),$(HOME)/.cargo)/registry/src/=
# Flash 256 KiB; static RAM 48 KiB, with the stack that is allowed (`BUDGET_BYTES` of firmware/src/stack.rs) 96 KiB.
FLASH_LIMIT := 262144
RAM_LIMIT := 49152

.PHONY: help book first setup browser mujoco-setup test test-rest test-full python format lint lint-emulated lint-rest lint-boards studies test-host test-host-rest published hil hil-core hil-probe soak soak-program soak-short firmware firmware-g474 flash-g474 size no-panic cost demo fuzz bench

help: ## This list
	@grep -hE '^[a-z0-9-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

setup: ## Install what is missing: thumbv7em target, QEMU
	@tools/setup.sh

browser: ## Install Chromium where it is missing: it clicks through the pages in the tests
	@tools/setup.sh browser

mujoco-setup: ## A Python environment with MuJoCo for `stickslip-lab mujoco`, outside the repository
	@tools/mujoco/setup.sh

# With the features of `stickslip`, so that the long build goes on from it.
first: ## A first look before the long build: a recorded push through the predictor
	cargo build --release -p stickslip-first -p stickslip-cli --no-default-features --bin stickslip-first
	target/release/stickslip-first

# Without the server for Foxglove, an eighth of the build.
demo: first setup firmware ## A first look; a push through the firmware in QEMU, replayed and compared; drops prevented on the rig
	cargo run --release -p stickslip-cli --no-default-features -- demo

book: ## The manual as pages with a search, in book/, all links followed (installs mdBook into target/tools where there is none)
	command -v mdbook >/dev/null || [ -x target/tools/bin/mdbook ] || \
		cargo install --locked --root target/tools mdbook@0.5.4 --no-default-features --features search
	PATH="$$PATH:$(CURDIR)/target/tools/bin" mdbook build
	python3 tools/book_links.py book

# Tests of every change are compiled with clippy's lints and make their documentation: `cargo clippy` and `cargo doc` read all of
# it twice more.
LINTED := RUSTC_WORKSPACE_WRAPPER=$(CURDIR)/tools/lint-rustc.sh
# What is built for every change: the host without what few need (a server for Foxglove, figures as PNG) and without the
# second rig. Of all these crates, here and below: with `-p` cargo joins the features of fewer crates, and builds them all again.
QUICK := --workspace --exclude stickslip-firmware --exclude stickslip-hil-tests --exclude stickslip-python \
	--exclude stickslip-second-rig --no-default-features

test: setup ## After every change: lint, quick tests of every crate, the firmware in QEMU
	@tools/counted.sh test --beside "firmware lint-emulated" format test-host beside hil-core

test-rest: setup ## What `make test` leaves out: long tests, all features, second rig, browser, firmware of the G474 (CI runs both)
	@tools/counted.sh test-rest lint-rest test-host-rest hil firmware-g474 size no-panic

test-full: test test-rest python lint-boards studies soak-short ## And what takes longer: before anything is called done

python: ## The Python wheel (target/python/wheels), its tests and notebooks in an environment of its own
	tools/python.sh

format:
	cargo fmt --all --check

lint: format ## Formatting, clippy and documentation without warnings
	cargo clippy --all-targets --no-default-features -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --no-default-features

lint-emulated: ## Clippy for the emulated board
	cargo clippy -p stickslip-firmware --features mps2-an386 $(QEMU_BUILD) -- -D warnings

# All targets, tests of boards and examples among them, compiled as `test` does it: what has the same features is not compiled
# again, and what follows uses them.
lint-rest: ## Clippy and documentation of all features, clippy for the real board
	$(LINTED) cargo test --no-run --all-targets
	cargo clippy -p stickslip-firmware --features nucleo-g474re $(BOARD_BUILD) -- -D warnings

lint-boards: ## Clippy for the other board and the tests on boards
	cargo clippy -p stickslip-firmware --features simulated $(BOARD_BUILD) -- -D warnings
	cargo clippy -p stickslip-hil-tests --tests --features nucleo-g474re $(BOARD_BUILD) -- -D warnings
	cargo clippy -p stickslip-lab --features probe --test hil -- -D warnings

test-host: ## Quick tests of shared and host, their lints and documentation
	$(LINTED) cargo test --no-fail-fast --tests $(QUICK)

# Long ones are marked `ignored`, with this target as the reason. The memory of a process is measured alone.
test-host-rest: browser ## Long tests of shared and host, what all features add, the second rig; pages in a browser
	$(LINTED) cargo test --no-fail-fast --lib --test it --test kept --test browser -- --ignored --skip of_a_long_csv --skip published::
	$(LINTED) cargo test --no-fail-fast --test live --test second_rig
	$(LINTED) cargo test --no-fail-fast --test it -- figures_are_all_that_the_page_draws monitor::
	$(LINTED) cargo test --test it -- --ignored of_a_long_csv
	$(if $(wildcard ../shared/data ../../shared/data),@$(MAKE) --no-print-directory published)

published: ## Tests on the published recordings and problem files, where ../shared/data has them
	$(LINTED) cargo test --test it -- --ignored published::

studies: ## Tests that take minutes each (marked `ignored`)
	cargo test --release -p stickslip-lab --test blind -- --ignored

CORE := device::every_prediction device::a_refused_command device::after_every_kind device::a_reset_board
hil-core: firmware ## A streamed push on the emulated board, bit for bit, and its bad inputs
	STICKSLIP_FIRMWARE=$(CURDIR)/$(OUT)/stickslip-mps2-an386 $(LINTED) cargo test --test board $(QUICK) -- \
		--ignored --test-threads 1 $(CORE)

hil: setup firmware ## Tests on the emulated board, and of the line to it
	elf=$$(cargo test --no-run -p stickslip-hil-tests --features mps2-an386 $(QEMU_BUILD) --message-format=json \
		| grep -o '"executable":"[^"]*"' | tail -1 | cut -d'"' -f4); \
	STICKSLIP_HIL_ELF=$$elf $(LINTED) cargo test --test hil
	cargo build -p stickslip-firmware --bin overflow --features mps2-an386 $(QEMU_BUILD)
	cargo build -p stickslip-firmware --bin rehearsal --features rehearsed $(QEMU_BUILD)
	STICKSLIP_OVERFLOW=$(CURDIR)/target/$(TARGET)/release/overflow \
	STICKSLIP_REHEARSAL=$(CURDIR)/target/$(TARGET)/release/rehearsal \
	STICKSLIP_FIRMWARE=$(CURDIR)/$(OUT)/stickslip-mps2-an386 $(LINTED) cargo test --test board -- \
		--ignored --test-threads 1 device:: late:: post_mortem::
	STICKSLIP_REHEARSAL=$(CURDIR)/target/$(TARGET)/release/rehearsal \
	STICKSLIP_FIRMWARE=$(CURDIR)/$(OUT)/stickslip-mps2-an386 $(LINTED) cargo test --test board_commands -- --ignored --test-threads 1

hil-probe: ## The same tests on a Nucleo-G474RE behind a debug probe
	elf=$$(cargo test --no-run -p stickslip-hil-tests --features nucleo-g474re $(BOARD_BUILD) --message-format=json \
		| grep -o '"executable":"[^"]*"' | tail -1 | cut -d'"' -f4); \
	STICKSLIP_HIL_ELF=$$elf cargo test -p stickslip-lab --features probe --test hil -- --test-threads 1

soak-program: setup
	cargo build -p stickslip-firmware --bin soak --features simulated $(BOARD_BUILD)

soak-short: soak-program ## A minute of it
	tools/soak.sh $(OUT)/soak 15000

soak: soak-program ## An hour of virtual time with faults on the emulated board (TICKS=900000, SEED=TICKS)
	tools/soak.sh $(OUT)/soak $(or $(TICKS),900000) $(SEED)

firmware: ## Firmware for the emulated board
	cargo build -p stickslip-firmware --bin stickslip-firmware --features mps2-an386 $(QEMU_BUILD)
	@mkdir -p $(OUT) && cp target/$(TARGET)/release/stickslip-firmware $(OUT)/stickslip-mps2-an386

firmware-g474: ## Firmware for the Nucleo-G474RE
	cargo build -p stickslip-firmware --bin stickslip-firmware --features nucleo-g474re $(BOARD_BUILD)
	@cp $(OUT)/stickslip-firmware $(OUT)/stickslip-nucleo-g474re

flash-g474: firmware-g474 ## Write it to a connected board (needs probe-rs)
	probe-rs run --chip STM32G474RETx $(OUT)/stickslip-nucleo-g474re

size: firmware-g474 ## Flash and RAM of the firmware for the real board, against its limits
	@size $(OUT)/stickslip-nucleo-g474re | awk -v flash=$(FLASH_LIMIT) -v ram=$(RAM_LIMIT) 'NR == 2 { \
		printf "flash %d of %d bytes, static RAM %d of %d\n", $$1 + $$2, flash, $$2 + $$3, ram; \
		exit ($$1 + $$2 > flash || $$2 + $$3 > ram) }'
	STICKSLIP_G474_ELF=$(abspath $(OUT))/stickslip-nucleo-g474re $(LINTED) cargo test -q --test board -- --ignored memory_map:: stack_depth::

no-panic: firmware-g474 ## No panic can be reached from the control task
	STICKSLIP_NO_PANIC_ELF=$(abspath $(OUT))/stickslip-nucleo-g474re $(LINTED) cargo test --test board no_panic:: -- --ignored

cost: setup ## Instructions of the tick and its parts on the emulated board
	cargo build -p stickslip-firmware --features cost --bin cost --target $(TARGET) --profile cost
	@mkdir -p $(OUT) && cp target/$(TARGET)/cost/cost $(OUT)/cost
	cargo run --release -p stickslip-lab -- cost --cases data/worst/*.json

fuzz: setup ## Bytes that break the frame decoder, the predictor or a reader of files, looked for by coverage (FUZZ_SECONDS=60 each)
	@tools/fuzz.sh $(or $(FUZZ_SECONDS),60)

bench: ## The complementarity solvers against QuantEcon, Drake and Siconos; instructions of the tick
	@tools/bench/lcp.sh $(if $(NUMBER),--number $(NUMBER))
	@$(MAKE) --no-print-directory cost
