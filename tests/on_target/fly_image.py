"""fly_image.py SWIFTLET PEER FOLDER EMULATOR... IMAGE: flies companion_image through a classroom in lock-step.

PEER, companion_peer of the host, is vehicle and ground station at the other end of the image's second serial line; both
print how the flight went. Exit status 77 without the host's programs: build the preset host-release.
"""
import atexit
import pathlib
import socket
import subprocess
import sys
import tempfile

MAP_REGION = 0x60000000
MOST_STACK = 8192  # bytes
SKIPPED = 77


def make_map(program, folder):
    octomap, blob = folder / "classroom.bt", folder / "classroom.swm"
    subprocess.run([program, "world", "classroom", "--seed", "1", "-o", octomap], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([program, "map", "build", octomap, "-o", blob, "--radius", "0.3", "--no-verify"], check=True,
                   stderr=subprocess.DEVNULL)
    return octomap, blob


def start_emulator(command, image, blob, line):
    """The second -serial must follow the first, so everything but `-kernel IMAGE` comes before it."""
    emulator = subprocess.Popen(
        [*command, "-device", f"loader,file={blob},addr={MAP_REGION:#x},force-raw=on", "-serial", f"unix:{line}",
         "-kernel", image], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
    atexit.register(emulator.kill)
    return emulator


def main():
    program, peer, folder, *command, _, image = sys.argv[1:]
    for needed in (program, peer):
        if not pathlib.Path(needed).exists():
            print(f"skipped: {needed} does not exist; build the preset host-release first")
            sys.exit(SKIPPED)
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    octomap, blob = make_map(program, folder)

    with tempfile.TemporaryDirectory() as short, socket.socket(socket.AF_UNIX) as listener:
        path = pathlib.Path(short) / "line"  # the build folder's path may be too long for a socket
        listener.bind(str(path))
        listener.listen(1)
        listener.settimeout(60)
        emulator = start_emulator(command, image, blob, path)
        line, _ = listener.accept()
        line.setblocking(True)
        with line:
            flight = subprocess.run([peer, octomap], stdin=line.fileno(), timeout=240)
            if flight.returncode != 0:
                emulator.kill()
            console, _ = emulator.communicate(timeout=60)  # with the line open: the last bytes may be under way
    print(console, end="")
    if flight.returncode != 0 or emulator.returncode != 0:
        sys.exit(f"the flight ended with status {flight.returncode}, the image with {emulator.returncode}")
    stack = int(console.split()[-2])
    if stack > MOST_STACK:
        sys.exit(f"the flight took {stack} bytes of stack; at most {MOST_STACK} are allowed")


main()
