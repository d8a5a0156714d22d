# SPDX-License-Identifier: MIT
"""Runs the unit tests of a changed library, those first that are most likely to fail (scripts/mutate)."""
import os
import re
import resource
import shutil
import signal
import subprocess
import threading
import time

TOO_LONG = f"ended by signal {int(signal.SIGXCPU)}:"
INCLUDE = re.compile(r'^#include ["<]([a-z_0-9/]+)/([a-z_0-9]+)\.h[">]', re.M)
MEMORY_MAX = 6 << 30  # of a process
FILE_MAX = 32 << 30   # tests make sparse files of 10 GB
CPU_MAX = 30          # seconds of a test; none of the unchanged library takes more than a few
QUICK = 0.2           # seconds; these tests are run before the others
TIME_FACTOR, TIME_BASE = 4, 60  # seconds allowed: of the unchanged library, times the factor, plus the base
RESULT = re.compile(r"(ok  |FAIL|skip) (\w+)(?:, ([0-9.]+) s)?")


def limit_process():
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_MAX, CPU_MAX + 5))  # a signal that says so, then the end
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_MAX, MEMORY_MAX))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_MAX, FILE_MAX))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def end_group(process):
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


def run_tests(program, scratch, names, jobs, seconds, stop):
    """Results and seconds by name, and whether time was left. With `stop`, ends at the first failure."""
    if not names:
        return {}, True
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    process = subprocess.Popen([program, "--jobs", str(jobs), *names], stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True, errors="replace",
                               env={**os.environ, "TMPDIR": str(scratch)}, start_new_session=True,
                               preexec_fn=limit_process)
    late = threading.Event()
    timer = threading.Timer(seconds, lambda: (late.set(), end_group(process)))
    timer.start()
    results = {}
    for line in process.stdout:
        match = RESULT.match(line)
        if TOO_LONG in line:
            late.set()
        if match:
            results[match[2]] = match[1].strip(), float(match[3] or 0.0)
            if stop and match[1] == "FAIL":
                break
    timer.cancel()
    end_group(process)
    process.wait()
    process.stdout.close()
    return results, not late.is_set()


def included_folders(text):
    """The folders that a file includes. A public header of a room's name is that room's."""
    return {name if folder == "stipple" else folder for folder, name in INCLUDE.findall(text)}


def read_folders(tree):
    """The folders that the files of each folder include."""
    folders = {}
    for path in [path for floor in ("src", "program", "lab") for path in (tree / floor).rglob("*.[ch]*")]:
        folder = str(path.parent.relative_to(tree)).removeprefix("src/")
        folders.setdefault(folder, set()).update(included_folders(path.read_text()))
    return folders


def reached_rooms(path, folders):
    """The rooms of src that code of a test may call: those that it or its folder's support includes, and so on."""
    texts = [file.read_text() for file in (path, *path.parent.glob("*.h"), *path.parent.glob("support_*.c"))]
    waiting = set().union(*map(included_folders, texts))
    if any("#include <stipple/" in text for text in texts):
        waiting.add("embed")
    reached = set()
    while waiting:
        folder = waiting.pop()
        if folder not in reached:
            reached.add(folder)
            waiting |= folders.get(folder, set())
    return {folder.split("/")[0] for folder in reached}


class UnitTests:
    """The unit tests that pass with the unchanged library, and their seconds."""

    def __init__(self, tree, program, scratch, jobs):
        self.program, self.scratch, self.jobs = program, scratch, jobs
        self.rooms, self.reached = {}, {}
        folders = read_folders(tree)
        for path in sorted((tree / "tests").glob("*/test_*.c")):
            reached = reached_rooms(path, folders)
            for name in re.findall(r"^void test_(\w+)\(test_state\* test\)", path.read_text(), re.M):
                self.rooms[name] = path.parent.name
                self.reached[name] = reached
        start = time.monotonic()
        results, _ = self.run(list(self.rooms), 3600, False)
        self.seconds = time.monotonic() - start
        self.failed = [name for name, result in results.items() if result[0] == "FAIL"]
        self.times = {name: seconds for name, (result, seconds) in results.items() if result == "ok"}

    def run(self, names, seconds, stop):
        return run_tests(self.program, self.scratch, names, self.jobs, seconds, stop)

    def failure(self, room):
        """The first test that fails with a change of this room, 'time', or None."""
        own = [name for name in self.times if self.rooms[name] == room]
        others = [name for name in self.times if self.rooms[name] != room and room in self.reached[name]]
        batches = [[name for name in names if (self.times[name] > QUICK) == slow]
                   for names in (own, others) for slow in (False, True)]
        for names in batches:
            results, in_time = self.run(names, TIME_FACTOR * self.seconds + TIME_BASE, True)
            if not in_time:
                return "time"
            failed = [name for name, result in results.items() if result[0] == "FAIL"]
            if failed:
                return failed[0]
            if any(name not in results for name in names):
                return "end of the test program"
        return None
