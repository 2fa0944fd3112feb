#!/usr/bin/env bash
# The one entry to building, testing and trying swiftlet. Without a verb it lists them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

presets=(host-release host-debug host-float linux-aarch64 mps2-an500) # host-release first: others' tests run its program
jobs=$(nproc)
program=build/host-release/offline_tools/cli/swiftlet

host_packages=(g++ cmake ninja-build libeigen3-dev liboctomap-dev libcli11-dev nlohmann-json3-dev libexpected-dev
  libssl-dev libbenchmark-dev googletest ca-certificates python3 python3-venv)
cross_packages=(gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib g++-aarch64-linux-gnu
  qemu-system-arm qemu-user clang-14 clang-format-14 clang-tidy-14 libclang-rt-14-dev)

# install PACKAGE...: installs those that are missing when root, otherwise prints the command and fails.
install() {
  local package missing=()
  for package in "$@"; do
    if [[ $(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null) != installed ]]; then
      missing+=("$package")
    fi
  done
  if ! command -v node >/dev/null || ! command -v npm >/dev/null; then missing+=(nodejs npm); fi
  if ((${#missing[@]} == 0)); then return; fi
  local command=(apt-get install -y --no-install-recommends "${missing[@]}")
  if ((EUID != 0)); then
    echo "Missing packages. Run: sudo apt-get update && sudo ${command[*]}" >&2
    exit 1
  fi
  echo "+ ${command[*]}"
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive "${command[@]}"
}

# build_target PRESET TARGET
build_target() {
  if [[ ! -f build/$1/build.ninja ]]; then cmake --preset "$1"; fi
  cmake --build "build/$1" -j "$jobs" --target "$2"
}

# build PRESET...
build() {
  local preset
  for preset in "$@"; do build_target "$preset" all; done
}

# sources: every C++ file of ours, one a line.
sources() {
  find firmware_core offline_tools hal boards tests -name node_modules -prune -o \
    \( -name '*.cpp' -o -name '*.hpp' \) -print | sort
}

check() {
  sources | xargs clang-format-14 --dry-run -Werror
  build host-release # the compile commands name generated headers
  local expression
  expression="^$PWD/(firmware_core|offline_tools|hal|boards|tests)/"
  run-clang-tidy-14 -p build/host-release -j 2 -quiet -extra-arg=-w "$expression" # warnings are g++ business
}

run_tests() {
  build "${presets[@]}"
  mkdir -p build/all
  printf 'subdirs("../%s")\n' "${presets[@]}" >build/all/CTestTestfile.cmake
  ctest --test-dir build/all -j 2 --output-on-failure --no-tests=error </dev/null
}

# real_map: prints the path of geb079.bt, the scanned floor among liboctomap-dev's examples.
real_map() {
  local examples=usr/share/doc/liboctomap-dev/examples/data/geb079.bt
  if [[ -r /$examples ]]; then
    echo "/$examples"
    return
  fi
  local folder=build/octomap_examples
  if [[ ! -r $folder/geb079.bt ]]; then # a machine that drops documentation
    mkdir -p "$folder"
    (cd "$folder" && apt-get download -qq liboctomap-dev >&2 && dpkg-deb -x liboctomap-dev_*.deb package)
    if [[ -r $folder/package/$examples.gz ]]; then gunzip "$folder/package/$examples.gz"; fi
    mv "$folder/package/$examples" "$folder/geb079.bt"
  fi
  echo "$folder/geb079.bt"
}

# show COMMAND...: prints a command as it can be typed, then runs it.
show() {
  printf '\n$ %s\n' "$*"
  "$@"
}

demo() {
  install "${host_packages[@]}"
  build_target host-release swiftlet
  local map
  map=$(real_map)
  mkdir -p out
  if [[ ! out/demo.swm -nt $program ]]; then
    show "$program" map build "$map" -o out/demo.swm --radius 0.30
  fi
  show "$program" plan out/demo.swm --start 2.600,4.920,1.720 --goal 23.080,-0.600,0.600 --vmax 1 --amax 1 \
    --json out/demo.json --csv out/demo.csv --report out/demo.html
  show "$program" map info out/demo.swm --json out/demo_map.json
  python3 - "$map" <<'PYTHON'
import json, sys
info, plan = json.load(open("out/demo_map.json")), json.load(open("out/demo.json"))
stats, certificate = plan["stats"], plan["certificate"]
rows = [
    ("map", f"{sys.argv[1]}, {info['resolution_m']:.3g} m voxels, radius {info['radius_m']:.2f} m"),
    ("cells", f"{info['cells']:,}"),
    ("blob", f"{info['blob_bytes'] / 1024:,.0f} KiB"),
    ("corridor", f"{len(plan['corridor'])} boxes"),
    ("length", f"{plan['length']:.2f} m"),
    ("duration", f"{plan['duration']:.2f} s"),
    ("search", f"{stats['search_us'] / 1000:.2f} ms"),
    ("trajectory", f"{stats['trajectory_us'] / 1000:.2f} ms"),
    ("certificate", ("pass" if certificate["pass"] else "FAIL") + f", margin {certificate['box_margin']:.1e} m, "
     f"speed {max(certificate['max_speed']):.3f} m/s, acceleration {max(certificate['max_acceleration']):.3f} m/s^2"),
]
print()
for name, value in rows:
    print(f"  {name:<12} {value}")
PYTHON
  show "$program" fly out/demo.swm --start 2.600,4.920,1.720 --goal 23.080,-0.600,0.600 --vmax 1 --amax 1 --in-process \
    --json out/demo_flight.json --report out/demo_flight.html
  python3 - <<'PYTHON'
import json
flight = json.load(open("out/demo_flight.json"))
tracking = flight["tracking"]
rows = [
    ("flight", flight["status"] + (", landed" if flight["landed"] else "")),
    ("duration", f"{flight['flown_duration']:.2f} s"),
    ("tracking", f"{tracking['rms']:.3f} m RMS, {tracking['max']:.3f} m at most"),
    ("clearance", f"{flight['flown_clearance']:.3f} m from the vehicle's centre to the nearest voxel"),
]
print()
for name, value in rows:
    print(f"  {name:<12} {value}")
PYTHON
  printf '\nOpen %s/out/demo.html and %s/out/demo_flight.html in a browser.\n' "$PWD" "$PWD"
}

bench() {
  build host-release
  local benchmark found=0
  while IFS= read -r benchmark; do
    found=1
    show "$benchmark" "$@"
  done < <(find build/host-release -type f -executable -name '*_bench' | sort)
  if ((found == 0)); then echo "There are no benchmarks yet."; fi
}

# fuzz [SECONDS]: the readers of maps, octrees, clouds, MAVLink and flight logs, with libFuzzer and sanitizers.
fuzz() {
  local seconds=${1:-60} reader pid pids=()
  if [[ ! -f build/fuzz/build.ninja ]]; then
    cmake -B build/fuzz -G Ninja -DCMAKE_CXX_COMPILER=clang++-14 -DCMAKE_C_COMPILER=clang-14 -DCMAKE_BUILD_TYPE=Release \
      -DCMAKE_CXX_FLAGS="-g1 -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all"
  fi
  cmake --build build/fuzz -j "$jobs" --target map_blob_fuzz mavlink_fuzz octree_fuzz point_cloud_fuzz ulog_fuzz
  for reader in map_blob:map mavlink:mavlink octree:octree point_cloud:cloud ulog:ulog; do
    mkdir -p "out/corpus/${reader#*:}"
    "build/fuzz/tests/fuzz/${reader%:*}_fuzz" -max_total_time="$seconds" -print_final_stats=1 -verbosity=0 \
      -artifact_prefix=out/ "out/corpus/${reader#*:}" "tests/data/fuzz_${reader#*:}" &
    pids+=($!)
  done
  for pid in "${pids[@]}"; do wait "$pid"; done
}

# soak flights [N]: N seeded flights in lock-step, every one checked.
soak_flights() {
  install "${host_packages[@]}"
  build_target host-release swiftlet
  nice python3 tests/soak/flights.py "$program" out/flights --count "${1:-1000}" --octomap "$(real_map)" --jobs "$jobs" \
    --table out/flights/table.md
}

# soak companion [SECONDS]: the companion with sanitizers, in wind and over a bad line, its memory watched.
soak_companion() {
  install "${host_packages[@]}"
  build_target host-debug companion_soak
  show nice build/host-debug/tests/companion_soak "${1:-60}"
}

# soak [properties]: the property tests with 50 times the cases of host-release.
soak_properties() {
  cmake --preset host-release -B build/soak -DSWIFTLET_PROPERTY_RUNS=100000 -DSWIFTLET_TEST_SECONDS=86400
  cmake --build build/soak -j "$jobs"
  ctest --test-dir build/soak -j 2 --output-on-failure --no-tests=error -R property </dev/null
}

usage() {
  cat <<'TEXT'
./go setup           install what building and testing needs
./go build [PRESET]  build one preset, or all of them
./go test            build every preset and run every test
./go check           formatting and static analysis
./go demo            plan through a scanned building, fly it, and write pages to look at
./go run ARGS        the release build of the program swiftlet
./go bench [ARGS]    the benchmarks
./go fuzz [SECONDS]  the readers under a fuzzer
./go soak [NAME]     at length: 'properties' with 50 times the cases, 'flights [N]', a thousand simulated ones, or
                     'companion [SECONDS]', a flight without end under sanitizers
TEXT
}

verb=${1:-}
shift || true
case $verb in
setup) install "${host_packages[@]}" "${cross_packages[@]}" ;;
build) build "${@:-${presets[@]}}" ;;
test) run_tests ;;
check) check ;;
demo) demo ;;
run)
  build_target host-release swiftlet >&2
  exec "$program" "$@"
  ;;
bench) bench "$@" ;;
fuzz) fuzz "$@" ;;
soak)
  case ${1:-properties} in
  properties) soak_properties ;;
  flights) soak_flights "${@:2}" ;;
  companion) soak_companion "${@:2}" ;;
  *)
    echo "go: there is no soak '$1': properties, flights and companion exist" >&2
    exit 2
    ;;
  esac
  ;;
'') usage ;;
*)
  echo "go: unknown verb '$verb'" >&2
  usage >&2
  exit 2
  ;;
esac
