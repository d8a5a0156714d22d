# SPDX-License-Identifier: MIT
"""Structure-aware mutations of models, pictures, flights and views."""
import json
import re
import struct
import zlib

NUMBERS = (0, 1, -1, 2, 255, 256, 65535, 65536, 2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**53, -2**31, 2**63, 1e-320, 1e-45, 1e30,
           3.4e38, 1e39, 1e300, -1e300, 0.5)
WORDS = ("", "..", "../x", "/etc/hostname", "\x1b[2J", "\n", "a" * 5000, "\u202e", "\ud7ff", "nan", "inf", "-nan", "1e999", "%s%n",
         "x.png", "file:///etc/hostname", "data:,", "data:application/octet-stream;base64,AAAA", ".", "*1", "null")


def spoil_bytes(random, data):
    """Mutates bits, bytes and runs of bytes."""
    data = bytearray(data)
    for _ in range(random.choice((1, 1, 2, 8, 64))):
        if not data:
            break
        at, what = random.randrange(len(data)), random.randrange(6)
        run = random.randrange(1, 1 + min(256, len(data) - at))
        if what == 0:
            data[at] ^= 1 << random.randrange(8)
        elif what == 1:
            data[at] = random.randrange(256)
        elif what == 2:
            del data[at:at + run]
        elif what == 3:
            data[at:at] = data[at:at + run] * random.choice((1, 1, 16))
        elif what == 4:
            del data[at:]
        else:
            data[at:at + 4] = struct.pack("<I", random.choice((0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)))
    return bytes(data)


def places_of(value, places=None):
    """All containers of a JSON value with their keys."""
    places = [] if places is None else places
    keys = value.keys() if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        places.append((value, key))
        places_of(value[key], places)
    return places


def spoil_json(random, value):
    """Replaces, removes, duplicates or changes the type of numbers, texts, keys and members."""
    for _ in range(random.choice((1, 1, 1, 2, 6))):
        places = places_of(value)
        if not places:
            break
        holder, key = random.choice(places)
        what, old = random.random(), holder[key]
        if what < 0.15:
            del holder[key]
        elif what < 0.25 and isinstance(holder, list):
            holder.extend([old] * random.choice((1, 7, 500)))
        elif what < 0.35:
            other, name = random.choice(places)
            holder[key] = json.loads(json.dumps(other.get(name) if isinstance(other, dict) else other[name] if name < len(other) else 0))
        elif what < 0.42:
            holder[key] = random.choice(([], {}, None, True, "", 0))
        elif isinstance(old, bool) or not isinstance(old, (int, float)):
            holder[key] = random.choice(WORDS)
        else:
            holder[key] = random.choice((random.choice(NUMBERS), old + 1, old - 1, -old, old * 1000))
    return value


def write_json(random, value):
    text = json.dumps(value)
    if random.random() < 0.1:  # JSON that json.dumps cannot write
        at = random.randrange(len(text))
        text = text[:at] + random.choice(("1e999", "\\u0000", "[" * 5000, "NaN", ",", "}", "\x00")) + text[at:]
    return text.encode("utf-8", "surrogatepass")


def mutate_json(random, data):
    return write_json(random, spoil_json(random, json.loads(data)))


def mutate_glb(random, data):
    """Mutates the JSON of a GLB or its binary chunk; lengths are correct, or one is not."""
    length, = struct.unpack_from("<I", data, 12)
    text, rest = data[20:20 + length], data[20 + length:]
    if random.random() < 0.8:
        text = mutate_json(random, text)
    else:
        rest = rest[:8] + spoil_bytes(random, rest[8:])
    text += b" " * (-len(text) % 4)
    if len(rest) >= 8:
        rest = struct.pack("<I", len(rest) - 8) + rest[4:]
    made = bytearray(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest)
    if random.random() < 0.1:
        struct.pack_into("<I", made, random.choice((4, 8, 12, 16)), random.choice((0, 3, len(made) + 4, 0xFFFFFFFF)))
    return bytes(made)


def mutate_text(random, data):
    """Mutates numbers, words and lines of a text format."""
    lines = data.decode("latin-1").split("\n")
    for _ in range(random.choice((1, 1, 2, 5))):
        at = random.randrange(len(lines))
        what = random.randrange(7)
        if what <= 2:
            words = re.split(r"(\s+|/)", lines[at])
            which = random.randrange(len(words))
            words[which] = str(random.choice(NUMBERS)) if random.random() < 0.7 else random.choice(WORDS)
            lines[at] = "".join(words)
        elif what == 3:
            del lines[at:at + random.choice((1, 1, 10))]
        elif what == 4:
            lines[at:at] = [lines[at]] * random.choice((1, 1, 1000))
        elif what == 5:
            lines[at] += random.choice((" \\", " " + " ".join(["1"] * 3000), "\r", "\0", " 1 2 3 4 5"))
        else:
            other = random.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        lines = lines or [""]
    return "\n".join(lines).encode("utf-8", "surrogatepass")


def mutate_mixed(random, data):
    """Mutates a text header followed by binary data (PLY, binary STL), or a text file."""
    end = data.find(b"end_header\n")
    if end < 0 or random.random() < 0.3:
        return mutate_text(random, data) if b"\0" not in data[:4096] else spoil_bytes(random, data)
    head = mutate_text(random, data[:end]) if random.random() < 0.6 else data[:end]
    return head + data[end:] if random.random() < 0.6 else head + data[end:end + 11] + spoil_bytes(random, data[end + 11:])


def mutate_png(random, data):
    """Mutates chunks of a PNG and corrects the checksums."""
    chunks, at = [], 8
    while at + 12 <= len(data):
        size, = struct.unpack_from(">I", data, at)
        chunks.append([data[at + 4:at + 8], bytearray(data[at + 8:at + 8 + size])])
        at += 12 + size
    for _ in range(random.choice((1, 1, 2))):
        chunk = random.choice(chunks)
        what = random.randrange(5)
        if what <= 1 and chunk[1]:
            where = random.randrange(len(chunk[1]))
            chunk[1][where] = random.choice((0, 1, 3, 8, 16, 0x7F, 0x80, 0xFF, random.randrange(256)))
        elif what == 2:
            chunks.remove(chunk)
        elif what == 3:
            chunks.insert(random.randrange(len(chunks)), [chunk[0], bytearray(chunk[1])])
        else:
            chunk[0] = random.choice((b"IDAT", b"PLTE", b"tRNS", b"IEND", b"gAMA", b"iCCP", b"zTXt", b"aaAa"))
        chunks = chunks or [chunk]
    return data[:8] + b"".join(struct.pack(">I", len(c)) + k + c + struct.pack(">I", zlib.crc32(k + bytes(c))) for k, c in chunks)


MUTATE = {"glb": mutate_glb, "gltf": mutate_json, "json": mutate_json, "obj": mutate_text, "mtl": mutate_text, "ply": mutate_mixed,
          "stl": mutate_mixed, "png": mutate_png}


def mutate(random, kind, data):
    """Mutates a file of a kind (its extension): mostly by structure, else by bytes."""
    if kind in MUTATE and random.random() < 0.85:
        try:
            return MUTATE[kind](random, data)
        except (ValueError, RecursionError, struct.error, IndexError, OverflowError, TypeError):
            pass  # it is no longer a valid file of its kind
    return spoil_bytes(random, data)
