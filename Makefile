# The front door. Each target installs what it needs, builds, and runs; `make help` says what there is.

PREFIX ?= /usr/local
FUZZ_SECONDS ?= 60
LOG ?=
JOBS ?= $(shell nproc)
FURROW_DATA ?= ../shared/data

export FUZZ_SECONDS
MAKEFLAGS += --no-print-directory

configure = cmake --preset $(1) -DFURROW_DATA="$(abspath $(FURROW_DATA))"
build = $(call configure,$(1)) && cmake --build --preset $(1) -j $(JOBS)
run_tests = ctest --preset $(1) -j $(JOBS)

.PHONY: help demo test check fuzz bench papers coverage format install clean

help:
	@echo 'make demo     a simulated survey flight, solved and judged; make demo LOG=file.sbf shows a log of yours'
	@echo 'make test     build and test'
	@echo 'make check    sanitizers, fault injection, fuzzing, long campaigns, lint'
	@echo 'make fuzz     libFuzzer on every harness, FUZZ_SECONDS=60 each'
	@echo 'make bench    speed, side by side with RTKLIB convbin and pysbf2'
	@echo 'make papers   the tests of the papers: tables paper | furrow in build/papers (10 minutes)'
	@echo 'make coverage lines and branches that the tests reach'
	@echo 'make format   lay out the sources with clang-format'
	@echo 'make install  programs and manual pages, PREFIX=/usr/local'
	@echo 'make clean    remove build/ and demo/'

demo:
	@scripts/packages.sh build
	@$(call build,release)
	@scripts/demo.sh $(if $(LOG),"$(LOG)")

test:
	@scripts/packages.sh build test
	@scripts/venv.sh
	@$(call build,release)
	@$(call run_tests,release)

check:
	@scripts/packages.sh build test check
	@scripts/venv.sh
	@$(call build,release)
	@$(call run_tests,campaign)
	@$(call build,asan)
	@$(call run_tests,asan)
	@$(MAKE) fuzz FUZZ_SECONDS=5

fuzz:
	@scripts/packages.sh build check
	@$(call build,fuzz)
	@$(call run_tests,fuzz)

format:
	clang-format -i $$(find lib formats cli tests -name '*.[ch]')

bench:
	@scripts/packages.sh build test bench
	@scripts/venv.sh
	@$(call build,release)
	@scripts/bench.sh

papers:
	@scripts/packages.sh build test
	@scripts/venv.sh
	@$(call build,release)
	@scripts/papers.sh

coverage:
	@scripts/packages.sh build test check
	@$(call build,coverage)
	@$(call run_tests,coverage)
	@scripts/coverage.sh

install:
	@scripts/packages.sh build
	@$(call build,release)
	@cmake --install build/release --prefix "$(PREFIX)"

clean:
	rm -rf build demo
