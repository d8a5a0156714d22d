#!/usr/bin/env python3
"""Checks the documents: lines of prose have at most 100 columns, links lead somewhere, named files,
functions, members of structs and tests exist, pages of docs/algorithms have their parts, and
docs/performance.md is short. What comments of the code name must exist, too (check_comments.py).
With `--tool build/release/program/stipple` and `--tool build/release/lab/stipple-lab`, every option in
a command exists as well."""
import argparse
import fnmatch
import functools
import pathlib
import re
import subprocess
import sys

import check_comments

ROOT = pathlib.Path(__file__).resolve().parent.parent  # --root: another folder
COLUMNS = 100
PERFORMANCE_WORDS = 3000
FOLDERS = "base|bench|cmake|docs|examples|fuzz|include|lab|program|scripts|src|stipple|tests".split("|")
CODE_SUFFIXES = (".c", ".h", ".cpp", ".py", ".sh", ".glsl")
FOREIGN = {"_v4.cpp", "gtscompare", "lasreaditemcompressed_v3.cpp"}  # files and programs of others
# Parts of a page of docs/algorithms, which may stand anywhere on it.
PARTS = ["Paper", "Code", "Rule", "Guarantee", "Test"]


def documents():
    return [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]


@functools.cache
def text_of(path):
    return path.read_text()


@functools.cache
def anchors_of(path):
    """The anchors that GitHub gives the headings of a document."""
    anchors = set()
    for heading in re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```", "", text_of(path), flags=re.M | re.S), re.M):
        words = re.sub(r"[^\w\- ]", "", re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).lower())
        anchor, number = words.replace(" ", "-"), 0
        while (f"{anchor}-{number}" if number else anchor) in anchors:
            number += 1
        anchors.add(f"{anchor}-{number}" if number else anchor)
    return anchors


def check_lines(path):
    """Tables, code, comments, images and lines of one link may be longer."""
    code = False
    for number, line in enumerate(text_of(path).splitlines(), 1):
        if line.startswith("```"):
            code = not code
        if code or len(line) <= COLUMNS or line.startswith(("|", "![", "<!--")):
            continue
        if len(line.split()) > 1 and not re.fullmatch(r"\W*\[[^]]*\]\([^)]*\)\W*", line):
            yield f"{number}: {len(line)} columns, at most {COLUMNS}"


def check_links(path):
    text = re.sub(r"^```.*?^```", "", text_of(path), flags=re.M | re.S)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        file = (path.parent / name).resolve() if name else path
        if not file.exists():
            yield f"no file for the link {target}"
        elif anchor and file.suffix == ".md" and anchor not in anchors_of(file):
            yield f"no heading for the link {target}"


@functools.cache
def comment_checker():
    return check_comments.Checker(ROOT)


@functools.cache
def code_files():
    return [p for folder in FOLDERS if (ROOT / folder).is_dir() for p in (ROOT / folder).rglob("*")
            if p.is_file() and p.suffix in (*CODE_SUFFIXES, ".in", ".txt", ".cmake")]


@functools.cache
def identifiers():
    """Every identifier of the code; names of unit tests without their `test_`."""
    names = set()
    for file in code_files():
        names.update(re.findall(r"[A-Za-z_]\w+", file.read_text(errors="replace")))
    return names | {name[5:] for name in names if name.startswith("test_")}


@functools.cache
def unit_tests():
    return {name for file in (ROOT / "tests").rglob("*.c")
            for name in re.findall(r"^void test_(\w+)\(test_state", file.read_text(), re.M)}


def file_exists(name):
    """Does a path, or the end of one, name a file or folder? `*` and capitals stand for anything."""
    pattern = re.sub(r"(?<![A-Za-z])[A-Z]{3,}(?![A-Za-z])", "*", name).rstrip("/")
    ends = comment_checker().ends
    return name in FOREIGN or pattern in ends or "*" in pattern and any(fnmatch.filter(ends, pattern))


def check_names(path):
    text = re.sub(r"^```.*?^```", "", text_of(path), flags=re.M | re.S)
    printed = re.findall(r"^```\w+\n(?:#|//) (\S+)", text_of(path), re.M) # programs in the document
    for name in sorted(set(re.findall(r"`([^`\n]+)`", text))):
        words = name.split()
        looks_like_path = re.fullmatch(r"[\w.*/+-]+", words[0]) and "..." not in words[0] and (
            words[0].split("/")[0] in FOLDERS and "/" in words[0] or words[0].endswith(CODE_SUFFIXES))
        elsewhere = words[0] in printed or words[0].startswith("bench/results")
        if looks_like_path and not elsewhere and not file_exists(words[0]):
            yield f"no file {words[0]}"
        if re.fullmatch(r"(stp|STP)_\w+", name) and name not in identifiers():
            yield f"no code has the name {name}"


def check_members(path):
    """A document may name members of stp_ structs alone: JSON has keys of the form word.word, too."""
    for span in sorted(set(re.findall(r"`(stp_\w+\.\w+)`", text_of(path)))):
        for _, fault in comment_checker().check_members(span, path):
            yield fault


def check_tests(path):
    """Names in paragraphs that begin with **Test.** are those of tests or files."""
    for paragraph in re.findall(r"\*\*Tests?\.\*\*(.*?)(?:\n\n|\Z)", text_of(path), re.S):
        for name in re.findall(r"`(\w+)`", paragraph):
            if name not in unit_tests() and not file_exists(name):
                yield f"no test {name}"


def check_places(path):
    """A row of a table with a file and then functions: the file has these functions. A name `in` a file is there."""
    for name, file in re.findall(r"`(\w+)` in `((?:src|include|program|lab)/[\w/.]+)`", text_of(path)):
        if (ROOT / file).exists() and not re.search(rf"\b{name}\b", text_of(ROOT / file)):
            yield f"{file} has no {name}"
    for file, cell in re.findall(r"\| `(src/[\w/.]+)` \| ((?:`\w+`(?:, )?)+) \|$", text_of(path), re.M):
        code = text_of(ROOT / file) if (ROOT / file).exists() else ""
        for name in re.findall(r"`(\w+)`", cell):
            if not re.search(rf"^[a-z].*\b{name}\(", code, re.M):
                yield f"{file} has no function {name}"


def check_parts(path):
    for part in PARTS:
        if not re.search(rf"\b{part}s?(\.\*\*|:)", text_of(path)):
            yield f"the page has no part {part}"
    sections = re.split(r"^## ", text_of(path), flags=re.M)[1:]
    for section in sections:
        if "**Guarantee.**" in section and not re.search(r"\*\*Tests?\.\*\*|\(`\w+`", section):
            yield f"section {section.splitlines()[0]} has a guarantee but no test"


def check_length(path):
    words = len(re.findall(r"[^\s|]*\w[^\s|]*", text_of(path)))
    if words > PERFORMANCE_WORDS:
        yield f"{words} words, at most {PERFORMANCE_WORDS}"


class Tool:
    """What `NAME COMMAND --help-all` lists; NAME is stipple or stipple-lab."""

    def __init__(self, path):
        self.path = path
        self.name = pathlib.Path(path).name
        self.commands = set(re.findall(r"^  ([a-z-]+)\b", self.help(), re.M))

    @functools.cache
    def help(self, *words):
        done = subprocess.run([self.path, *words, "--help-all"], capture_output=True, text=True)
        return done.stdout + done.stderr

    @functools.cache
    def options(self, *words):
        return set(re.findall(r"(?<![\w-])(--?[a-z][a-z-]*)", self.help(*words)))

    def check(self, path):
        lines = [line for block in re.findall(r"^```sh\n(.*?)^```", text_of(path), re.M | re.S)
                 for line in block.splitlines()]
        spans = [re.sub(r"\s+", " ", span) for span in re.findall(rf"(?<!`)`({self.name} [^`]*)`", text_of(path))]
        for line in lines + spans:
            match = re.match(rf"(?:\w+=\S+ |time |\S*/)*{self.name} ([a-z-]+)(?: ([a-z-]+))?(.*)", line.split(" # ")[0])
            if not match:
                continue
            command, second, rest = match[1], match[2], f"{match[2] or ''}{match[3]}".split("|")[0].split(";")[0]
            if command not in self.commands:
                yield f"no command: {self.name} {command}"
                continue
            known = self.options(command) | (self.options(command, second) if command == "bench" and second else set())
            for option in re.findall(r"(?<=\s)(--[a-z][a-z-]*)", rest):
                if option not in known:
                    yield f"{self.name} {command} has no option {option}"


def main():
    global ROOT
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tool", action="append", default=[],
                        help="a program whose options are compared with the documents; may be repeated")
    parser.add_argument("--root", type=pathlib.Path, default=ROOT, help="the folder of the documents")
    arguments = parser.parse_args()
    ROOT = arguments.root.resolve()
    tools = [Tool(path) for path in arguments.tool]
    bad = []
    for path in documents():
        name = path.relative_to(ROOT)
        checks = [check_lines, check_links]
        if name.name != "CHANGELOG.md" and "notes" not in name.parts: # these tell of the past
            checks += [check_names, check_members, check_places, check_tests]
            checks += [tool.check for tool in tools]
        if name.parent.name == "algorithms" and name.name != "README.md":
            checks.append(check_parts)
        if name.name == "performance.md":
            checks.append(check_length)
        bad += [f"{name}: {fault}" for check in checks for fault in check(path)]
    bad += comment_checker().faults()
    print("\n".join(bad) or "documents ok")
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
