# SPDX-License-Identifier: MIT
"""A clumsy host of the library, and calls of the system that fail: tests/attack, built with the tests."""
import pathlib

KINDS = ("read", "write", "short", "open", "map", "sync", "rename", "size", "folder", "remove", "close")
ERRORS = ("5", "28", "4", "24", "12")  # EIO, ENOSPC, EINTR, EMFILE, ENOMEM
COMMANDS = (["build", "MODEL", "-o", "OUT", "-q"], ["build", "MODEL", "-o", "OUT", "-q", "--method", "psp,stochastic"],
            ["build", "CLOUD", "-o", "OUT", "-q", "--method", "stochastic", "--memory", "64M"], ["check", "SCENE"],
            ["info", "SCENE", "--json"], ["render", "SCENE", "-o", "PICTURE", "--size", "64x48"])


def find(campaign, name):
    """A file built beside the executable; None if it is not there."""
    path = pathlib.Path(campaign.options.stipple).parent.parent / "tests" / name
    return path if path.exists() else None


def clumsy_host(random, campaign, run, folder):
    """Calls the library with missing pointers, wrong numbers and orders, and failing allocators and readers."""
    host = find(campaign, "attack_host")
    if host is not None:
        command = [str(host), random.choice(("arguments", "arguments", "allocator", "allocator", "reader", "threads")),
                   str(campaign.scene), str(random.randrange(1, 1 << 30))]
        yield command, run(command, 1 << 20, folder)


def failing_calls(random, campaign, run, folder):
    """One call of the system fails, or all from one on: an output is as before, or whole."""
    library = find(campaign, "attack_io.so")
    if library is None:
        return
    output, picture = folder / "a.stip", folder / "a.png"
    output.write_bytes(campaign.scene.read_bytes())
    values = {"MODEL": str(campaign.model), "CLOUD": str(campaign.cloud), "SCENE": str(campaign.scene), "OUT": str(output),
              "PICTURE": str(picture)}
    command = [campaign.options.stipple, *(values.get(word, word) for word in random.choice(COMMANDS))]
    kind, nth = random.choice(KINDS), random.choice((1, 2, 3, random.randrange(1, 8), random.randrange(1, 30)))
    environment = {"LD_PRELOAD": str(library), "STP_IO_KIND": kind, "STP_IO_NTH": str(nth), "STP_IO_ERROR": random.choice(ERRORS),
                   **({"STP_IO_ALL": "1"} if random.random() < 0.3 else {}), "XDG_CACHE_HOME": str(folder / "cache")}
    result = run(command, 1 << 20, folder, environment)
    shown = [f"{name}={value}" for name, value in environment.items()] + command
    yield shown, result
    left = [path.name for path in folder.iterdir() if path.name not in ("a.stip", "a.png", "a.stip.work", "cache")]
    if left and not result["fault"] and kind != "remove" and "STP_IO_ALL" not in environment:
        yield shown, {**result, "fault": f"leaves {left}"}
    check = [campaign.options.stipple, "check", str(output)]
    checked = run(check)
    if not checked["fault"] and checked["code"] != 0:
        checked["fault"] = f"left an incomplete file: {' '.join(shown)}"
    yield check, checked


HOSTS = (clumsy_host, failing_calls)
