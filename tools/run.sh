#!/usr/bin/env bash
# One command from a clone to a result:
#   tools/run.sh demo                builds the command for this processor, and plays a flag: a picture and, with npm, a page
#   tools/run.sh report [SCENE...]   speed against error: a table here; pictures, report.json and, with npm, report.html in report/
#   tools/run.sh test                every test, and what it covers
#   tools/run.sh build               the whole command: every instruction set, everything that measures, the pages
#   tools/run.sh bench [OPTION...]   the bars in one table, then every benchmark (options of Google Benchmark: those alone)
#   tools/run.sh peers [OPTION...]   hanging cloth beside Bullet, boost::odeint, SUNDIALS and plain loops (--quick, --all, --help)
#   tools/run.sh page                builds the pages that play and report, and tries them in headless Chromium
#   tools/run.sh verify [SCENE...]   every instruction set, layout and thread count against the scalar reference
#   tools/run.sh fuzz [--plain] [SECONDS | --executions N] [TARGET...]   libFuzzer on readers and steps: 60 s a target, or so
#                                    long, or N in all, with sanitizers; --plain: without them, optimised, many times as fast
#   tools/run.sh mutants [NAME...]   small faults in the code, one at a time: each must make a test fail (--check: that all still apply)
#   tools/run.sh ranks TRIAL [COUNT] [SEED]   many ranks: resume, damage, kill or scenes (tests/ranks/trials.py says what they do)
#   tools/run.sh tidy [FILE...]      clang-tidy on every source file, or on these
#   tools/run.sh install PACKAGE...  installs Debian packages, and fails where one cannot be
# Installs what is missing (Debian and its children), configures, builds and runs. Asks nothing. The command is build/release/tools/dvdx;
# demo and report leave out of it what they do not need, and what is left out says which command builds it. test and page have a
# tree of their own, build/developer. After each of them `cmake --install` of its tree installs what was built.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

first_packages=(g++ cmake ninja-build libxsimd-dev libeigen3-dev libexpected-dev libcli11-dev nlohmann-json3-dev libfmt-dev zlib1g-dev
                libpugixml-dev)
packages=("${first_packages[@]}" libzip-dev libmetis-dev doctest-dev libbenchmark-dev gnuplot-nox libopenmpi-dev openmpi-bin)

say() { printf '\n== %s\n' "$*" >&2; }
fail() { printf 'tools/run.sh: %s\n' "$*" >&2; exit 2; }
usage() { sed -n '2,/^#   tools.run.sh install/s/^# \{0,1\}//p' tools/run.sh >&2; exit 2; }

# takes MINUTES TEXT: what is done, and how long that takes; MINUTES: of one core, from nothing built
takes() { say "$2: about $((($1 + $(nproc) - 1) / $(nproc))) minutes on the $(nproc) cores of this machine where nothing else runs, packages and what is built already aside"; }

is_installed() { [ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    fail "these packages are missing, and there is no sudo to install them: ${missing[*]}"
  fi
}

apt() { as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 "$@" </dev/null >&2; }

install_missing() {
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    command -v cmake >/dev/null && { command -v c++ || command -v g++ || command -v clang++; } >/dev/null && return
    fail "there is no apt here to install with. Needed, under Debian's names: ${packages[*]}"
  fi
  missing=()
  for package in "${packages[@]}"; do is_installed "$package" || missing+=("$package"); done
  [ ${#missing[@]} -eq 0 ] && return
  say "installing ${missing[*]}"
  apt install --no-install-recommends "${missing[@]}" || { apt update && apt install --no-install-recommends "${missing[@]}"; } ||
    fail "these packages cannot be installed: ${missing[*]}"
}

# install_wanted PACKAGE...: what is good to have; goes on without what cannot be installed
install_wanted() {
  command -v apt-get >/dev/null && command -v dpkg-query >/dev/null || return 0
  missing=()
  for package in "$@"; do is_installed "$package" || missing+=("$package"); done
  for package in "${missing[@]}"; do
    say "installing $package"
    (apt install --no-install-recommends "$package" || { apt update && apt install --no-install-recommends "$package"; }) ||
      say "going on without $package"
  done
}

# newer_node: Node.js as the pages need it, from the npm registry into build/node where Debian's is older
newer_node() {
  local machine
  node -e 'const [a, b] = process.versions.node.split("."); process.exit(a > 20 || (a == 20 && b >= 19) ? 0 : 1)' && return
  case $(uname -m) in x86_64) machine=x64 ;; aarch64) machine=arm64 ;; *) return ;; esac
  say "installing Node.js 22 into build/node: $(node --version) is too old for the pages"
  npm install --no-save --no-audit --no-fund --prefix build/node "node-linux-$machine@22" >&2
  PATH=$PWD/build/node/node_modules/node-linux-$machine/bin:$PATH
}

options=() # of CMake

# best_isa: the instruction set of this processor that a run takes
best_isa() {
  has() { for flag in "$@"; do grep -qw "$flag" /proc/cpuinfo || return 1; done; }
  case $(uname -m) in
    x86_64) if has avx512f avx512bw avx512cd avx512dq avx512vl; then echo avx512; elif has avx2; then echo avx2; else echo sse2; fi ;;
    aarch64) echo neon64 ;;
    *) echo reference ;;
  esac
}

# small LAB: build/release gets no more than this processor runs, and LAB of the commands that measure: none or report. A larger build
# that is there stays.
small() {
  local lab
  [ -e build/release/tools/dvdx ] ||
    options+=("-DDVDX_ISAS=$(best_isa)" -DDVDX_ARITHMETICS=separate -DDVDX_PLAN_OPTIONS=-O1 -DDVDX_LAB=none -DDVDX_MPI=OFF -DDVDX_BUILD_TESTS=OFF -DDVDX_BUILD_BENCH=OFF)
  lab=$(sed -n 's/^DVDX_LAB:[A-Z]*=//p' build/release/CMakeCache.txt 2>/dev/null || true)
  [ "$1" != report ] || [ "$lab" = all ] || options+=(-DDVDX_LAB=report)
}

# whole: build/release gets everything
whole() { options+=(-DDVDX_ISAS=all -DDVDX_ARITHMETICS=all -DDVDX_PLAN_OPTIONS= -DDVDX_LAB=all -DDVDX_MPI=ON -DDVDX_BUILD_BENCH=ON); }

# build PRESET TARGET...
build() {
  local preset=$1 generator=()
  shift
  command -v ninja >/dev/null || generator=(-G "Unix Makefiles")
  say "building $* ($preset)"
  cmake --preset "$preset" "${generator[@]}" "${options[@]}" >&2 || fail "cmake cannot configure. Needed, under Debian's names: ${packages[*]}"
  case $preset in release | developer) set -- "$@" dvdx_installed ;; esac
  cmake --build "build/$preset" --parallel "$(nproc)" --target "$@" >&2
}

# fuzz_target PRESET TARGET LIMIT: from the committed corpus and from what earlier runs found, which stays in build/fuzz/corpus.
# Inputs that break a promise are left in build/fuzz/findings.
fuzz_target() {
  local preset=$1 target=$2 limit=$3 log=build/fuzz/$2.log options=()
  mkdir -p "build/fuzz/corpus/$target" build/fuzz/findings
  [ ! -e "tests/fuzz/$target.dict" ] || options+=("-dict=tests/fuzz/$target.dict")
  [[ $limit != -runs=* ]] || options+=(-seed=1) # what a build has passed once it passes again
  # Without entropic: its schedule took half of the time, and a third of the inputs a second.
  "build/$preset/tests/fuzz/dvdx_fuzz" "$target" "$limit" -entropic=0 -max_len=1024 -timeout=60 -malloc_limit_mb=256 -print_final_stats=1 \
    "-artifact_prefix=build/fuzz/findings/$target-" "${options[@]}" "build/fuzz/corpus/$target" "tests/fuzz/corpus/$target" \
    >"$log" 2>&1 || { tail -n 40 "$log" >&2; printf 'tools/run.sh: %s, see build/fuzz/findings\n' "$target" >&2; return 1; }
  awk -v target="$target" '/number_of_executed_units/ {units = $2} /^Done/ {seconds = $5}
    END {printf "%-14s %9d executions in %5d s\n", target, units, seconds}' "$log"
}

[ $# -ge 1 ] || usage
action=$1
shift
case $action in
  demo)
    [ $# -eq 0 ] || usage
    takes 5 "building the command for this processor ($(best_isa)), and a flag in the wind"
    packages=("${first_packages[@]}")
    install_missing
    ! command -v npm >/dev/null || newer_node
    ! command -v node >/dev/null || options=("-DDVDX_NODE=$(command -v node)")
    small none
    build release dvdx_command dvdx_viewer
    say "build/release/tools/dvdx run tools/scenes/flag-in-wind.json"
    build/release/tools/dvdx run tools/scenes/flag-in-wind.json --out build/flag.png
    if [ -e build/release/tools/viewer/playback.html ]; then
      build/release/tools/dvdx run tools/scenes/flag-in-wind.json --out build/flag.html >/dev/null
      say "open build/flag.html in a browser: it plays. build/flag.png is its last picture"
    else
      build/release/tools/dvdx run tools/scenes/flag-in-wind.json --out build/flag.apng >/dev/null
      say "open build/flag.apng in a browser: it moves. A page to turn and play needs Node.js 20.19 or newer with npm (Debian: nodejs npm); then this command again"
    fi
    ;;
  build)
    [ $# -eq 0 ] || usage
    takes 20 "building the whole command"
    install_missing
    whole
    build release dvdx_command dvdx_viewer
    say "build/release/tools/dvdx is there"
    ;;
  report)
    takes 6 "building what reports for this processor ($(best_isa)), and a report"
    packages=("${first_packages[@]}" gnuplot-nox)
    install_missing
    small report
    build release dvdx_command dvdx_viewer
    [ $# -ge 1 ] || set -- tools/scenes/two-springs.json tools/scenes/bouncing.json tools/scenes/meadow.json --quick
    say "dvdx report $*"
    build/release/tools/dvdx report "$@"
    ;;
  test)
    [ $# -eq 0 ] || usage
    takes 20 "building everything, warnings as errors, and every test"
    install_missing
    install_wanted python3-cffi python3-numpy python3-matplotlib # else the test of the Python module is skipped
    build developer all
    say "tests"
    ctest --test-dir build/developer --parallel "$(nproc)" --output-on-failure --label-exclude page
    grep -ha '^\[doctest\] \(test cases\|assertions\)' build/developer/Testing/Temporary/LastTest.log
    ;;
  page) # exit 3: the pages cannot be built here
    [ $# -eq 0 ] || usage
    install_missing
    command -v npm >/dev/null || install_wanted nodejs npm
    command -v chromium >/dev/null || install_wanted chromium
    ! command -v npm >/dev/null || newer_node
    ! command -v node >/dev/null || options=("-DDVDX_NODE=$(command -v node)")
    build developer dvdx_command dvdx_viewer
    if ! [ -e build/developer/tools/viewer/report.html ]; then
      say "the pages cannot be built here: see above"
      exit 3
    fi
    say "pages"
    ctest --test-dir build/developer --output-on-failure --label-regex page
    ;;
  bench)
    install_missing
    whole
    build release dvdx_bars dvdx_bench
    export OMP_PROC_BIND=true # each thread keeps to its core
    [ $# -ge 1 ] || build/release/bench/dvdx_bars
    build/release/bench/dvdx_bench "$@"
    ;;
  peers)
    install_missing
    install_wanted libbullet-dev libboost-dev libsundials-dev
    whole
    build release dvdx_peers
    build/release/bench/peers/dvdx_peers "$@"
    ;;
  verify)
    install_missing
    whole
    build release dvdx_command
    [ $# -ge 1 ] || set -- tools/scenes/*.json
    say "dvdx verify $*"
    build/release/tools/dvdx verify "$@"
    ;;
  fuzz)
    packages+=(clang libclang-rt-14-dev)
    preset=fuzz seconds=60 executions=
    if [ "${1:-}" = --plain ]; then
      preset=fuzz-plain
      shift
    fi
    if [ "${1:-}" = --executions ]; then
      executions=${2:-}
      [[ $executions =~ ^[0-9]+$ ]] || usage
      shift 2
    elif [[ ${1:-} =~ ^[0-9]+$ ]]; then
      seconds=$1
      shift
    fi
    [ $# -ge 1 ] || set -- $(ls tests/fuzz/corpus)
    for target in "$@"; do
      [ -d "tests/fuzz/corpus/$target" ] || fail "there is no target $target: $(ls -x -w 0 tests/fuzz/corpus)"
    done
    install_missing
    build "$preset" dvdx_fuzz
    limit=-max_total_time=$seconds
    [ -z "$executions" ] || limit=-runs=$((executions / $#))
    say "fuzzing $*, each with $limit"
    found=0
    for target in "$@"; do fuzz_target "$preset" "$target" "$limit" || found=1; done
    exit $found
    ;;
  mutants)
    packages+=(python3 git)
    install_missing
    python3 tests/mutants/run.py "$@"
    ;;
  ranks)
    packages+=(python3)
    install_missing
    whole
    build release dvdx_command
    python3 tests/ranks/trials.py build/release/tools/dvdx "$@"
    ;;
  tidy)
    packages+=(clang clang-tidy libomp-dev)
    install_missing
    say "configuring (clang)"
    cmake --preset clang -B build/tidy -DCMAKE_EXPORT_COMPILE_COMMANDS=ON >&2
    # As they are compiled: a folder at a time. Files of instruction sets are the same templates six times.
    [ $# -ge 1 ] || set -- $(sed -n 's/^ *"file": "\(.*\)"$/\1/p' build/tidy/compile_commands.json | grep -E '/(kernel|layouts)/(src|CMakeFiles)/' | grep -v /isa/)
    say "clang-tidy on $# files"
    printf '%s\n' "$@" | xargs -P "$(nproc)" -n 1 clang-tidy --quiet -p build/tidy --checks=-bugprone-suspicious-include \
      --header-filter='(kernel|layouts|tools|tests)/.*\.(hpp|cpp)$'
    ;;
  install)
    packages+=("$@")
    install_missing
    ;;
  *) usage ;;
esac
