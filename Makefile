# Everything from a fresh clone, with nothing else typed: make demo, make test. `make help` lists the targets.
# Needs Linux or macOS, Python >= 3.10 with venv, and Rust >= 1.89 (cargo); the rest goes into .venv.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
KINMO  := $(BIN)/kinmo
# A process a core, each for whole files of tests, since what is set up for one test of a file often serves the next.
PYTEST := $(BIN)/python -m pytest --numprocesses auto --maxprocesses 8 --dist loadfile
DEMO   := demo
# Shapes of a family; there are more of the one whose scans are looked at, as few of its shapes have the same joints.
COUNT  ?= 6
SCANNED       := laptop
SCANNED_COUNT ?= 12
# Shapes of a family, and the folder for training the networks that come with kinmo.
WEIGHTS_COUNT ?= 56
WEIGHTS := build/weights
SHIPPED := python/kinmo/shipped/models

RUST_SOURCES := Cargo.toml Cargo.lock $(shell find rust -name '*.rs' -o -name Cargo.toml)
SETUP_STAMP  := $(VENV)/.set-up

export PYO3_PYTHON := $(abspath $(BIN)/python)
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.DEFAULT_GOAL := help
.PHONY: help setup demo weights test test-rust test-python fuzz lint lint-rust lint-python wheel clean

help: ## list the targets
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## (.*)/  make \1|\2/' | column -t -s '|' 2>/dev/null \
	    || grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST)

setup: $(SETUP_STAMP) ## build the Rust core and install kinmo, its tests' and lint's tools into .venv

$(VENV)/bin/python:
	@command -v $(PYTHON) >/dev/null || { echo "make: $(PYTHON) is not there; kinmo needs Python >= 3.10 (or say make PYTHON=python3.11)" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' \
	    || { echo "make: $(PYTHON) is `$(PYTHON) --version`; kinmo needs Python >= 3.10 (or say make PYTHON=python3.11)" >&2; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null \
	    || { echo "make: $(PYTHON) has no venv module (Debian and Ubuntu: apt-get install python3-venv)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

# Installed in place (-e): Python changes need no new set-up, changes of Rust or of the dependencies do.
$(SETUP_STAMP): pyproject.toml $(RUST_SOURCES) | $(VENV)/bin/python
	@command -v cargo >/dev/null || { echo "make: cargo is not there; kinmo's core is Rust >= 1.89: https://rustup.rs" >&2; exit 1; }
	$(BIN)/python -m pip install --quiet -e '.[test,lint]'
	@touch $@

demo: $(SETUP_STAMP) ## the whole road on procedural shapes, scans of laptops included (resumable)
	$(KINMO) synth $(DEMO)/partnet --count $(COUNT)
	$(KINMO) synth $(DEMO)/partnet --count $(SCANNED_COUNT) --family $(SCANNED)
	$(KINMO) prepare $(DEMO)/partnet --workspace $(DEMO)/workspace
	$(KINMO) train all --config small --category $(SCANNED) --workspace $(DEMO)/workspace
	$(KINMO) render --config small --category $(SCANNED) --example $(DEMO)/scan.npz --workspace $(DEMO)/workspace
	$(KINMO) predict $(DEMO)/scan.npz --category $(SCANNED) --out $(DEMO)/predicted --workspace $(DEMO)/workspace
	$(KINMO) pseudo-label --workspace $(DEMO)/workspace
	$(KINMO) eval --workspace $(DEMO)/workspace
	$(KINMO) report --workspace $(DEMO)/workspace

weights: $(SETUP_STAMP) ## train the networks that come with kinmo again, from a seed (several hours on two cores)
	$(KINMO) synth $(WEIGHTS)/partnet --count $(WEIGHTS_COUNT) --layout partnet_mobility
	$(KINMO) prepare $(WEIGHTS)/partnet --workspace $(WEIGHTS)/workspace
	$(KINMO) train kinmo --config shipped --workspace $(WEIGHTS)/workspace
	for model in grouping ranking limits; do \
	    mkdir -p $(SHIPPED)/$$model; \
	    cp $(WEIGHTS)/workspace/models/$$model/weights.safetensors $(WEIGHTS)/workspace/models/$$model/weights.json $(SHIPPED)/$$model; \
	done

test: test-rust test-python ## run all tests, the same examples of every property each time

test-rust:
	PROPTEST_RNG_SEED=1 PROPTEST_DISABLE_FAILURE_PERSISTENCE=1 cargo test --quiet --locked -p kinmo-geometry

test-python: $(SETUP_STAMP)
	$(PYTEST)

fuzz: $(SETUP_STAMP) ## look for counterexamples: new examples of every property, many of the Rust ones
	PROPTEST_CASES=5000 cargo test --release --quiet --locked -p kinmo-geometry
	HYPOTHESIS_PROFILE=fuzz $(PYTEST)

lint: lint-rust lint-python ## formats, types, clippy, docs; warnings are errors

lint-rust: $(VENV)/bin/python
	cargo fmt --all --check
	cargo clippy --quiet --locked --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS='-D warnings' cargo doc --quiet --locked --workspace --no-deps --document-private-items

lint-python: $(SETUP_STAMP)
	$(BIN)/ruff check python tests bench examples
	$(BIN)/ruff format --check python tests bench examples
	$(BIN)/mypy

wheel: $(SETUP_STAMP) ## build the wheel into dist/
	$(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir dist .
	@ls dist/*.whl

clean: ## remove what was built (not .venv: remove it by hand to set up anew)
	cargo clean
	rm -rf dist $(DEMO) .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find python tests bench -name __pycache__ -type d -prune -exec rm -rf {} +
