# SPDX-License-Identifier: MIT
"""Races: changes to a file, a work folder or a process while the program uses it."""
import os
import pathlib
import shutil
import signal
import subprocess
import threading
import time

FLIGHT = str(pathlib.Path(__file__).resolve().parent.parent.parent / "lab" / "scenes" / "flights" / "city-small.json")


def overwritten_while_drawn(random, campaign, run, folder):
    """Overwrites a mapped file in place, with the same size."""
    victim = folder / "a.stip"
    shutil.copy(campaign.scene, victim)
    size = victim.stat().st_size
    done = threading.Event()

    def overwrite():
        time.sleep(random.uniform(0.03, 0.3))  # the file is open by then
        while not done.is_set():
            with open(victim, "r+b") as file:
                file.seek(random.randrange(size))
                file.write(random.randbytes(min(random.choice((1, 4, 100, 4096)), size - file.tell())))
            time.sleep(0.001)

    writer = threading.Thread(target=overwrite)
    command = [campaign.options.stipple, "fly", str(victim), "--path", FLIGHT, "--frames", "150", "--size", "320x240",
               "--backend", "cpu"] + (["--reference"] if random.random() < 0.5 else [])
    writer.start()
    try:
        result = run(command, size)
    finally:
        done.set()
        writer.join()
    yield command, result


def damaged_work_folder(random, campaign, run, folder):
    """Damages the work folder of a running build: this build or the next gives the right bytes."""
    model, output, right = "scene:city-small,scale=0.05", folder / "a.stip", folder / "right.stip"
    stipple = campaign.options.stipple
    subprocess.run([stipple, "build", model, "-o", str(right), "-q"], check=True, timeout=600)

    def damage():
        time.sleep(random.uniform(0.03, 0.5))
        for segment in pathlib.Path(str(output) + ".work").glob("segment-*"):
            try:
                size = os.path.getsize(segment)
                if random.random() < 0.3:
                    os.truncate(segment, random.randrange(size + 1))
                    continue
                with open(segment, "r+b") as file:
                    for _ in range(random.choice((1, 8, 100))):
                        file.seek(random.randrange(max(size, 1)))
                        file.write(random.randbytes(random.choice((1, 1, 64, 4096))))
            except OSError:
                pass

    command = [stipple, "build", model, "-o", str(output), "-q"]
    writer = threading.Thread(target=damage)
    writer.start()
    result = run(command, 1 << 20)
    writer.join()
    if result["fault"] is None and result["code"] != 0:
        result = run(command, 1 << 20)
    if result["fault"] is None and (result["code"] != 0 or output.read_bytes() != right.read_bytes()):
        result["fault"] = "bytes differ from an undisturbed build"
    yield command, result


def killed_builds(random, campaign, run, folder):
    """An interrupted or killed build leaves the previous file and can be resumed."""
    stipple, output = campaign.options.stipple, folder / "a.stip"
    output.write_bytes(campaign.scene.read_bytes())
    previous = output.read_bytes()
    command = [stipple, "build", "scene:city-small,scale=0.05", "-o", str(output), "--fresh", "-q"]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    time.sleep(random.uniform(0.0, 0.7))
    process.send_signal(random.choice((signal.SIGKILL, signal.SIGTERM, signal.SIGINT)))
    process.wait(timeout=600)
    left = output.read_bytes()
    check = run([stipple, "check", str(output)])
    if check["code"] != 0 and not check["fault"]:
        check["fault"] = "a killed build left an incomplete file"
    yield [stipple, "check", str(output)], check
    again = [word for word in command if word != "--fresh"]
    result = run(again)
    whole = output.read_bytes()
    if not result["fault"] and (result["code"] != 0 or left not in (previous, whole)):
        result["fault"] = "the old and the new file are both missing, or no build can resume"
    yield again, result


def killed_builds_of_clouds(random, campaign, run, folder):
    """A killed build of a cloud by any methods can be resumed, to the same bytes."""
    stipple, output, right, cloud = campaign.options.stipple, folder / "a.stip", folder / "right.stip", folder / "a.xyz"
    cloud.write_text("".join(f"{random.gauss(0, 9):.3f} {random.gauss(0, 9):.3f} {random.random():.3f}\n" for _ in range(60_000)))
    methods = ",".join(random.sample(("blue", "spt", "psp", "stochastic"), random.randrange(1, 5)))
    command = [stipple, "build", str(cloud), "--method", methods, "-q", *random.choice(((), ("--memory", "64M")))]
    whole = run([*command, "-o", str(right)])
    yield [*command, "-o", str(right)], whole
    command += ["-o", str(output)]
    for _ in range(3):
        process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        time.sleep(random.uniform(0.0, whole["seconds"]))
        process.send_signal(random.choice((signal.SIGKILL, signal.SIGKILL, signal.SIGTERM)))
        process.wait(timeout=600)
    result = run(command)
    if not result["fault"] and not whole["fault"] and (result["code"] != 0 or output.read_bytes() != right.read_bytes()):
        result["fault"] = "bytes differ from an undisturbed build"
    yield command, result


def two_builds_of_one_file(random, campaign, run, folder):
    """Two builds write the same file: one after the other, or one refuses; the file is complete."""
    command = [campaign.options.stipple, "build", "scene:city-small,scale=0.05", "-o", str(folder / "a.stip"), "-q"]
    other = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    time.sleep(random.uniform(0.0, 0.3))
    yield command, run(command)
    try:
        code = other.wait(timeout=120)
    except subprocess.TimeoutExpired:
        other.kill()
        code = other.wait()
    if code not in (0, 1):
        yield command, {"code": code, "seconds": 0.0, "megabytes": 0.0, "err": b"", "fault": f"ends with {code}"}
    check = [campaign.options.stipple, "check", str(folder / "a.stip")]
    result = run(check)
    if result["code"] != 0 and not result["fault"]:
        result["fault"] = "two builds left an incomplete file"
    yield check, result


RACES = (overwritten_while_drawn, damaged_work_folder, killed_builds, killed_builds_of_clouds, two_builds_of_one_file)
