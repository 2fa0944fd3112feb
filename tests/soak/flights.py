#!/usr/bin/env python3
"""Seeded flights in lock-step through five maps with random goals, wind, delay and faults: every one is checked.

  flights.py SWIFTLET FOLDER [--count N] [--seed S] [--octomap geb079.bt] [--jobs J]
             [--heading-noise N] [--table F.md]

A flight fails when
  - the program does not end with status 0 or 1, or leaves no report;
  - it ends neither arrived and landed, nor holding, nor yielded, nor idle without a take-off, or not arrived without a reason;
  - the vehicle's centre came closer to an occupied voxel than its radius, while the companion was in control. Not
    counted as failures, but told on a line of their own, where the touch came while it lasted or within AFTERMATH: an
    autopilot's restart, which stops the motors, so that the vehicle falls; and body rates whose line fell silent, of
    which the autopilot keeps the last for up to a second;
  - the reference exceeded a limit that its plans were certified for;
  - a set-point was stale (sent at another time than made) or repeated while the reference moved.
"""

import argparse
import collections
import concurrent.futures
import csv
import json
import pathlib
import random
import statistics
import subprocess
import sys

# Name, radius of the map [m], set-point forms. The position form needs room for the autopilot's own loop.
WORLDS = [
    ("classroom", 0.30, ("attitude", "rates")),
    ("maze", 0.30, ("attitude", "rates")),
    ("office", 0.40, ("attitude", "rates")),
    ("forest", 0.65, ("attitude", "rates", "position")),
    ("geb079", 0.30, ("attitude", "rates")),
]
GEB079_START = "2.600,4.920,1.720"
FAULTS = ("cut", "corrupt", "loss", "stall", "starve", "odometry-stale", "odometry-nan", "position-jump", "restart",
          "pilot", "clock-jump", "sleep", "clock-step", "map-replaced", "storage-full")
# How long [s] no new set-point reaches the autopilot, or one after the other is lost; after a cut of 1 s it flies itself.
SILENCES = {"cut": 1, "loss": 5, "stall": 0.2, "starve": 2, "sleep": 0.5}
RESTART = 3  # [s]
AFTERMATH = 3  # [s] until a vehicle that was thrown off its path is back
LIMIT_TOLERANCE = 1e-3  # [m/s] [m/s^2]
CANDIDATES = 300


def run(*command):
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)


def must(*command):
    done = run(*command)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr.strip()}")
    return done.stdout


class World:
    """A map with points that are connected with each other."""

    def __init__(self, program, folder, name, radius, forms, octomap, seed):
        self.name, self.forms = name, forms
        self.map = folder / f"{name}.swm"
        source = folder / f"{name}.bt"
        if name == "geb079":
            source, base = octomap, GEB079_START
        else:
            must(program, "world", name, "--seed", 1, "-o", source, "--query", folder / f"{name}.csv")
            with open(folder / f"{name}.csv", encoding="utf-8") as rows:
                main = next(csv.DictReader(rows))
            base = ",".join(main[key] for key in ("x0", "y0", "z0"))
        info = json.loads(must(program, "map", "build", source, "-o", self.map, "--radius", radius, "--no-verify",
                               "--json", "-"))
        self.points = self.connected_points(program, folder, base, info["bounds"], random.Random(f"{name} {seed}"))

    def connected_points(self, program, folder, base, bounds, source):
        points = [[round(source.uniform(bounds[k], bounds[k + 3]), 3) for k in range(3)] for _ in range(CANDIDATES)]
        queries = folder / f"{self.name}_points.csv"
        lines = ["x0,y0,z0,x1,y1,z1"] + [f"{base},{p[0]},{p[1]},{p[2]}" for p in points]
        queries.write_text("\n".join(lines) + "\n", encoding="utf-8")
        plans = must(program, "plan", self.map, "--queries", queries, "--vmax", 1, "--amax", 2, "--jsonl", "-")
        reached = [json.loads(line)["status"] in ("optimal", "fallback") for line in plans.splitlines()]
        kept = [point for point, ok in zip(points, reached) if ok]
        if len(kept) < 4:
            sys.exit(f"{self.name}: only {len(kept)} of {CANDIDATES} random points can be reached")
        return kept


def text(point):
    return ",".join(f"{x:.3f}" for x in point)


def make_flight(world, number, seed, heading_noise):
    """The arguments of one flight, all drawn from its number."""
    draw = random.Random(f"{seed} {number}")
    places = draw.sample(world.points, draw.randint(2, min(4, len(world.points))))
    arguments = ["fly", world.map, "--in-process", "--seed", number, "--start", text(places[0])]
    for goal in places[1:]:
        arguments += ["--goal", text(goal)]
    arguments += ["--setpoint", draw.choice(world.forms), "--yaw", f"{draw.uniform(-3.1, 3.1):.3f}"]
    arguments += ["--vmax", draw.choice((0.5, 1, 1, 1.5)), "--amax", draw.choice((1, 2, 2))]
    if draw.random() < 0.6:
        wind = [draw.uniform(-2, 2), draw.uniform(-2, 2), 0]
        arguments += [f"--wind={text(wind)}", "--gust", f"{draw.uniform(0, 3):.2f}"]
    if draw.random() < 0.5:
        arguments += ["--link-delay", f"{draw.choice((0.005, 0.02)):g}"]
    arguments += ["--heading-noise", f"{heading_noise:g}"]
    for _ in range(draw.choice((0, 0, 1, 1, 1, 2))):
        arguments += ["--fault", f"{draw.choice(FAULTS)}@{draw.uniform(5, 45):.3f}"]
    return arguments


def touches(report):
    clearance = report["flown_clearance"]
    return clearance is not None and not clearance > report["margins"]["vehicle_radius"]


def takes_it_out_of_hands(fault, report):
    """Whether the first touch came of a fault that gave the vehicle to an autopilot that does not hold its attitude."""
    lasts = RESTART if fault["fault"] == "restart" else SILENCES.get(fault["fault"])
    if lasts is None or (fault["fault"] != "restart" and report["request"]["setpoint"] != "rates"):
        return False
    return 0 <= report["touched_at"] - fault["t"] <= lasts + AFTERMATH


def out_of_hands(report):
    """The kind of fault that excuses a touch, if there was one and one does."""
    if not touches(report):
        return None
    return next((fault["fault"] for fault in report["faults"] if takes_it_out_of_hands(fault, report)), None)


def defects(report):
    """What is wrong with a flight, in words."""
    found = []
    arrived = report["status"] == "arrived"
    late = any(fault["t"] > report["arrivals"][-1] for fault in report["faults"]) if arrived else False
    if arrived and not report["landed"] and not late:  # a fault while it lands leaves that to the pilot or autopilot
        found.append("arrived, but has not landed")
    grounded = report["state"] == "idle" and all(event["what"] != "phase: take-off" for event in report["events"])
    if not arrived and report["state"] not in ("holding", "yielded") and not grounded:
        found.append(f"ends {report['state']}: {report['status']}")
    if not arrived and not report.get("reason"):
        found.append("ends without a reason")
    if not arrived and report["status"] in ("timeout", "no_take_off", "stopped") and not report["faults"]:
        found.append(f"ends with {report['status']} without any fault")
    if touches(report) and not out_of_hands(report):
        found.append(f"came to {report['flown_clearance']:.3f} m of an obstacle, its radius is "
                     f"{report['margins']['vehicle_radius']:.3f} m")
    for what, limit in (("speed", "vmax"), ("acceleration", "amax")):
        reached = max(report["reference"][f"max_{what}"])
        if reached > report["request"][limit] + LIMIT_TOLERANCE:
            found.append(f"the reference's {what} was {reached:.4f}, its limit {report['request'][limit]}")
    # Where the companion's clock jumps the reference stands still for one step: its numbers are new, but the same.
    jumps = sum(1 for fault in report["faults"] if fault["fault"] == "clock-step")
    for what, allowed in (("stale", 0), ("repeated", jumps)):
        if report["setpoints"][what] > allowed:
            found.append(f"{report['setpoints'][what]} {what} set-points")
    return found


def fly(program, world, number, seed, heading_noise):
    arguments = make_flight(world, number, seed, heading_noise)
    done = run(program, *arguments, "--json", "-")
    line = " ".join(map(str, [program, *arguments]))
    if done.returncode not in (0, 1):
        return world, None, [f"exit status {done.returncode}: {done.stderr.strip()}"], line
    try:
        report = json.loads(done.stdout)
    except ValueError:
        return world, None, [f"no report: {done.stderr.strip()}"], line
    return world, report, defects(report), line


def outcome(report):
    return "arrived" if report["status"] == "arrived" else report["state"]


def world_table(results):
    lines = ["| map | flights | arrived | holding | yielded | least clearance beyond the radius [m] "
             "| tracking RMS / max without fault and wind [m] | with wind [m] | failed checks |",
             "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"]
    names = list(dict.fromkeys(world.name for world, *_ in results))
    for name in names + ["all"]:
        flights = [(report, found) for world, report, found, _ in results if name in (world.name, "all")]
        reports = [report for report, _ in flights if report]
        ends = collections.Counter(outcome(report) for report in reports)
        rooms = [r["flown_clearance"] - r["margins"]["vehicle_radius"] for r in reports if r["flown_clearance"] is not None]

        def tracking(windy, reports=reports):
            chosen = [r["tracking"] for r in reports if not r["faults"] and r["tracking"]["rms"] is not None
                      and r["request"]["setpoint"] != "position" and (r["request"]["gust"] > 0) == windy]
            if not chosen:
                return "-"
            return f"{statistics.median(t['rms'] for t in chosen):.3f} / {max(t['max'] for t in chosen):.3f}"

        lines.append(f"| {name} | {len(flights)} | {ends['arrived']} | {ends['holding']} | {ends['yielded']} | "
                     f"{min(rooms, default=float('nan')):.3f} | {tracking(False)} | {tracking(True)} "
                     f"| {sum(1 for _, found in flights if found)} |")
    return lines


def fault_table(results):
    lines = ["| fault | times | noticed | reaction after, median / max [s] | arrived | holding | yielded |",
             "| --- | --- | --- | --- | --- | --- | --- |"]
    for kind in FAULTS:
        seen = [(report, fault) for _, report, _, _ in results if report for fault in report["faults"]
                if fault["fault"] == kind]
        after = [fault["after"] for _, fault in seen if fault["after"] is not None]
        ends = collections.Counter(outcome(report) for report, _ in seen)
        times = f"{statistics.median(after):.2f} / {max(after):.2f}" if after else "-"
        lines.append(f"| {kind} | {len(seen)} | {len(after)} | {times} | {ends['arrived']} | {ends['holding']} | "
                     f"{ends['yielded']} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--octomap", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--heading-noise", type=float, default=0.001,
                        help="error of the autopilot's heading [rad]: what is left of it after the alignment grows with "
                        "the distance flown, and no margin of a building's size covers half a degree of it")
    parser.add_argument("--table", type=pathlib.Path)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    worlds = [World(options.program, options.folder, *world, options.octomap, options.seed) for world in WORLDS
              if world[0] != "geb079" or options.octomap]

    results = []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        jobs = [pool.submit(fly, options.program, worlds[n % len(worlds)], n, options.seed,
                            options.heading_noise)
                for n in range(options.count)]
        for job in jobs:
            results.append(job.result())
            for defect in results[-1][2]:
                print(f"{defect}\n  {results[-1][3]}", file=sys.stderr, flush=True)
    tables = world_table(results) + [""] + fault_table(results)
    print("\n".join(tables))
    if options.table:
        options.table.write_text("\n".join(tables) + "\n", encoding="utf-8")
    excuses = collections.Counter(out_of_hands(report) for _, report, _, _ in results if report)
    print(f"\ncloser to an obstacle than their radius: {excuses['restart']} flights after their motors stopped, "
          f"{sum(excuses[kind] for kind in SILENCES)} after their line fell silent with body rates")
    failed = sum(1 for _, _, found, _ in results if found)
    print(f"\n{len(results)} flights, {failed} failed", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
