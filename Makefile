# Shortcuts for the CMake build. `make help` lists the targets.
BUILD ?= build
CHECK ?= build-check
JOBS ?= $(shell nproc 2>/dev/null || echo 2)
SETS ?= machine
PARTS ?=
TESTS ?= .
WEB ?= build-web
PREFIX ?= /usr/local
ifneq ($(shell command -v ninja 2>/dev/null),)
export CMAKE_GENERATOR ?= Ninja
endif

.PHONY: all build web npm demo check coverage portability bench bench-paper bench-rd bench-render tables train fuzz failures races memory uninitialised install wheel reference format clean help dependencies

all: build

help:
	@echo 'make           build $(BUILD)/cvol, libcvol.a and libcvol.so, for processors like this one;'
	@echo '               make SETS=all for all processors'
	@echo 'make demo      install what is missing, build, compress the sample scan, render it'
	@echo 'make web       build the page of cvol export by emscripten; writes $(WEB)'
	@echo 'make npm       the same, and the package of npm; writes $(WEB)/cvol-VERSION.tgz'
	@echo 'make check     install what is missing, check the sources with clang-format and'
	@echo '               clang-tidy, build with warnings as errors and with sanitizers, run the tests: of'
	@echo '               the long and the sanitized ones a part, PARTS=1 for all'
	@echo 'make coverage  run all tests with counters of gcov; prints which lines and branches they reach'
	@echo 'make portability  build and test for other compilers, processors and Windows, emulated; writes'
	@echo '               build-portability; an hour'
	@echo 'make bench     run the benchmarks; writes bench/results'
	@echo 'make bench-paper  compare the paper'"'"'s engine with splatting; writes bench/results/paper'
	@echo 'make bench-render  compare rendering with VTK: time and quality; an hour;'
	@echo '               writes bench/results/render'
	@echo 'make bench-rd  rate and distortion, compared with zfp; writes bench/results/rd'
	@echo 'make tables    write the codec'"'"'s computed tables, and check the trained ones'
	@echo 'make train     train the other tables, into $(BUILD)/tables; hours'
	@echo 'make fuzz      fuzz every reader for a minute (needs clang; make check: a few of them, 8 s)'
	@echo 'make failures  let every allocation and every call for a file fail once, for all commands; a night'
	@echo 'make races     look for races of threads, by the sanitizer of clang; 40 minutes'
	@echo 'make memory    run all commands under valgrind; half an hour'
	@echo 'make uninitialised  look for uses of memory that was never written, by the sanitizer of clang'
	@echo 'make reference  write the reference of the C library as HTML (needs doxygen)'
	@echo 'make install   install under PREFIX (default /usr/local)'
	@echo 'make wheel     make the wheel of the Python package, for all Linux on x86-64 with a glibc as new'
	@echo '               as its name says; writes $(BUILD)/wheel'
	@echo 'make format    format the C sources'
	@echo 'make clean     remove the build folders'

dependencies:
	@scripts/dependencies.sh build test

build:
	@cmake -S . -B $(BUILD) -DCVOL_TESTS=OFF -DCVOL_SETS=$(SETS) $(CONFIGURE) >$(BUILD).log 2>&1 || { \
	  cat $(BUILD).log; \
	  echo 'cvol: cmake could not configure; scripts/dependencies.sh lists the requirements'; exit 1; }
	@mkdir -p $(BUILD) && mv -f $(BUILD).log $(BUILD)/configure.log
	@sed -n 's/^   \([^ ]*\) *off *\(.*\)/cvol: without \1 this build \2/p' $(BUILD)/configure.log
	@cmake --build $(BUILD) -j $(JOBS)

web:
	@scripts/dependencies.sh web
	@scripts/web.sh $(WEB) $(JOBS)

npm: web
	@cd $(WEB) && npm pack --silent ./npm | sed 's|^|The package: $(WEB)/|'

demo:
	@scripts/dependencies.sh build
	@$(MAKE) --no-print-directory build
	@scripts/demo.sh $(BUILD)/cvol

check: dependencies
	@scripts/check.sh $(CHECK) $(JOBS) $(PARTS)

coverage: dependencies
	@scripts/coverage.sh $(BUILD)-coverage $(JOBS) '$(TESTS)'

portability:
	@scripts/dependencies.sh portability
	@scripts/portability.sh $(BUILD)-portability $(JOBS) $(PLATFORMS)

bench:
	@scripts/dependencies.sh build bench
	@$(MAKE) --no-print-directory build CONFIGURE=-DCVOL_BENCH=ON
	@cmake -S . -B $(BUILD)-fftw -DCVOL_FFT=fftw -DCVOL_BENCH=ON -DCVOL_TESTS=OFF >$(BUILD)/configure-fftw.log
	@cmake --build $(BUILD)-fftw -j $(JOBS) --target algebra_whole
	@bench/run.sh $(BUILD)/cvol

tables:
	@scripts/tables.py

train:
	@scripts/dependencies.sh build bench
	@$(MAKE) --no-print-directory build CONFIGURE=-DCVOL_BENCH=ON
	@bench/tokens/train.sh $(BUILD) $(BUILD)/tables

bench-paper:
	@scripts/dependencies.sh build bench
	@$(MAKE) --no-print-directory build CONFIGURE=-DCVOL_BENCH=ON
	@bench/paper.py $(BUILD)/cvol
	@bench/paper_data.py $(BUILD)/cvol

bench-render:
	@scripts/dependencies.sh build bench
	@$(MAKE) --no-print-directory build CONFIGURE=-DCVOL_BENCH=ON
	@bench/render.sh $(BUILD)/cvol

bench-rd:
	@scripts/dependencies.sh build bench
	@$(MAKE) --no-print-directory build CONFIGURE=-DCVOL_BENCH=ON
	@bench/rd.py $(BUILD)/cvol

fuzz:
	@fuzz/run.sh

failures: dependencies
	@cmake -S . -B $(CHECK) -DCVOL_TESTS=ON >/dev/null
	@cmake --build $(CHECK) -j $(JOBS) --target cvol_command faults
	@scripts/failures.sh $(abspath $(CHECK)) $(JOBS)

races: dependencies
	@scripts/races.sh $(BUILD)-races $(JOBS)

memory:
	@scripts/dependencies.sh build memory
	@scripts/memory.sh $(BUILD)-memory $(JOBS)

uninitialised: dependencies build
	@scripts/uninitialised.sh $(BUILD)-uninitialised $(JOBS) --made-by $(BUILD)/cvol

install: build
	@cmake --install $(BUILD) --prefix $(PREFIX)

wheel:
	@scripts/dependencies.sh build wheel
	@$(MAKE) --no-print-directory build SETS=all
	@python3 python/wheel/bundle.py $(BUILD) $(BUILD)/wheel

reference:
	@mkdir -p $(BUILD)/reference
	@(cat doc/reference/Doxyfile; echo 'OUTPUT_DIRECTORY = $(BUILD)/reference') | doxygen -
	@echo "The reference: $(BUILD)/reference/html/index.html"

format:
	@git ls-files '*.c' '*.h' | xargs clang-format -i

clean:
	@rm -rf $(BUILD) $(WEB) $(BUILD)-coverage $(BUILD)-fftw $(BUILD)-memory $(BUILD)-portability $(BUILD)-races $(CHECK) $(CHECK)-sanitize build-fuzz demo
