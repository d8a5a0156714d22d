"""Checks the comments of the code, for check_docs.py: a file, a folder, a section of a document, a member of a struct
and an stp_ name that a comment mentions exist."""
import collections
import functools
import re

FOLDERS = ["src", "program", "lab", "include", "tests", "fuzz", "scripts"]
HASH_SUFFIXES = (".py", ".sh", "")  # comments begin with #; programs without a suffix are scripts
SUFFIXES = (".c", ".h", ".cpp", ".glsl", *HASH_SUFFIXES)
NAMED_SUFFIXES = "c|h|cpp|glsl|py|sh|md"
FILE_NAME = re.compile(rf"(?<![\w./<*}}-])((?:[\w-]+/)*[\w-]+(?:\.[\w-]+)*\.(?:{NAMED_SUFFIXES}))(?![\w*/-])")
PATH = re.compile(rf"(?<![\w./$*}}-])((?:{'|'.join(FOLDERS)}|docs|bench|examples)/[\w./*-]*[\w*])")
SECTION = re.compile(r'([\w/-]+\.md)\)?(?:, section |, )("[^"]+"|\d+\b(?!-)|[A-Z][\w ,-]*)')
MEMBER = re.compile(r"(?<![\w./>-])([a-z]\w+)\.([a-z]\w*)\b(?!\.\w|/)")
NAME = re.compile(r"(?<![\w/$.-])((?:stp|STP)_\w*[A-Za-z0-9])(?![\w*]|\.\.\.|\.(?:c|h)\b)")
FOREIGN = {"lasreaditemcompressed_v3.cpp"}  # files of others
STRINGS = re.compile(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'')


def code_files(root):
    paths = [path for folder in FOLDERS for path in sorted((root / folder).rglob("*"))]
    return [path for path in paths if (path.suffix in SUFFIXES or path.name == "CMakeLists.txt") and path.is_file()
            and "golden" not in path.parts]


class Comments:
    """The comments of one file, as lines of text with their numbers; lines that follow each other are one block."""

    def __init__(self, path, text):
        self.lines = []
        hashed = path.suffix in HASH_SUFFIXES
        mark = "#" if hashed else "//"
        quoted = False  # inside a docstring
        for number, line in enumerate(text.splitlines(), 1):
            if hashed and line.count('"""') == 1 and (quoted or line.lstrip().startswith('"""')):
                quoted = not quoted
                self.lines.append((number, line))
            elif quoted or hashed and line.lstrip().startswith('"""'):
                self.lines.append((number, line))
            elif mark in line:
                at = line.find(mark)
                if '"' in line[:at] or "'" in line[:at]:
                    at = STRINGS.sub(lambda match: " " * len(match[0]), line).find(mark)
                if at >= 0 and (not hashed or at == 0 or line[at - 1] == " "):
                    self.lines.append((number, line[at + len(mark):].lstrip("/!<# ")))

    def blocks(self):
        """Each block as its text and the number of the line at each position."""
        block, last = [], -1
        for number, line in self.lines:
            if block and number != last + 1:
                yield block
                block = []
            block.append((number, line))
            last = number
        if block:
            yield block


class Checker:
    def __init__(self, root):
        self.root = root
        self.texts = {path: path.read_text(errors="replace") for path in code_files(root)}
        self.find_files()
        self.find_names()

    def find_files(self):
        """Every end of a path of the project, so that a comment may leave out the first folders."""
        self.ends = set()
        for top in [*FOLDERS, "docs", "bench", "examples", "cmake", "."]:
            for path in (self.root / top).glob("*" if top == "." else "**/*"):
                parts = path.relative_to(self.root).parts
                self.ends.update("/".join(parts[i:]) for i in range(len(parts)))

    def find_names(self):
        """The stp_ names of the code and of the build, and the bodies of structs, all without comments."""
        self.names, self.bodies = set(), collections.defaultdict(list)
        for path, text in self.texts.items():
            if path.suffix in (".c", ".h", ".cpp", ".glsl"):
                code = re.sub(r"//.*", "", text)
                self.names.update(re.findall(r"\b(?:stp|STP)_\w+", code))
                for match in re.finditer(r"^typedef (?:struct|union)[^{;]*\{(.*?)^\} (\w+);", code, re.M | re.S):
                    self.bodies[match[2], path if path.suffix == ".c" else None].append(match[1])
            elif path.suffix == ".txt":
                self.names.update(re.findall(r"\bstp_\w+", text))

    @functools.cache
    def members(self, name, path):
        """Of a struct that a header or the file itself defines; None if neither does."""
        bodies = self.bodies.get((name, path), []) + self.bodies.get((name, None), [])
        return set(re.findall(r"\w+", " ".join(bodies))) if bodies else None

    @functools.cache
    def headings(self, document):
        path = next((p for p in (self.root / document, self.root / "docs" / document,
                                 self.root / "docs" / "algorithms" / document) if p.is_file()), None)
        if not path:
            return None
        return [re.sub(r"[`*]|\(.*\)", "", heading).strip().lower()
                for heading in re.findall(r"^#+ (.*)$", path.read_text(), re.M)]

    def check_files(self, text, _):
        for match in FILE_NAME.finditer(text):
            name = match[1]
            if name in self.ends or name in FOREIGN or re.search(r"(?<![A-Za-z])[A-Z]{3,}(?![A-Za-z])", name):
                continue
            yield match.start(), f"no file {name}"

    def check_paths(self, text, _):
        """Paths from the top: of folders, and of files of any kind; `*` stands for anything."""
        for match in PATH.finditer(text):
            name = match[1]
            found = any(self.root.glob(name)) if "*" in name else name in self.ends
            if not found and not FILE_NAME.fullmatch(name):
                yield match.start(), f"nothing is at {name}"

    def check_sections(self, text, _):
        for match in SECTION.finditer(text):
            headings, section = self.headings(match[1]), match[2].strip('" ').lower()
            if headings is not None and not any(section == h or section.startswith(h) for h in headings):
                yield match.start(), f"{match[1]} has no section {match[2]}"

    def check_members(self, text, path):
        for match in MEMBER.finditer(text):
            name, member = match[1], match[2]
            members = self.members(name, path) if member not in NAMED_SUFFIXES.split("|") else None
            if members is not None and member not in members:
                yield match.start(), f"{name} has no member {member}"

    def check_names(self, text, _):
        for match in NAME.finditer(text):
            if match[1] not in self.names and not re.match(r"stp_\w*_[A-Z]+$", match[1]):
                yield match.start(), f"no code has the name {match[1]}"

    def faults(self):
        checks = [self.check_files, self.check_paths, self.check_sections, self.check_members, self.check_names]
        for path, text in self.texts.items():
            for block in Comments(path, text).blocks():
                joined = "\n".join(line for _, line in block)
                flat = joined.replace("\n", " ")
                for check in checks:
                    for at, fault in check(flat, path):
                        yield f"{path.relative_to(self.root)}:{block[joined.count(chr(10), 0, at)][0]}: {fault}"
