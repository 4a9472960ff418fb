# Set up, test and show mctrack_ros. Everything is installed into .venv; nothing else is touched.

PYTHON ?= $(shell for p in python3.12 python3.11 python3; do \
	$$p -c 'import sys, venv, ensurepip; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 12))' 2>/dev/null \
	&& command -v $$p && break; done)
VENV := .venv
BIN := $(VENV)/bin
SOURCES := setup.py setup.cfg package.xml pyproject.toml \
	$(shell find mctrack_ros experiments config launch resource -type f -not -name '*.pyc')
QUICK := $(addprefix test/,codec evaluation fusion interfaces site tracking test_config.py)
LOCK := $(BIN)/uv pip compile --universal --python-version 3.11 --generate-hashes --upgrade \
	--no-header --no-emit-index-url --no-emit-find-links -q
COLCON := COLCON_LOG_PATH=build/colcon/log PYTHONPATH=$(CURDIR)/.colcon $(BIN)/python -m colcon
IN_BUILD := --build-base build/colcon/build --install-base build/colcon/install --base-paths .
LEFT_OUT := pytest pytest-cov pytest-repeat pytest-rerunfailures coverage setuptools packaging pyparsing \
	python-dateutil iniconfig pluggy pygments docutils tzdata
RESULTS := lab6p cmc wildtrack pets defaults terrace street cameras

.PHONY: all demo test check unit quick jazzy readers colcon audit same lock results reference clean help

all: $(VENV)/.package ## install into .venv

demo: all ## track a five-camera pitch live; results in out/demo
	$(BIN)/mctrack demo

test: check unit ## everything that CI runs

check: all ## style, types
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

unit: all ## the tests; those that follow nodes at their pace alone, so that nothing holds them up
	ROS_PYTHON_CHECK_FIELDS=1 $(BIN)/python -m pytest -n 2 --dist loadgroup -m 'not live'
	ROS_PYTHON_CHECK_FIELDS=1 env -u MCTRACK_REQUIRE_DATA $(BIN)/python -m pytest -m live

quick: all ## the tests of arithmetic and files, in a minute: no node, no page, no real data
	$(BIN)/python -m pytest -q -n 2 -m 'not live and not browser and not real_data' $(QUICK)

jazzy: ## the tests on the versions of Ubuntu 24.04, which ROS 2 Jazzy is built on
	$(MAKE) VENV=.venv-jazzy .venv-jazzy/.requirements
	.venv-jazzy/bin/pip install -q --disable-pip-version-check --no-deps -r test/jazzy.txt
	$(MAKE) VENV=.venv-jazzy unit

readers: .venv-readers/.requirements ## other people's readers, which the tests let read exported tracks

colcon: all .colcon/.requirements ## colcon build and test, the latter the quick ones, and the nodes that ros2 run finds
	$(COLCON) list --base-paths . | grep -q 'mctrack_ros.*(ros.ament_python)'
	$(COLCON) build $(IN_BUILD) --packages-select mctrack_ros
	. build/colcon/install/setup.sh && $$(ls -d $$AMENT_PREFIX_PATH/lib/mctrack_ros)/fusion_node --help >/dev/null
	env -u MCTRACK_REQUIRE_DATA $(COLCON) test $(IN_BUILD) --packages-select mctrack_ros --pytest-args $(QUICK)
	$(COLCON) test-result --test-result-base build/colcon/build --verbose

audit: ## known vulnerabilities of the locked packages, from an advisory database in the network
	$(PYTHON) -m venv .venv-audit
	.venv-audit/bin/pip install -q --disable-pip-version-check 'pip-audit>=2.9,<3'
	.venv-audit/bin/pip-audit --strict --require-hashes --disable-pip --timeout 5 \
		--progress-spinner off -r requirements.lock

results: all ## measure the real-data figures again; writes docs/results
	for name in $(RESULTS); do \
		$(BIN)/mctrack reproduce $$name --json docs/results/$$name.json || exit 1; done
	$(BIN)/mctrack reproduce terrace4 --repeat 5 --json docs/results/terrace4.json
	$(BIN)/mctrack reproduce terrace --live --json docs/results/terrace_live.json
	$(BIN)/mctrack results

same: all ## compare the bytes that the golden recordings give with those of the version before
	$(BIN)/python -m mctrack_experiments.same

reference: all ## write the parameter files and the references of parameters and commands again
	$(BIN)/python -m mctrack_ros.ros.default_files config
	$(BIN)/python -m mctrack_ros.ros.parameter_table docs/reference/parameters.md
	$(BIN)/python -m typer mctrack_ros.cli.main utils docs --name mctrack \
		--output docs/reference/command_line.md

lock: all ## resolve requirements.in, test/readers.in and test/colcon.in again
	$(BIN)/pip install -q uv
	$(LOCK) requirements.in -o requirements.lock
	$(LOCK) test/readers.in -o test/readers.txt
	$(LOCK) $(addprefix --no-emit-package ,$(LEFT_OUT)) test/colcon.in -o test/colcon.txt

clean: ## remove what make made
	rm -rf $(VENV) .venv-readers .venv-audit .colcon build out *.egg-info experiments/build experiments/*.egg-info

help: ## this list
	@grep -E '^[a-z]+:.*##' Makefile | sed 's/:.*## /\t/'

$(VENV)/.requirements: requirements.lock
	@test -n "$(PYTHON)" || { echo 'Python 3.12 or 3.11 with venv is needed: install python3.12 and python3.12-venv, or set PYTHON=...'; exit 1; }
	@echo "installing into $(VENV) with $(PYTHON): about two minutes"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install -q --disable-pip-version-check --require-hashes -r requirements.lock
	touch $@

.venv-readers/.requirements: test/readers.txt
	@echo "installing other people's readers into .venv-readers: about half a minute"
	$(PYTHON) -m venv .venv-readers
	.venv-readers/bin/pip install -q --disable-pip-version-check --require-hashes -r test/readers.txt
	touch $@

.colcon/.requirements: test/colcon.txt $(VENV)/.requirements
	@echo "installing colcon into .colcon"
	rm -rf .colcon
	$(BIN)/pip install -q --disable-pip-version-check --no-deps --require-hashes --target .colcon \
		-r test/colcon.txt
	touch $@

$(VENV)/.package: $(VENV)/.requirements $(SOURCES)
	rm -rf build experiments/build
	$(BIN)/pip install -q --disable-pip-version-check --no-deps --no-build-isolation --force-reinstall . ./experiments
	@echo "compiling the inner loops, once: half a minute on two cores"
	cd / && $(abspath $(BIN))/python -c 'from mctrack_ros.cli.live import prepare_nodes; prepare_nodes()'
	touch $@
