"""Plans the main query of the classroom world on the host and on a board, and compares the answers bit by bit.

usage: compare_plan.py PROGRAM FOLDER bare|hosted COMMAND...
  PROGRAM   the host's swiftlet
  FOLDER    where the world, its map and the host's plan are written
  COMMAND   runs plan_image; a bare board takes its map from QEMU's loader and its arguments by semihosting
"""

import csv
import json
import pathlib
import struct
import subprocess
import sys

RADIUS, V_MAX, A_MAX = "0.15", "1", "2"
MAP_REGION = 0x60000000
MOST_STACK = 8192  # bytes, from the query to the certified trajectory


def bits(value):
    return struct.pack(">d", float(value)).hex()


def host_plan(program, folder):
    """Lines that plan_image should print, and the query as printed in the world's query file."""
    world, query_file, blob, plan_file = (folder / name for name in ("world.bt", "query.csv", "world.swm", "plan.json"))
    run = lambda *arguments: subprocess.run([program, *map(str, arguments)], check=True)
    run("world", "classroom", "--seed", 1, "-o", world, "--query", query_file)
    run("map", "build", world, "-o", blob, "--radius", RADIUS)
    with query_file.open() as rows:
        query = next(csv.DictReader(rows))
    start, goal = ([query[axis + end] for axis in "xyz"] for end in "01")
    run("plan", blob, "--start", ",".join(start), "--goal", ",".join(goal), "--vmax", V_MAX, "--amax", A_MAX,
        "--json", plan_file)
    plan = json.loads(plan_file.read_text())

    lines = ["status " + plan["status"]]
    for name, boxes in (("box", plan["corridor"]), ("gate", plan["gates"])):
        lines += [" ".join([name, *map(bits, box)]) for box in boxes]
    for segment in plan["segments"]:
        lines.append("duration " + bits(segment["duration"]))
        lines += [" ".join([axis, *map(bits, segment[axis])]) for axis in "xyz"]
    return blob, [*start, *goal, V_MAX, A_MAX], lines


def board_lines(kind, command, blob, query):
    arguments = [str(blob), *map(bits, query)]
    if kind == "bare":
        semihosting = ["enable=on,target=native", "arg=plan_image", *("arg=" + word for word in arguments)]
        arguments = ["-device", f"loader,file={blob},addr={MAP_REGION:#x},force-raw=on",
                     "-semihosting-config", ",".join(semihosting)]
    board = subprocess.run([*command, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
    lines = board.stdout.splitlines()
    if board.returncode != 0:
        sys.exit(f"the board ended with status {board.returncode}: {lines[-5:]}")
    return lines


def main():
    program, folder, kind, *command = sys.argv[1:]
    if not pathlib.Path(program).exists():
        sys.exit(f"{program} does not exist; build the preset host-release first")
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    blob, query, expected = host_plan(program, folder)
    *actual, stack = board_lines(kind, command, blob, query)
    for line, (host, board) in enumerate(zip(expected, actual), start=1):
        if host != board:
            sys.exit(f"line {line} differs\n  host  {host}\n  board {board}")
    if len(expected) != len(actual):
        sys.exit(f"the host has {len(expected)} lines, the board {len(actual)}")
    if not any(line.startswith("duration") for line in actual):
        sys.exit(f"there is no trajectory to compare: {actual[0]}")
    if int(stack.split()[-1]) > MOST_STACK:
        sys.exit(f"the plan took {stack} bytes of stack; at most {MOST_STACK} are allowed")
    print(f"{actual[0]}; {len(actual)} lines are equal to the last bit; {stack} bytes")


main()
