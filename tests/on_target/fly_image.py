"""fly_image.py SWIFTLET PEER FOLDER bare|hosted|float COMMAND...: flies companion_image through a classroom in lock-step.

COMMAND runs it. PEER, companion_peer of the host, is vehicle and ground station at the other end of its line: a bare
board's second serial line, the standard input of any other. Both print how the flight went. SWIFTLET replays the log, unless
its numbers are floats. Exit status 77 without the host's programs: build the preset host-release.
"""
import atexit
import pathlib
import socket
import subprocess
import sys
import tempfile

MAP_REGION = 0x60000000
MOST_STACK = 8192  # bytes
PATIENCE = 240  # seconds
SKIPPED = 77


def make_map(program, folder):
    octomap, blob = folder / "classroom.bt", folder / "classroom.swm"
    subprocess.run([program, "world", "classroom", "--seed", "1", "-o", octomap], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([program, "map", "build", octomap, "-o", blob, "--radius", "0.3", "--no-verify"], check=True,
                   stderr=subprocess.DEVNULL)
    return octomap, blob


def start(command, standard_input, folder):
    image = subprocess.Popen(command, stdin=standard_input, stdout=subprocess.PIPE, text=True, cwd=folder)
    atexit.register(image.kill)
    return image


def start_bare(command, blob):
    """The image and the line to it. The second -serial must follow the first, so it comes before `-kernel IMAGE`."""
    with tempfile.TemporaryDirectory() as short, socket.socket(socket.AF_UNIX) as listener:
        path = pathlib.Path(short) / "line"  # the build folder's path may be too long for a socket
        listener.bind(str(path))
        listener.listen(1)
        listener.settimeout(60)
        image = start([*command[:-2], "-device", f"loader,file={blob},addr={MAP_REGION:#x},force-raw=on",
                       "-serial", f"unix:{path}", *command[-2:]], subprocess.DEVNULL, blob.parent)
        line, _ = listener.accept()
    line.setblocking(True)
    return image, line


def start_hosted(command, blob):
    line, far_end = socket.socketpair()
    with far_end:
        return start([*command, blob], far_end, blob.parent), line


def replay(program, log, blob):
    subprocess.run([program, "replay", log, "--map", blob], check=True)
    print(f"{log.stat().st_size} bytes of log")


def main():
    program, peer, folder, kind, *command = sys.argv[1:]
    for needed in (program, peer):
        if not pathlib.Path(needed).exists():
            print(f"skipped: {needed} does not exist; build the preset host-release first")
            sys.exit(SKIPPED)
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    log = folder / "flight_0001.ulg"
    log.unlink(missing_ok=True)
    octomap, blob = make_map(program, folder)

    image, line = (start_bare if kind == "bare" else start_hosted)(command, blob)
    with line:
        flight = subprocess.run([peer, octomap], stdin=line, timeout=PATIENCE)
        if flight.returncode != 0:
            image.kill()
        console, _ = image.communicate(timeout=60)  # with the line open: the last bytes may be under way
    print(console, end="")
    if flight.returncode != 0 or image.returncode != 0:
        sys.exit(f"the flight ended with status {flight.returncode}, the image with {image.returncode}")
    stack = int(console.split()[-2])
    if stack > MOST_STACK:
        sys.exit(f"the flight took {stack} bytes of stack; at most {MOST_STACK} are allowed")
    if kind != "float":
        replay(program, log, blob)


main()
