# Each target sets up .venv by itself where that is missing or out of date.
PYTHON ?= python3
VENV ?= .venv
CONSTRAINTS ?= constraints.txt
BIN := $(VENV)/bin
# What a target needs of the package's extras.
READY := $(VENV)/.ready
TEST := $(VENV)/.test
VERIFY := $(VENV)/.verify
CORE := $(VENV)/.core
PARALLEL ?= 2
PROCESSES ?= 3
# A test process that crashes ends the run: where xdist replaces it the others may wait for ever (3.8 with groups).
CRASH := --max-worker-restart 0

# Otherwise every process would compile all sources that it imports anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: report test core verify verify-status record pack wheel lint compile clean

report: $(READY)
	$(BIN)/quickreturn report

# What three processes would compile side by side, the tests' assertions among it, is compiled before, while the type checker is at work:
# each keeps one core busy; a mistake there is told by the run. The longest files come first. Tests wait for programs, browsers and time
# limits, so that three processes keep two cores busy.
test: $(TEST)
	$(MAKE) --jobs $(PARALLEL) lint compile
	$(BIN)/pytest -n $(PROCESSES) $(CRASH) --dist loadgroup --no-loadscope-reorder

# The quick tests of model, engines and cases with other versions, in an environment of its own:
# make core VENV=.venv-oldest CONSTRAINTS=constraints-oldest.txt, or VENV=.venv-newest PYTHON=python3.14
core: $(CORE)
	$(BIN)/pytest -n $(PARALLEL) $(CRASH) --dist loadgroup --no-loadscope-reorder tests/reference_model tests/engines tests/cases

# Everything that takes longer; the outcome is kept with the results and shown in the report. Speed is measured while nothing else runs.
# SLICE=k/n: the part that belongs to k, a whole number of any size; MINUTES: no test begins later (`tests/slices.py`).
verify: $(VERIFY)
ifdef SLICE
	$(BIN)/pytest -n $(PARALLEL) $(CRASH) --dist loadgroup -m verify --slice $(SLICE) $(if $(MINUTES),--begin-within $(MINUTES))
else
	$(BIN)/quickreturn benchmark
	$(BIN)/pytest -n $(PARALLEL) $(CRASH) --dist loadgroup -m verify --keep-outcome
endif

# Files with long tests that have not run since their code changed.
verify-status: $(VERIFY)
	$(BIN)/pytest -m verify --ledger-status --quiet

# For the project itself: results of the long studies as tables that the report shows where the user's own are missing.
record: $(READY)
	$(BIN)/python -m quickreturn.record

# Tables of the pack made anew in build/pack, and judged by those of pack/.
pack: $(VERIFY)
	$(BIN)/python -m quickreturn.plugins.pack build/pack

# The wheel with machine code for Linux on x86-64-v3; build/wheel/.
wheel: $(TEST)
	$(BIN)/python -P -m quickreturn.reference_model.entries
	$(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir build/wheel .
	rm -r reference_model/native/shipped

lint: $(TEST)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy quickreturn tests/verification

compile: $(TEST)
	$(BIN)/python -c 'import quickreturn as qr; [qr.simulate("thesis-24", name, store=False) for name in ("thesis", "reference", "mujoco")]'
	ls tests/__pycache__/*-pytest-*.pyc > /dev/null 2>&1 || $(BIN)/pytest -n 0 --collect-only --quiet --quiet > /dev/null || true

$(READY): EXTRA := [plot,tables]
$(TEST): EXTRA := [test]
$(VERIFY): EXTRA := [verify]
$(CORE): EXTRA := [core]
$(READY) $(TEST) $(VERIFY) $(CORE): pyproject.toml $(CONSTRAINTS)
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --no-compile --constraint $(CONSTRAINTS) --editable '.$(EXTRA)'
	touch $@

# Results stay: hours of computing; remove the folder .quickreturn to start from nothing.
clean:
	rm -rf $(VENV) reports/output
