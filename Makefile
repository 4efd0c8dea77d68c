# One command for each thing that people do here. `make help` lists them.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
OUT ?= out
# Modules are compiled once, not at each of the hundreds of starts that the tests make.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help setup demo test lint format bench bags lock clean

help: ## list the commands
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/' | expand -t 12

setup: $(READY) ## make the virtual environment with the locked versions

$(READY): requirements.lock pyproject.toml
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@echo "Compiling the tracker's inner loops..."
	$(BIN)/python -c 'import worm_tracker.tracker'
	@touch $@

demo: $(READY) ## replay the example trial, pool it with twelve others, and write both reports
	@$(BIN)/worm replay bags/trial --out $(OUT)/trial
	@$(BIN)/worm report $(OUT)/trial bags/pool/trial_* --out $(OUT)/pooled

test: $(READY) ## all tests; TESTS="tests/worm_analysis" runs some
	@$(BIN)/python -m pytest -n auto --dist loadgroup --no-loadscope-reorder $(TESTS)

lint: $(READY) ## formatting, style, types
	@$(BIN)/ruff format --check .
	@$(BIN)/ruff check --no-cache .
	@$(BIN)/mypy

format: $(READY) ## mend formatting and what ruff can mend
	@$(BIN)/ruff format .
	@$(BIN)/ruff check --fix .

bench: $(READY) ## measure: the graph, the tracker, the analysis
	@$(BIN)/python -m benchmarks

bags: $(READY) ## rebuild the example bags
	@$(BIN)/python bags/build.py

lock: $(READY) ## resolve the versions anew
	@$(BIN)/python -m pip install --quiet uv
	@$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --extra dev --generate-hashes --no-strip-extras \
	  --no-emit-index-url --no-emit-find-links --upgrade pyproject.toml --output-file requirements.lock

clean: ## remove what these commands made
	rm -rf $(VENV) out build .pytest_cache .mypy_cache .ruff_cache .hypothesis ros2_ws/build ros2_ws/install ros2_ws/log
