# Everything starts here; `make` alone lists the targets. Running a target twice does no work twice.

SHELL  := /bin/bash
PYTHON ?= python3
CXX    ?= g++

VENV  := .venv
PY    := $(VENV)/bin/python
PIP   := $(PY) -m pip --disable-pip-version-check -q
BUILD := build/make
SANE  := build/sanitize

export CMAKE_BUILD_PARALLEL_LEVEL ?= $(shell nproc 2>/dev/null || getconf _NPROCESSORS_ONLN)

BUILD_REQUIREMENTS := 'scikit-build-core>=0.11' 'pybind11>=3' 'cmake>=3.21' 'ninja>=1.10'
PIP_BUILD := $(PIP) install --no-build-isolation --config-settings=cmake.define.GLOSSA_WERROR=ON

# Folders count too: adding or removing a file changes their time.
SOURCES := CMakeLists.txt pyproject.toml README.md LICENSE \
  $(shell find cmake cpp python data -not -path '*__pycache__*' -not -name '*.py[co]' 2>/dev/null)
CPP_TESTS := $(shell find tests/cpp 2>/dev/null)

MADE_VENV    := $(VENV)/.made-venv
MADE_DEV     := $(VENV)/.made-dev
MADE_PACKAGE := $(VENV)/.made-package
CPP_TEST_RUN := $(BUILD)/glossa_cpp_tests
MADE_SANE    := $(SANE)/.made-package

.PHONY: help vowels test notebooks lint sanitize bench build clean system
.DEFAULT_GOAL := help

help:
	@echo "make vowels    install what is missing, build, print and plot the four vowels (vowels.png)"
	@echo "make test      C++ and Python tests, notebooks among them"
	@echo "make notebooks run the notebooks at full settings and write their outputs"
	@echo "make lint      ruff, clang-format and mypy"
	@echo "make bench     benchmarks, with their tables"
	@echo "make sanitize  C++ tests and fast Python tests under the address and undefined-behaviour sanitizers"
	@echo "make build     install the package into $(VENV)"
	@echo "make clean     remove $(VENV) and everything built"

vowels: $(MADE_PACKAGE)
	$(VENV)/bin/glossa vowels --plot vowels.png

# Files share what they make (speakers, scenes, postures), so each goes to one process whole.
test: $(CPP_TEST_RUN) $(MADE_DEV)
	$(CPP_TEST_RUN)
	$(PY) -m pytest -n auto --maxprocesses 8 --dist loadfile

notebooks: $(MADE_PACKAGE) $(MADE_DEV)
	$(PY) -m pytest notebooks --overwrite

lint: $(MADE_PACKAGE) $(MADE_DEV)
	$(VENV)/bin/ruff check .
	$(VENV)/bin/clang-format --dry-run -Werror $$(find cpp tests/cpp -name '*.[ch]pp')
	$(VENV)/bin/mypy

bench: $(MADE_PACKAGE) $(MADE_DEV)
	$(PY) -m pytest tests/benchmarks --benchmark-enable -s -m ""

build: $(MADE_PACKAGE)

clean:
	rm -rf $(VENV) build dist vowels.png .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# ---- Environment -----------------------------------------------------------------------------------------------------

system:
	@CXX=$(CXX) .ci/system-packages $(PYTHON)

$(MADE_VENV): | system
	$(PYTHON) -m venv --clear $(VENV)
	$(PIP) install $(BUILD_REQUIREMENTS)
	@touch $@

$(MADE_DEV): pyproject.toml $(MADE_VENV)
	$(PY) -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["dev"], sep="\n")' \
	  > $(VENV)/dev-requirements.txt
	$(PIP) install -r $(VENV)/dev-requirements.txt
	@touch $@

# ---- Package and C++ tests, in one build folder ----------------------------------------------------------------------

$(MADE_PACKAGE): $(SOURCES) $(MADE_VENV)
	$(PIP_BUILD) --config-settings=build-dir=$(BUILD) .
	@touch $@

$(CPP_TEST_RUN): $(MADE_PACKAGE) $(CPP_TESTS)
	$(VENV)/bin/cmake -S . -B $(BUILD) -DGLOSSA_TESTS=ON
	$(VENV)/bin/cmake --build $(BUILD) --target glossa_cpp_tests
	@touch $@

# ---- Sanitizers ------------------------------------------------------------------------------------------------------
# Python itself is not instrumented: the sanitizer's library is loaded first, and with it libstdc++, whose exceptions it
# intercepts. Python keeps memory until it exits, so leaks are looked for in the C++ tests only. Capturing leaves stderr
# alone, or a report would be lost with the process that it ends.

$(MADE_SANE): $(SOURCES) $(CPP_TESTS) $(MADE_PACKAGE)
	$(PIP_BUILD) --no-deps --upgrade --target $(SANE)/site --config-settings=build-dir=$(SANE) \
	  --config-settings=cmake.build-type=Debug --config-settings=cmake.define.GLOSSA_SANITIZE=ON \
	  --config-settings=cmake.define.GLOSSA_TESTS=ON .
	$(VENV)/bin/cmake --build $(SANE) --target glossa_cpp_tests
	@touch $@

sanitize: export UBSAN_OPTIONS := print_stacktrace=1:halt_on_error=1
sanitize: $(MADE_SANE) $(MADE_DEV)
	$(SANE)/glossa_cpp_tests
	ASAN_OPTIONS=detect_leaks=0 PYTHONMALLOC=malloc PYTHONPATH=$(SANE)/site \
	LD_PRELOAD="$$($(CXX) -print-file-name=libasan.so) $$($(CXX) -print-file-name=libstdc++.so)" \
	  $(PY) -m pytest --benchmark-skip --capture=sys
