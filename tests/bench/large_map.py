#!/usr/bin/env python3
"""Peak memory and time of `swiftlet map build` on 300 x 170 x 28 m at 0.20 m with 12 million free voxels.

    ./go build host-release && tests/bench/large_map.py SCAN.bt

The map is SCAN.bt (geb079.bt in docs/performance.md) many times over, made by build/host-release/tests/bench/large_map.
Exit status 1 when the build with its audit takes more than 1.5 GB.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

BUILD = pathlib.Path(__file__).resolve().parents[2] / "build/host-release"
LIMIT = 1.5e9  # bytes


def main(scan):
    with tempfile.TemporaryDirectory() as folder:
        source = f"{folder}/large.bt"
        print(subprocess.run([BUILD / "tests/bench/large_map", scan, source], check=True, text=True,
                             stdout=subprocess.PIPE).stdout, end="")
        run = subprocess.Popen([BUILD / "offline_tools/cli/swiftlet", "map", "build", source, "-o", f"{folder}/large.swm",
                                "--radius", "0.30", "--json", f"{folder}/large.json"])
        _, status, usage = os.wait4(run.pid, 0)
        if status != 0:
            return 1
        report = json.loads(pathlib.Path(f"{folder}/large.json").read_text())
    peak = 1024 * usage.ru_maxrss
    print(f"{report['cells']:,} cells, {report['windows']:,} windows, {report['blob_bytes'] / 1e6:.1f} MB: "
          f"{usage.ru_utime + usage.ru_stime:.0f} s of CPU, peak {peak / 1e6:.0f} MB")
    return 0 if peak < LIMIT else 1


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
