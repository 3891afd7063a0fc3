# Two commands do all: `make demo` sets up and runs the main job, `make test` sets up and tests. The
# first installs what a run needs, the second also what only the tests need, as do all others.
# `make docs` builds the documentation. `make bench` measures us beside our peers, in environments
# of their own (`make bench FULL=--full`). `make verify` runs long campaigns. `make platforms`
# compiles the libraries of every platform for this source tree, and puts a wheel that has them into
# dist/; the first time it takes minutes.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
JOBS ?= 2
# the package ziglang, of the extra `platforms`, compiles where there is no C compiler
ifeq ($(shell command -v cc || command -v gcc || command -v clang),)
COMPILER := platforms
endif
# the tests run side by side, and their matrices are small: threads would only get in the way
export OPENBLAS_NUM_THREADS ?= 1
# hundreds of their processes import the package: each would compile it again
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test check verify lint docs bench platforms setup clean

demo: $(VENV)/installed
	$(BIN)/m4e-fmi run examples/moored_buoy/system.yaml --report
	@echo "next: $(BIN)/m4e-fmi study examples/power_matrix/quick.yaml --report, its power in 12 seas"

test: setup lint
	$(BIN)/pytest -n $(JOBS) --dist worksteal

# lint, types and the nearest tests of what is changed, within a minute; it says what it left out
check: setup
	cd tests && $(CURDIR)/$(BIN)/python -m support.check

# long campaigns, by hand; VERIFY chooses some: make verify VERIFY="-k coupling"
verify: setup
	$(BIN)/pytest -n $(JOBS) -rA -m verify $(VERIFY)

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyrefly check

# the pages are in build/docs; open index.html
docs: setup
	$(BIN)/sphinx-build -W --keep-going -q docs build/docs

bench: .venv-bench/ready
	cd tests && ../.venv-bench/bin/python -m benchmark.run $(FULL)
	cd tests && ../.venv-bench/bin/python -m benchmark.pinocchio_trees
	cd tests && ../.venv-bench/bin/python -m benchmark.space
	cd tests && ../.venv-bench/bin/python -m benchmark.whole
	cd tests && ../.venv-bench/bin/python -m benchmark.hydrodynamics

# a peer that cannot be installed is reported by the benchmark, not here
.venv-bench/ready: pyproject.toml constraints.txt tests/benchmark/constraints.txt tests/benchmark/install
	tests/benchmark/install $(PYTHON)
	touch $@

platforms: .venv-platforms/ready
	.venv-platforms/bin/python -m m4e_fmi.runtime.platforms
	M4E_FMI_PLATFORMS=all .venv-platforms/bin/python -m pip --disable-pip-version-check --quiet \
		wheel --no-deps --no-build-isolation --wheel-dir dist .

.venv-platforms/ready: constraints.txt
	$(PYTHON) -m venv .venv-platforms
	.venv-platforms/bin/python -m pip --disable-pip-version-check --quiet \
		install --constraint constraints.txt hatchling ziglang
	touch $@

setup: $(VENV)/ready

$(VENV)/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(PIP) install --no-compile --constraint constraints.txt --editable '.$(COMPILER:%=[%])'
	touch $@

# pip would compile on one processor
$(VENV)/ready: $(VENV)/installed
	$(PIP) install --no-compile --constraint constraints.txt --editable '.[test,importers$(COMPILER:%=,%)]'
	-$(BIN)/python -m compileall -q -j $(JOBS) $(VENV)/lib
	touch $@

clean:
	rm -rf $(VENV) .venv-bench .venv-bench-pym4e .venv-platforms build dist m4e_fmi/runtime/binaries
