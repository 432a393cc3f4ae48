# Each target does all the set-up that it needs; `make demo` and `make test` are enough.

VENV := .venv
BIN := $(VENV)/bin
PYTHON ?= $(shell for python in python3 python3.11 python3.12 python3.13 python3.14; do \
  $$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null \
  && { echo $$python; break; }; done)
STAMP := $(VENV)/.installed
TORCH := $(shell sed -n 's/^torch==//p' constraints.txt)
TORCH_CPU_INDEX := https://download.pytorch.org/whl/cpu
PIP := $(BIN)/python -m pip --disable-pip-version-check
JOBS ?= 2

.PHONY: venv demo test lint docs pictures clean
.DELETE_ON_ERROR:

venv: $(STAMP)

$(STAMP): pyproject.toml constraints.txt tools/check_system.py
	@test -n "$(PYTHON)" || { \
	  echo "no Python >= 3.11 found; install one, or name it: make venv PYTHON=/path/to/python3" >&2; \
	  exit 1; }
	@$(PYTHON) tools/check_system.py
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@# The CPU build of torch where it can be had (far smaller), else the usual one.
	$(PIP) install -q --no-compile --retries 1 --timeout 20 -c constraints.txt \
	  --extra-index-url $(TORCH_CPU_INDEX) "torch==$(TORCH)+cpu" 2>/dev/null \
	  || $(PIP) install -q --no-compile -c constraints.txt "torch==$(TORCH)"
	$(PIP) install -q --no-compile -c constraints.txt -e ".[visuals,test,notebooks,docs,bench,distributed]"
	@# A first run would compile for a minute; what fails here, `vh-drake doctor` explains.
	-$(BIN)/python -m vh_drake.experiments.warm
	@touch $@

demo: venv
	$(BIN)/vh-drake grasp --seed 0 --out out/demo

test: venv
	@$(BIN)/python tools/check_system.py --tests
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n $(JOBS) --dist loadfile -q

lint: venv
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: venv
	$(BIN)/python tools/build_docs.py docs/api

pictures: venv
	$(BIN)/python -m vh_drake.experiments.pictures

clean:
	rm -rf out build dist docs/api .pytest_cache .ruff_cache .mypy_cache .hypothesis
