"""Answers queries on the host and on a board, compares the answers bit by bit and prints what they took.

usage: compare_plan.py PROGRAM FOLDER SCENE bare|hosted COMMAND...
  PROGRAM   the host's swiftlet
  FOLDER    where the scene, its map and the host's plans are written
  SCENE     classroom, maze or geb079
  COMMAND   runs plan_image; a bare board takes its map from QEMU's loader and its arguments by semihosting

Exit status 77 where the scan of the scene geb079 is not on this machine.
"""

import csv
import dataclasses
import gzip
import json
import os
import pathlib
import struct
import subprocess
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
V_MAX, A_MAX = "1", "1"
MAP_REGION = 0x60000000
MOST_STACK = 8192  # bytes, from the query to the certified trajectory
SKIPPED = 77
CLOCK_HZ = 480e6  # of the estimate
CYCLES = (1, 3)  # an instruction, at the best and with slow memory and doubles


@dataclasses.dataclass
class Scene:
    octomap: pathlib.Path
    radius: str
    queries: list  # rows of a query file


def bits(value):
    return struct.pack(">d", float(value)).hex()


def read_queries(file):
    with file.open() as rows:
        return list(csv.DictReader(rows))


def world(program, folder, kind, seed, index):
    """One query of a world: 0 is its main query."""
    octomap, queries = folder / "world.bt", folder / "world.csv"
    subprocess.run([program, "world", kind, "--seed", str(seed), "-o", octomap, "--query", queries], check=True)
    return Scene(octomap, "0.15", [read_queries(queries)[index]])


def scanned_floor(folder):
    """geb079 with its ten queries, from the shared maps or from Debian's liboctomap-dev."""
    shared = pathlib.Path(os.environ.get("SWIFTLET_SHARED", REPOSITORY.parent / "shared"))
    debian = pathlib.Path("/usr/share/doc/liboctomap-dev/examples/data/geb079.bt")
    queries = read_queries(REPOSITORY / "tests/data/geb079_queries.csv")
    for octomap in (shared / "maps/geb079/geb079.bt", debian):
        if octomap.exists():
            return Scene(octomap, "0.30", queries)
    packed = debian.with_name("geb079.bt.gz")
    if not packed.exists():
        print(f"skipped: geb079.bt is neither in {shared}/maps/geb079 nor in {debian.parent}")
        sys.exit(SKIPPED)
    octomap = folder / "geb079.bt"
    octomap.write_bytes(gzip.decompress(packed.read_bytes()))
    return Scene(octomap, "0.30", queries)


def find_scene(name, program, folder):
    if name == "classroom":
        return world(program, folder, "classroom", seed=1, index=0)
    if name == "maze":
        return world(program, folder, "maze", seed=5, index=21)  # 30 boxes
    return scanned_floor(folder)


def expected_lines(plan):
    """Lines that plan_image should print for a plan of the host."""
    lines = ["status " + plan["status"]]
    for name, boxes in (("box", plan.get("corridor", [])), ("gate", plan.get("gates", []))):
        lines += [" ".join([name, *map(bits, box)]) for box in boxes]
    for segment in plan.get("segments", []):
        lines.append("duration " + bits(segment["duration"]))
        lines += [" ".join([axis, *map(bits, segment[axis])]) for axis in "xyz"]
    return lines


def host_plans(program, folder, scene):
    """The file for the board's map region, the blob and the requests, and the host's plans."""
    blob, query_file, plan_file = (folder / name for name in ("map.swm", "query.csv", "plans.jsonl"))
    subprocess.run([program, "map", "build", scene.octomap, "-o", blob, "--radius", scene.radius, "--no-verify"],
                   check=True, stderr=subprocess.DEVNULL)
    names = [axis + end for end in "01" for axis in "xyz"]
    rows = [[query[name] for name in names] for query in scene.queries]
    query_file.write_text("\n".join(",".join(row) for row in [names, *rows]) + "\n")
    subprocess.run([program, "plan", blob, "--queries", query_file, "--vmax", V_MAX, "--amax", A_MAX, "--jsonl",
                    plan_file], check=True, stderr=subprocess.DEVNULL)

    region = folder / "region.bin"
    numbers = [len(rows), *(number for row in rows for number in [*row, V_MAX, A_MAX])]
    region.write_bytes(blob.read_bytes() + struct.pack(f"<{len(numbers)}d", *map(float, numbers)))
    return region, [json.loads(line) for line in plan_file.read_text().splitlines()]


def board_lines(kind, command, region):
    arguments = [str(region)]
    if kind == "bare":
        arguments = ["-device", f"loader,file={region},addr={MAP_REGION:#x},force-raw=on",
                     "-semihosting-config", f"enable=on,target=native,arg=plan_image,arg={region}"]
    board = subprocess.run([*command, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
    lines = board.stdout.splitlines()
    if board.returncode != 0:
        sys.exit(f"the board ended with status {board.returncode}: {lines[-5:]}")
    return lines


def split_answers(lines):
    """For each answer its lines and its counts: windows reached and expanded, instructions of search and trajectory."""
    answers, answer = [], []
    for line in lines:
        if line.startswith("counts "):
            answers.append((answer, [int(word) for word in line.split()[1:]]))
            answer = []
        else:
            answer.append(line)
    return answers


def compare(query, expected, actual):
    for line, (host, board) in enumerate(zip(expected, actual), start=1):
        if host != board:
            sys.exit(f"query {query}, line {line} differs\n  host  {host}\n  board {board}")
    if len(expected) != len(actual):
        sys.exit(f"query {query}: the host has {len(expected)} lines, the board {len(actual)}")
    if not any(line.startswith("duration") for line in actual):
        sys.exit(f"query {query}: there is no trajectory to compare: {actual[0]}")


def main():
    program, folder, name, kind, *command = sys.argv[1:]
    if not pathlib.Path(program).exists():
        sys.exit(f"{program} does not exist; build the preset host-release first")
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    region, plans = host_plans(program, folder, find_scene(name, program, folder))
    *lines, stack = board_lines(kind, command, region)
    answers = split_answers(lines)
    if len(answers) != len(plans):
        sys.exit(f"the host has {len(plans)} answers, the board {len(answers)}")

    print("| query | boxes | reached | expanded | search | trajectory | ms, 1 cycle each | ms, 3 cycles each |")
    print("| --- " * 8 + "|")
    for query, (plan, (actual, counts)) in enumerate(zip(plans, answers), start=1):
        compare(query, expected_lines(plan), actual)
        estimates = [f"{sum(counts[2:]) * cycles / CLOCK_HZ * 1e3:.1f}" for cycles in CYCLES]
        words = [f"{name} {query}", len(plan["corridor"]), *(f"{count:,}" for count in counts), *estimates]
        print("|", " | ".join(map(str, words)), "|")
    print(f"every bit equals the host's; {stack} bytes")
    if int(stack.split()[-1]) > MOST_STACK:
        sys.exit(f"the plans took {stack} bytes; at most {MOST_STACK} are allowed")


main()
