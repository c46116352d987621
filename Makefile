# mjbiped: `make walk` shows what it does, `make test` proves it. Needs Python 3.11 or newer, pip and make.

PYTHON ?= $(or $(shell command -v python3.11),$(shell command -v python3),python3)
VENV := .venv
BIN := $(VENV)/bin
OUT := out

unexport PYTHONDONTWRITEBYTECODE # the tests begin some hundred processes, each of which would compile its imports anew

.DEFAULT_GOAL := help
.PHONY: help setup walk reproduce learn test tests test-slow mutants test-viewer test-browser notebooks bench docs check format lock clean

help: ## this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | awk -F':.*## ' '{printf "  make %-12s %s\n", $$1, $$2}'

setup: $(VENV)/.ready ## install mjbiped and its tools into .venv

# uv installs in a quarter of pip's time; where uv has no wheel, or fails, pip does the work.
UV = uv==0.13.9
PIP = $(BIN)/python -m pip install --quiet --quiet --no-compile --disable-pip-version-check
INSTALL = install() { \
	$(BIN)/uv pip install --quiet --python $(BIN)/python -c constraints.txt "$$@" 2>/dev/null || $(PIP) -c constraints.txt "$$@"; \
}; install

# Where dm_control's labmaze has no wheel (Python 3.13), the rest of it does without.
WITHOUT_LABMAZE = dm-control dm-env dm-tree absl-py glfw lxml pyopengl pyparsing

# Where Python comes without ensurepip (Debian's own), virtualenv makes the environment in venv's place.
$(VENV)/.installed: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "mjbiped needs Python 3.11 or newer; name one with: make PYTHON=/path/to/python3.11"; exit 1; }
	@echo "installing into $(VENV) ..."
	@if $(PYTHON) -c 'import ensurepip, venv' 2>/dev/null; then \
		$(PYTHON) -m venv --clear $(VENV); \
	else \
		$(PYTHON) -m pip install --quiet --quiet --disable-pip-version-check --target $(VENV)-tool virtualenv && \
		PYTHONPATH=$(VENV)-tool $(PYTHON) -m virtualenv --quiet --clear $(VENV) && rm -rf $(VENV)-tool; \
	fi
	@$(PIP) $(UV) 2>/dev/null || true
	@$(INSTALL) -e '.[report]'
	@touch $@

$(VENV)/.ready: $(VENV)/.installed
	@echo "installing the tools ..."
	@$(INSTALL) -e '.[test]'
	@if ! $(BIN)/python -c 'import dm_control' 2>/dev/null; then $(INSTALL) --no-deps $(WITHOUT_LABMAZE); fi
	@touch $@

walk: $(VENV)/.installed ## walk over mixed slopes and steps: record, figure and a video of its first 20 s in out/
	@mkdir -p $(OUT)
	$(BIN)/mjbiped walk mixed --initial rest --steps 60 --out $(OUT)/walk.npz --plot $(OUT)/walk.png --video $(OUT)/walk.mp4 --stop 20

reproduce: setup ## section V of the paper again, into docs/: five to fifteen minutes, goes on where it was stopped
	$(BIN)/mjbiped reproduce --report docs
	$(BIN)/python -m scripts.pages docs/reproduction.md docs/tables/reproduction.md

SEEDS = 1 2 3 4 5

learn: setup ## train five policies of each kind and lay them beside the adaptive controller, into out/learning: half an hour
	for seed in $(SEEDS); do \
		$(BIN)/python -m scripts.learning.train --task residual --seed $$seed --generations 20 && \
		$(BIN)/python -m scripts.learning.train --task free --seed $$seed --generations 50 || exit; \
	done
	$(BIN)/python -m scripts.learning.evaluate --policies $(OUT)/learning

# A file's tests share what they prepare. Those that make machine code come first, and others find it made.
BY_TWO = -n 2 --dist loadfile --no-loadscope-reorder

test: setup ## set-up, lint, types and tests
	@$(MAKE) --no-print-directory --jobs 2 check tests # types take one core for half a minute

tests: setup
	$(BIN)/python -m pytest $(BY_TWO)

test-slow: setup ## the long checks
	$(BIN)/python -m pytest $(BY_TWO) -m slow

mutants: setup ## small faults put into the engines and laws: which ones the tests notice
	$(BIN)/python -m scripts.mutants

test-viewer: setup ## the viewer's window on a screen in memory; installs that on Debian
	@for tool in Xvfb xdotool import; do command -v $$tool >/dev/null || missing=1; done; \
		test -z "$$missing" || { apt-get update -q && apt-get install -qy xvfb xdotool imagemagick; }
	$(BIN)/python -m pytest -m viewer tests/viewing

test-browser: setup ## reports in headless Chromium, which is installed (apt-get) where it is missing
	@command -v chromium >/dev/null || command -v chromium-browser >/dev/null || command -v google-chrome >/dev/null || \
		{ apt-get update -qq && apt-get install -y -qq chromium; } || \
		{ echo "Chromium is missing and cannot be installed from here: install it, then run make test-browser again"; exit 1; }
	@$(INSTALL) -e '.[browser]'
	$(BIN)/python -m pytest -m browser tests/reports

notebooks: setup ## execute docs/notebooks/ again, in place
	@$(INSTALL) -e '.[notebooks]'
	$(BIN)/jupyter nbconvert --to notebook --execute --inplace --ExecutePreprocessor.store_widget_state=False docs/notebooks/*.ipynb

bench: setup ## measure the speed, some seventeen minutes: docs/tables/performance/
	@$(INSTALL) imageio # without which Gymnasium's own walker does not begin; Drake and JAX are compared where they are: .[bench]
	$(BIN)/python -m scripts.benchmarks

docs: setup ## the site: site/index.html
	@$(INSTALL) -e '.[docs]'
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet --doctree-dir site/.doctrees docs site
	@echo "open site/index.html"

check: setup ## lint, imports and types
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/lint-imports --no-logo
	$(BIN)/mypy

format: setup ## write the code in its one format
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

lock: ## take the newest allowed versions into constraints.txt
	rm -rf $(VENV)-lock && $(PYTHON) -m venv $(VENV)-lock
	$(VENV)-lock/bin/pip install --quiet --disable-pip-version-check '.[test,cluster,browser,notebooks,docs,sb3]' hatchling
	$(VENV)-lock/bin/pip freeze --exclude mjbiped > constraints.txt
	rm -rf $(VENV)-lock

clean: ## remove everything that was made here
	rm -rf $(VENV) $(VENV)-tool $(VENV)-lock $(OUT) jupyter_execute reproduction site docs/_generated dist build .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis MUJOCO_LOG.TXT
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
