#!/usr/bin/env python3
"""How search time and blob size grow with the area of an office.

    ./go build host-release && tests/bench/office_scale.py [--svg FILE]

Generates the office of seed 1 at 1, 2, 4 and 8 times its area, builds each map (radius 0.30 m) and plans its 100 queries
with `--search default` and `--search plain`. Prints the table of docs/performance.md; --svg draws its plot
(docs/figures/office_scale.svg).
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess
import tempfile

SWIFTLET = pathlib.Path(__file__).resolve().parents[2] / "build/host-release/offline_tools/cli/swiftlet"
SCALES = (1, 2, 4, 8)
MODES = ("default", "plain")
REPEATS = 3  # of each batch of queries; a query counts with its fastest search


def run(*arguments):
    subprocess.run([SWIFTLET, *arguments], check=True, stderr=subprocess.DEVNULL)


def search_of(swm, csv, mode, folder):
    """Medians over the queries: time of the search [ms], windows expanded."""
    fastest, expanded = [math.inf] * 100, [0] * 100
    for _ in range(REPEATS):
        run("plan", swm, "--queries", csv, "--vmax", "1", "--amax", "1", "--search", mode, "--jsonl",
            f"{folder}/plans.jsonl")
        for i, line in enumerate(open(f"{folder}/plans.jsonl")):
            plan = json.loads(line)
            assert plan["status"] in ("optimal", "fallback"), plan["status"]
            fastest[i] = min(fastest[i], plan["stats"]["search_us"] / 1000)
            expanded[i] = plan["stats"]["expanded"]
    return statistics.median(fastest), statistics.median(expanded)


def measure(scale, folder):
    bt, csv, swm = (f"{folder}/office{ending}" for ending in (".bt", ".csv", ".swm"))
    run("world", "office", "--seed", "1", "--scale", str(scale), "-o", bt, "--query", csv)
    run("map", "build", bt, "-o", swm, "--radius", "0.30", "--json", f"{folder}/map.json")
    report = json.loads(pathlib.Path(f"{folder}/map.json").read_text())
    lengths = [float(line.split(",")[7]) for line in open(csv).readlines()[1:]]
    sections = report["section_bytes"]
    row = {"scale": scale, "cells": report["cells"], "windows": report["windows"],
           "blob": report["blob_bytes"], "graph": report["blob_bytes"] - sections["obstacles"],
           "length": statistics.median(lengths)}
    for mode in MODES:
        row[mode], row[mode + " expanded"] = search_of(swm, csv, mode, folder)
    return row


def slope(rows, key):
    """Exponent of the area between the smallest office and the largest."""
    return math.log(rows[-1][key] / rows[0][key]) / math.log(rows[-1]["scale"] / rows[0]["scale"])


def print_table(rows):
    print("| area | cells | windows | blob | without obstacles | path, median | default: expanded, time | plain: expanded, time |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for r in rows:
        print(f"| {r['scale']} x 3,900 m² | {r['cells']:,} | {r['windows']:,} | {r['blob'] / 1000:,.0f} kB | "
              f"{r['graph'] / 1000:,.0f} kB | {r['length']:.0f} m | {r['default expanded']:,.0f}, {r['default']:.3f} ms | "
              f"{r['plain expanded']:,.0f}, {r['plain']:.3f} ms |")
    print(f"| grows with area to the | {slope(rows, 'cells'):.2f} | {slope(rows, 'windows'):.2f} | {slope(rows, 'blob'):.2f} | "
          f"{slope(rows, 'graph'):.2f} | {slope(rows, 'length'):.2f} | {slope(rows, 'default expanded'):.2f}, "
          f"{slope(rows, 'default'):.2f} | {slope(rows, 'plain expanded'):.2f}, {slope(rows, 'plain'):.2f} |")


# --- the plot: every quantity relative to the office of scale 1, both axes logarithmic ---

SERIES = (("blob", "blob", "a"), ("default", "search time, default", "b"), ("plain", "search time, plain", "c"))
LEFT, TOP, WIDTH, HEIGHT, OCTAVE = 70, 46, 360, 300, 5  # [px]; the plot spans 2^0 to 2^OCTAVE upwards
STYLE = """
  svg { --ink: #1d2733; --soft: #6b7885; --grid: #dfe5ea; --a: #0072b2; --b: #d55e00; --c: #009e73; background: #ffffff }
  @media (prefers-color-scheme: dark) {
    svg { --ink: #e6edf3; --soft: #93a1af; --grid: #2d3742; --a: #56b4e9; --b: #ff9a4d; --c: #3ddc97; background: #0d1117 }
  }
  text { font: 13px system-ui, sans-serif; fill: var(--ink) } .soft { fill: var(--soft) } .grid { stroke: var(--grid) }
  .line { fill: none; stroke-width: 2.5 } .even { stroke: var(--soft); stroke-dasharray: 5 5; fill: none }
  .a { stroke: var(--a) } .b { stroke: var(--b) } .c { stroke: var(--c) }
  circle.a { fill: var(--a) } circle.b { fill: var(--b) } circle.c { fill: var(--c) }
  text.a { fill: var(--a); stroke: none } text.b { fill: var(--b); stroke: none } text.c { fill: var(--c); stroke: none }
"""


def place(scale, ratio):
    return (LEFT + WIDTH * math.log2(scale) / 3, TOP + HEIGHT - HEIGHT * math.log2(max(ratio, 0.9)) / OCTAVE)


def label_heights(rows):
    """y of the names at the right, apart from each other."""
    ends = sorted((place(8, rows[-1][key] / rows[0][key])[1], key) for key, _, _ in SERIES)
    heights, lowest = {}, -math.inf
    for y, key in ends:
        lowest = heights[key] = max(y, lowest + 20)
    return heights


def draw(rows):
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 680 400" role="img" '
             'aria-label="Blob size and search time of an office against its area, relative to scale 1">',
             f"<style>{STYLE}</style>", f'<text x="{LEFT}" y="24">times as much as at 3,900 m²</text>']
    for octave in range(OCTAVE + 1):
        x, y = place(1, 2**octave)
        parts.append(f'<line class="grid" x1="{x}" y1="{y:.1f}" x2="{x + WIDTH}" y2="{y:.1f}"/>'
                     f'<text class="soft" x="{x - 10}" y="{y + 4:.1f}" text-anchor="end">{2**octave}</text>')
    for scale in SCALES:
        x, _ = place(scale, 1)
        parts.append(f'<line class="grid" x1="{x:.1f}" y1="{TOP}" x2="{x:.1f}" y2="{TOP + HEIGHT}"/>'
                     f'<text class="soft" x="{x:.1f}" y="{TOP + HEIGHT + 22}" text-anchor="middle">{3900 * scale:,} m²</text>')
    (x0, y0), (x1, y1) = place(1, 1), place(8, 8)
    parts.append(f'<path class="even" d="M{x0} {y0:.1f}L{x1} {y1:.1f}"/>')
    heights = label_heights(rows)
    for key, name, colour in SERIES:
        points = [place(r["scale"], r[key] / rows[0][key]) for r in rows]
        parts.append(f'<path class="line {colour}" d="M' + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + '"/>')
        parts += [f'<circle class="{colour}" cx="{x:.1f}" cy="{y:.1f}" r="4"/>' for x, y in points]
        parts.append(f'<text class="{colour}" x="{LEFT + WIDTH + 14}" y="{heights[key] + 4:.1f}">{name}: '
                     f'{rows[-1][key] / rows[0][key]:.1f}</text>')
    parts.append(f'<text class="soft" x="{LEFT}" y="{TOP + HEIGHT + 44}">dashed: in proportion to the area</text></svg>')
    return "\n".join(parts) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--svg", help="plot to write")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = [measure(scale, folder) for scale in SCALES]
    print_table(rows)
    if arguments.svg:
        pathlib.Path(arguments.svg).write_text(draw(rows))


if __name__ == "__main__":
    main()
