# Two commands do everything on a fresh machine with Python 3.11, make and git:  make demo,  make test.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
EXTRAS := dev,docs,vision,text,devices,lsl,daq,dwf,formats,statistics,ray,export,hub
PACKAGES := simulate playback capture study studio benchmark

# torch's spinning threads collapse when a core is busy; passive waiting costs nothing.
export OMP_WAIT_POLICY ?= PASSIVE
# The tests start a hundred processes, which would compile every module anew.
unexport PYTHONDONTWRITEBYTECODE
# Freed memory is kept for the next large array, which the system would have to fill with zeros again.
test: export MALLOC_MMAP_THRESHOLD_ := 268435456
test: export MALLOC_TRIM_THRESHOLD_ := 268435456

.PHONY: help demo test install check mutants fuzz audit wheel bench benchmark-page docs clean
.DEFAULT_GOAL := help

help: ## show this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /\1\t/' | expand -t 16

install: $(STAMP) ## make .venv with everything that installs without hardware

# uv installs ten times faster than pip, but does not read pip's find-links by itself.
$(STAMP): pyproject.toml $(wildcard packages/*/pyproject.toml) constraints.txt tests/s3-server.txt
	$(PYTHON) -c 'import sys; v = sys.version_info; sys.exit(v < (3, 11) and f"tactogram needs Python 3.11 or later, got {v.major}.{v.minor}: make PYTHON=/path/to/python3.11")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt uv
	UV_FIND_LINKS="$${UV_FIND_LINKS:-$${PIP_FIND_LINKS:-}}" $(BIN)/uv pip install --quiet --compile-bytecode --python $(BIN)/python \
	    -c constraints.txt -e '.[$(EXTRAS)]' $(foreach name,$(PACKAGES),-e packages/tactogram-$(name))
	$(BIN)/uv venv --quiet --clear --python $(BIN)/python $(VENV)/s3
	UV_FIND_LINKS="$${UV_FIND_LINKS:-$${PIP_FIND_LINKS:-}}" $(BIN)/uv pip install --quiet --python $(VENV)/s3/bin/python -r tests/s3-server.txt
	touch $(STAMP)

demo: install ## simulate, classify, search and generate surfaces; writes runs/demo/report.html
	$(BIN)/tactogram demo

# Three processes for two cores, but two where each has a browser or a cluster, whose own processes are several.
test: install ## run the tests (SLOW=yes: also in a browser and on a cluster; COVERAGE=yes: measure it, it must not fall)
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n $(if $(SLOW),2,3) --dist loadfile --no-loadscope-reorder $(if $(SLOW),,-m "not slow") $(if $(COVERAGE),--cov --cov-report=html:build/coverage)

check: install ## style, types, layers, documentation
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(MAKE) docs

mutants: install ## check that the tests notice known defects of adversarial training, and seeded ones anywhere (nightly)
	$(BIN)/python tests/mutation/run.py
	$(BIN)/python tests/mutation/drawn.py --seed $$(date +%j)

fuzz: install ## damaged files, made-up requests, processes killed as they write: ten minutes each, others each day (nightly)
	for part in readers routes kills; do $(BIN)/python -m tests.fuzz.$$part --minutes 10 --seed $$(date +%j) || exit 1; done

# Without its database pip-audit says "No known vulnerabilities found", too. So it is first asked for one that it knows.
audit: install ## look for known vulnerabilities of the pinned packages (skipped, and said, where their database is out of reach)
	mkdir -p build && echo requests==2.19.0 > build/vulnerable.txt
	if $(AUDIT) -r build/vulnerable.txt 2>&1 | grep -q -e CVE-2018-18074 -e PYSEC-2018-28; then $(AUDIT) --strict -r constraints.txt; \
	else echo "audit skipped: no database of vulnerabilities can be reached from here"; fi
AUDIT = UV_FIND_LINKS="$${UV_FIND_LINKS:-$${PIP_FIND_LINKS:-}}" $(BIN)/uv tool run --quiet pip-audit==2.10.1 --no-deps --disable-pip

# The wheels are built from the sdists, which thereby prove to be complete. First the core alone, then all together; never
# wheels of the same version that uv has kept from before.
wheel: install ## build sdists and wheels, and test the wheels in a clean environment of their own
	rm -rf build/wheel && mkdir -p build/wheel
	for folder in . $(PACKAGES:%=packages/tactogram-%); do $(BIN)/python -m build --outdir build/wheel $$folder >/dev/null || exit 1; done
	$(PYTHON) -m venv build/wheel/env
	$(WHEELS) build/wheel/tactogram-*.whl pytest hypothesis
	cd build/wheel && env/bin/tactogram models && env/bin/python -m pytest -q -p no:cacheprovider --import-mode=importlib \
	    --pyargs tactogram.models
	$(WHEELS) 'tactogram[studio,benchmark]'
	cd build/wheel && env/bin/tactogram study list && env/bin/tactogram sources && env/bin/tactogram stream --help >/dev/null && env/bin/tactogram benchmark list && env/bin/tactogram studio --help >/dev/null
WHEELS = UV_FIND_LINKS="$${UV_FIND_LINKS:-$${PIP_FIND_LINKS:-}}" $(BIN)/uv pip install --quiet --python build/wheel/env/bin/python \
    -c constraints.txt --find-links build/wheel --no-sources --refresh-package tactogram $(PACKAGES:%=--refresh-package tactogram-%)

bench: install ## compare the speed with other libraries, and write benchmarks/results.md
	$(BIN)/python -m benchmarks

benchmark-page: install ## rank the results in benchmarks/tasks: docs/benchmark-results.md, docs/benchmark.html, and what `score` ranks among
	$(BIN)/tactogram benchmark table benchmarks/tasks --out docs/benchmark-results.md
	$(BIN)/tactogram benchmark table benchmarks/tasks --out docs/benchmark.html
	$(BIN)/tactogram benchmark table benchmarks/tasks --out packages/tactogram-benchmark/src/tactogram_benchmark/results.json

# -E reads every page again: pages that are not read again do not repeat their warnings. Examples run when they change.
docs: install ## build the documentation into docs/_build/html
	$(BIN)/python -m sphinx -E -W --keep-going -q -b html docs docs/_build/html

clean: ## remove the environment and caches
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache
