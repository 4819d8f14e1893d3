PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: demo test readers lint types bench pictures failures clean

demo: $(READY)
	$(BIN)/flatnet build projects/pants/project.yaml -o out

test: $(READY)
	$(BIN)/python -m pytest

# Programs that aren't ours, with which tests/export/test_readers.py reads exports back (Debian and npm). Tests skip,
# loudly, what is not there: without the right to install packages, or a network, all else is tested.
READERS := hp2xx inkscape librsvg2-bin poppler-utils python3-cssselect python3-lxml python3-numpy
BRIEFLY := timeout -k 10 300
readers:
	-DEBIAN_FRONTEND=noninteractive $(BRIEFLY) sh -c 'apt-get -qq update && apt-get -qq install -y --no-install-recommends $(READERS)' >/dev/null </dev/null
	-cd tests/export/readers && $(BRIEFLY) npm install --silent --no-audit --no-fund --no-package-lock </dev/null

lint: $(READY)
	$(BIN)/ruff check flatnet tests projects

types: $(READY)
	$(BIN)/mypy

# In about 22 minutes; ARGS="--quick" in three, ARGS="--part scaling --large" one part with the largest mesh.
bench: $(READY)
	$(BIN)/python -m pip install --quiet --editable ".[dev,bench]"
	$(BIN)/python -m tests.benchmark $(ARGS)

# Builds every project and draws docs/pictures; ARGS="boat bag" those alone.
pictures: $(READY)
	$(BIN)/python -m tests.pictures $(ARGS)

# The table and the pictures of docs/failures.md, in about three minutes.
failures: $(READY)
	$(BIN)/python tests/failure_table.py $(ARGS)

# The environment is made once and again whenever pyproject.toml changes.
$(READY): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	touch $(READY)

clean:
	rm -rf $(VENV) out
