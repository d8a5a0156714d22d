# The developer's front door; CMake does the work. `make help` lists what there is.
PREFIX ?= /usr/local
FUZZ_SECONDS ?= 60
SOURCES = $(shell find include src program lab examples tests fuzz \
            \( -name '*.[ch]' -o -name '*.cpp' \) 2> /dev/null)

.PHONY: release lab help setup test check check-long coverage fuzz bench install install-lab format clean

release: ## build/release/program/stipple and build/release/lab/stipple-lab (the default)
	@test -f build/release/build.ninja || cmake --preset release
	@cmake --build --preset release --target programs

lab: ## build/release/lab/stipple-lab alone: measuring, the papers, named scenes
	@test -f build/release/build.ninja || cmake --preset release
	@cmake --build --preset release --target stipple_lab_pages

help: ## this list
	@sed -n 's/^\([a-z-]*\):[^#]*## /  make \1#/p' $(MAKEFILE_LIST) | awk -F '#' '{ printf "%-20s%s\n", $$1, $$2 }'

setup: ## install the Debian packages that building needs (scripts/setup: those of the tests as well)
	@scripts/setup --programs

test: ## all tests of the debug build
	cmake --workflow --preset dev

check: ## all that must hold before a change lands (scripts/test)
	@scripts/test

check-long: ## every preset, FUZZ_SECONDS=60 of each fuzz target, the same bytes from every compiler
	@FUZZ_SECONDS=$(FUZZ_SECONDS) scripts/check_long

coverage: ## lines and branches of the library that unit tests reach
	@scripts/coverage

fuzz: ## FUZZ_SECONDS=60 of each fuzz target
	@scripts/fuzz $(FUZZ_SECONDS)

bench: release ## all benchmarks
	build/release/lab/stipple-lab bench

install: release ## into PREFIX=/usr/local (and DESTDIR)
	cmake --install build/release --prefix $(PREFIX)

install-lab: lab ## stipple-lab as well
	cmake --install build/release --prefix $(PREFIX) --component lab

format: ## all C files, as clang-format 14 writes them
	clang-format -i $(SOURCES)

clean: ## remove build/
	rm -rf build
