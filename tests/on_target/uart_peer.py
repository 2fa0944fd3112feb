"""uart_peer.py EMULATOR... IMAGE: runs uart_image with a socket as its second serial line and checks every echo."""
import atexit
import os
import socket
import subprocess
import sys
import tempfile

folder = tempfile.mkdtemp()
path = os.path.join(folder, "line")
listener = socket.socket(socket.AF_UNIX)
listener.bind(path)
listener.listen(1)
listener.settimeout(60)
command = sys.argv[1:-2]  # all but -kernel IMAGE: the second -serial must follow the first
emulator = subprocess.Popen(command + ["-serial", "unix:" + path, *sys.argv[-2:]], stdin=subprocess.DEVNULL)
atexit.register(emulator.kill)

line, _ = listener.accept()
line.settimeout(60)
sent = bytes(1 + i % 255 for i in range(3000)) + b"\0"
for begin in range(0, len(sent), 200):
    line.sendall(sent[begin : begin + 200])
expected = bytes((b + 1) % 256 for b in sent)
got = b""
while len(got) < len(expected):
    chunk = line.recv(4096)
    if not chunk:
        sys.exit(f"the line closed after {len(got)} of {len(expected)} bytes")
    got += chunk
status = emulator.wait(60)
os.remove(path)
os.rmdir(folder)
print(f"{len(got)} bytes, equal: {got == expected}, exit status {status}")
sys.exit(0 if got == expected and status == 0 else 1)
