#!/usr/bin/env bash
# An interrupt stops the work cleanly. Arguments: executable, scratch folder.
set -u
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
exec python3 - "$1" << 'END'
import json
import os
import random
import signal
import subprocess
import sys
import time

stipple = sys.argv[1]
random.seed(1)
def write_cloud(count):
    points = "".join(f"{random.random():.6f} {random.random():.6f} {random.random():.6f}\n" for _ in range(count))
    with open("cloud.ply", "w") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n"
                   f"property float z\nend_header\n{points}")

def processor_seconds(pid):
    with open(f"/proc/{pid}/stat") as file:
        return sum(map(int, file.read().rpartition(")")[2].split()[11:13])) / os.sysconf("SC_CLK_TCK")

write_cloud(150000)
with open("cloud.stip", "w") as file:
    file.write("what was there before")

command = [stipple, "build", "cloud.ply", "-o", "cloud.stip", "--progress", "json"]
process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
first = process.stderr.readline() # work has begun
process.send_signal(signal.SIGINT)
out, err = process.communicate()
assert "stage" in json.loads(first), first
assert process.returncode == 130, (process.returncode, err)
assert out == "", out
messages = [line for line in err.splitlines() if not line.startswith("{")]
assert len(messages) == 1 and messages[0].startswith("stipple: stopped while at: "), err
assert messages[0].endswith("; the same command resumes where it stopped"), err
assert sorted(os.listdir()) == ["cloud.ply", "cloud.stip"], os.listdir()
assert open("cloud.stip").read() == "what was there before"

# an interrupted flight or render leaves no pictures
write_cloud(2000)
assert subprocess.run([stipple, "build", "cloud.ply", "-o", "cloud.stip", "-q"]).returncode == 0
with open("flight.json", "w") as file:
    json.dump({"fov": 60, "fps": 30, "keys": [{"t": t, "eye": [t / 99, 2, 9], "target": [0, 0, 0], "up": [0, 1, 0]}
                                              for t in (0, 100)]}, file)
command_fly = [stipple, "fly", "cloud.stip", "--path", "flight.json", "-o", "frames/", "--frames", "40", "--size",
               "320x240", "--backend", "cpu", "--reference-every", "1"]
process = subprocess.Popen(command_fly, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
while not os.path.exists("frames/frame-000001.png") and process.poll() is None:
    time.sleep(0.005)
process.send_signal(signal.SIGINT)
out, err = process.communicate()
assert process.returncode == 130, (process.returncode, err)
assert err == "stipple: stopped while at: pictures; nothing was written\n", err
assert not os.path.exists("frames"), os.listdir("frames")

command_render = [stipple, "render", "cloud.stip", "-o", "picture.png", "--accumulate", "4096", "--size", "800x600",
                  "--backend", "cpu"]
process = subprocess.Popen(command_render, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
while processor_seconds(process.pid) < 0.3 and process.poll() is None: # it draws by then
    time.sleep(0.005)
process.send_signal(signal.SIGINT)
out, err = process.communicate()
assert process.returncode == 130, (process.returncode, err)
assert err == "stipple: interrupted; nothing was written\n", err
assert not os.path.exists("picture.png")
os.remove("cloud.stip")
with open("cloud.stip", "w") as file:
    file.write("what was there before")

# interrupts that are ignored at the start stay ignored
def ignore():
    signal.signal(signal.SIGINT, signal.SIG_IGN)

process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=ignore)
process.stderr.readline()
process.send_signal(signal.SIGINT)
out, err = process.communicate()
assert process.returncode == 0, (process.returncode, err)
assert open("cloud.stip", "rb").read() != b"what was there before"
END
