# Builds, tests and renders with one word each; CMakeLists.txt does the work.

# Debian's and Ubuntu's names.
packages := g++ cmake ninja-build pkg-config libboost-math-dev libcli11-dev libfmt-dev \
  libhwy-dev libimath-dev nlohmann-json3-dev libopenexr-dev libopenimageio-dev libpugixml-dev libtbb-dev \
  libtomlplusplus-dev libgtest-dev

# Programs that render the same scenes, and draw plots.
programs := povray blender python3 openimageio-tools gnuplot-nox

# For the test of the report's page in a browser, which is skipped where they can't be had.
browser := chromium chromium-driver python3-selenium

# For `make lessons`: the renderer's core as WebAssembly, and what makes pages.
web := clang-19 lld-19 libc++-19-dev-wasm32 libc++abi-19-dev-wasm32 libclang-rt-19-dev-wasm32 wasi-libc esbuild \
  python3-markdown
python = $(firstword $(wildcard /usr/bin/python3) python3)

# For `make lint`. Other versions find other things; Debian 12 and 13 both have this one of LLVM.
# They have no ruff, which comes from PyPI.
llvm := 19
ruff := 0.17.6
linters := clang-format-$(llvm) clang-tidy-$(llvm) python3-venv

# For `make fuzz`.
fuzzers := clang-$(llvm) libclang-rt-$(llvm)-dev
fuzzed := picture comparison gate card scene mesh

quick_tests := $(addsuffix _test,image film scene_reader scene_file compare assessment)

# Files whose first line, or the one after "#!", names the licence.
licensed := '*.cpp' '*.h' '*.h.in' '*.inc' '*.py' '*.sh' '*.js' '*.css' '*.cmake' '*CMakeLists.txt'

scenes := cornell seed

generator = $(if $(shell command -v ninja),Ninja,Unix Makefiles)
jobs = $(shell nproc 2>/dev/null || getconf _NPROCESSORS_ONLN)

.PHONY: help deps configure build test lint sanitize fuzz gate report bench references \
  check-references stress stress-truth lamp-sampling power lesson-pictures lessons charts pictures \
  clean

help:
	@echo "make deps    installs the libraries that are missing (Debian, Ubuntu)"
	@echo "make build   build/plumb"
	@echo "make test    builds and runs all tests"
	@echo "make lint    checks C++ by clang-format and clang-tidy of LLVM $(llvm), Python by ruff (6 minutes)"
	@echo "make sanitize  runs the quick tests with address and undefined behaviour sanitizers"
	@echo "make fuzz    feeds broken files to every reader, SECONDS=60 for each kind"
	@echo "make differential  holds methods, precisions and Mitsuba, if it is installed, against each"
	@echo "                   other in random scenes (SCENES=1000: half an hour; with Mitsuba hours)"
	@echo "make gate    holds pictures rendered now against the stored ones of other programs"
	@echo "make report  renders the scenes with all programs and writes out/report.html (8 minutes)"
	@echo "make bench   measures the renderer's speed and noise"
	@echo "make references        renders the stored ground truth with all programs (40 minutes)"
	@echo "make check-references  compares what the installed programs draw today with it"
	@echo "make stress        makes the tables of docs/stability.md (14 minutes)"
	@echo "make stress-truth  has Mitsuba render the caustics that they are held against (5 minutes)"
	@echo "make lamp-sampling  makes the tables of docs/lamp-sampling.md"
	@echo "make power          makes the table of docs/power.md (6 minutes)"
	@echo "make lessons        makes pages of docs/lessons/ with live pictures: out/lessons/index.html"
	@echo "make lesson-pictures  renders the pictures, plots and tables of docs/lessons/ (10 minutes)"
	@echo "make charts         puts the report's plots into docs/pictures/"
	@echo "make pictures       renders the pictures of README.md into docs/pictures/"
	@echo "make clean   removes build/, build-debug/, build-fuzz/, build-web/ and out/"

deps:
	@if ! command -v apt-get >/dev/null; then \
	  echo "No apt-get here. Needed: a C++20 compiler, CMake 3.25, pkg-config and the libraries"; \
	  echo "OpenImageIO 2.4, OpenEXR 3.1, Imath 3.1, Highway, oneTBB, Boost.Math, fmt, pugixml, toml++,"; \
	  echo "nlohmann/json, CLI11 and GoogleTest. POV-Ray, Blender and OpenImageIO's tools render and"; \
	  echo "show the references; gnuplot draws plots."; \
	  exit 0; \
	fi; \
	is_missing() { \
	  ! dpkg-query -W -f '$${db:Status-Status}\n' $$1 2>/dev/null | grep -qx installed; \
	}; \
	install() { \
	  echo "Installing $$*"; \
	  test "$$(id -u)" = 0 && root= || root=sudo; \
	  $$root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $$*; \
	}; \
	missing=; \
	for package in $(packages) $(programs); do is_missing $$package && missing="$$missing $$package"; done; \
	if test -n "$$missing"; then \
	  echo "To be installed:$$missing"; \
	  echo "(on a bare machine 2 minutes, 600 MB to download and 2.4 GB of disk)"; \
	  test "$$(id -u)" = 0 && root= || root=sudo; \
	  $$root apt-get update -q && install $$missing || exit; \
	fi; \
	for package in $(browser); do \
	  if is_missing $$package && apt-cache show $$package >/dev/null 2>&1; then install $$package || exit; fi; \
	done

configure: deps
	cmake -S . -B build $(if $(wildcard build/CMakeCache.txt),,-G "$(generator)")

build: configure
	cmake --build build --parallel $(jobs)

test: build
	ctest --test-dir build --output-on-failure -j$(jobs)

lint: programs += $(linters)
lint: configure build/ruff-$(ruff)/bin/ruff
	@echo "Licence lines"; ! git ls-files $(licensed) | while read -r file; do \
	  sed '/^#!/d;q' $$file | grep -q 'SPDX-License-Identifier: Apache-2.0' || \
	    echo "$$file: the first line names no licence"; \
	done | grep .
	git ls-files '*.cpp' '*.h' | xargs clang-format-$(llvm) --dry-run -Werror
	build/ruff-$(ruff)/bin/ruff check
	run-clang-tidy-$(llvm) -p build -quiet -j $(jobs)

build/ruff-$(ruff)/bin/ruff: | configure
	python3 -m venv build/ruff-$(ruff)
	build/ruff-$(ruff)/bin/pip install --quiet --disable-pip-version-check ruff==$(ruff)

# The other tests take too long with sanitizers.
sanitize: deps
	cmake --preset debug $(if $(wildcard build-debug/CMakeCache.txt),,-G "$(generator)")
	cmake --build --preset debug --parallel $(jobs) --target $(quick_tests)
	for test in $(quick_tests); do build-debug/$$test --gtest_brief || exit; done

# Readers open files by their names; /dev/shm keeps these in memory.
fuzz: programs += $(fuzzers)
fuzz: deps
	cmake --preset fuzz -DCMAKE_CXX_COMPILER=clang++-$(llvm) \
	  $(if $(wildcard build-fuzz/CMakeCache.txt),,-G "$(generator)")
	cmake --build --preset fuzz --parallel $(jobs)
	tests/fuzz/seeds.sh build-fuzz/corpus
	for kind in $(fuzzed); do \
	  TMPDIR=/dev/shm build-fuzz/tests/fuzz/$${kind}_fuzz -max_total_time=$(or $(SECONDS),60) -timeout=20 \
	    -artifact_prefix=build-fuzz/ build-fuzz/corpus/$$kind || exit; \
	done

differential: build
	PLUMB_DIFFERENTIAL_SCENES=$(or $(SCENES),1000) PLUMB_DIFFERENTIAL_MITSUBA=$(if \
	  $(shell python3 -c 'import mitsuba' 2>&1),,1) build/differential_test

gate: build
	@mkdir -p out/gate
	build/plumb render reference_scenes/cornell/scene.xml --spp 1024 -o out/gate/cornell.exr
	build/plumb render reference_scenes/seed/scene.xml --spp 1024 -o out/gate/seed.exr
	build/plumb render reference_scenes/cornell/scene.xml --spp 1024 --bounces 0:5 \
	  -o out/gate/cornell_five_bounces.exr
	build/plumb compare --gate tests/gate.toml --junit out/gate/results.xml

# Without the tests the page is there minutes earlier.
report: configure
	cmake --build build --parallel $(jobs) --target plumb
	python3 report/make_report.py build/plumb

bench: build
	build/render_bench

references: build
	python3 other_renderers/references.py make build/plumb

check-references: build
	python3 other_renderers/references.py check build/plumb

stress: build
	python3 bench/stress_table.py build/plumb

stress-truth: build
	for scene in caustic caustic_in_mirror; do \
	  build/plumb reference reference_scenes/stress/$$scene.xml --with mitsuba --spp 4096 --seeds 32 \
	    -o reference_scenes/stress/$$scene.exr || exit; \
	done

lamp-sampling: build
	build/lamp_sampling

power: build
	@mkdir -p out
	build/plumb power > out/power.md
	sed -i -e '/<!-- table: made by/,/<!-- end of table/{//!d}' -e '/<!-- table: made by/r out/power.md' \
	  docs/power.md

lessons: programs += $(web)
lessons: deps
	cmake -S web -B build-web $(if $(wildcard build-web/CMakeCache.txt),,-G "$(generator)") \
	  -DCMAKE_TOOLCHAIN_FILE=$(CURDIR)/web/wasi.cmake
	cmake --build build-web --parallel $(jobs)
	$(python) web/make_lessons.py build-web/plumbline.wasm out/lessons

lesson-pictures: build
	python3 bench/lesson_pictures.py build/plumb

charts: report
	for scene in $(scenes); do \
	  cp out/report/$$scene/chart.svg docs/pictures/$${scene}_speed.svg && \
	  cp out/report/$$scene/converge.svg docs/pictures/$${scene}_convergence.svg || exit; \
	done

pictures: build
	@mkdir -p docs/pictures
	for scene in $(scenes); do \
	  build/plumb render reference_scenes/$$scene/scene.xml --size 512x512 --spp 4096 \
	    -o docs/pictures/$$scene.png --exposure 0.5 || exit; \
	done

clean:
	rm -rf build build-debug build-fuzz build-web out
