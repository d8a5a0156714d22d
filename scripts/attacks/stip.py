# SPDX-License-Identifier: MIT
"""Structure-aware mutations of .stip files (docs/format.md), with corrected checksums."""
import struct
import zlib

PACKED, PAGE, PIECE = 2, 16384, 65536
BLOCKS, PAGES = 14, 21
NUMBERS = (0, 1, 2, 3, 0x7F, 0x80, 0xFF, 0x100, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF)
FLOATS = (0.0, -0.0, -1.0, 1e-45, 1e-38, 1e30, -3e38, 3e38, float("inf"), float("-inf"), float("nan"))


def align(offset):
    return -(-offset // 64) * 64


def deflate(content):
    """A page or chunk as stored: compressed if that is smaller."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    stored = packer.compress(content) + packer.flush()
    stored += bytes(max(0, len(content) // 32 - len(stored)))
    return stored if len(stored) < len(content) else content


def inflate(stored, length):
    return stored if len(stored) == length else zlib.decompressobj(-15).decompress(stored, length)


class Section:
    def __init__(self, data, entry):
        self.kind, self.flags, offset, size, self.count, self.record_size, _ = struct.unpack_from("<IIQQQII", data, entry)
        stored = data[offset:offset + size]
        if self.flags & PACKED:
            length, each = self.count * self.record_size, PIECE // self.record_size * self.record_size
            at = 8 * -(-length // each)
            content = b""
            for i, (piece, _) in enumerate(struct.iter_unpack("<2I", stored[:at])):
                content += inflate(stored[at:at + piece], min(each, length - i * each))
                at += piece
            stored = content
        self.content = bytearray(stored)

    def store(self):
        """Bytes in the file, and the checksum of the section."""
        content = bytes(self.content)
        if not self.flags & PACKED or self.record_size == 0 or self.record_size > PIECE or not content:
            return content, zlib.crc32(content)
        each = PIECE // self.record_size * self.record_size
        pages = [deflate(content[i:i + each]) for i in range(0, len(content), each)]
        table = b"".join(struct.pack("<2I", len(page), zlib.crc32(page)) for page in pages)
        return table + b"".join(pages), zlib.crc32(table)


class Stip:
    """A file in parts: header, sections in order, bytes of blocks."""

    def __init__(self, data):
        self.header = bytearray(data[:128])
        count, = struct.unpack_from("<I", data, 32)
        self.data_offset, = struct.unpack_from("<Q", data, 24)
        self.sections = [Section(data, 128 + 40 * i) for i in range(count)]
        self.blocks = []
        table = self.find(BLOCKS)
        for i in range(table.count if table else 0):
            offset, size = struct.unpack_from("<2Q", table.content, i * table.record_size + 16)
            self.blocks.append(bytearray(data[offset:offset + size]))

    def find(self, kind):
        return next((section for section in self.sections if section.kind == kind), None)

    def lay_blocks(self, data_offset, keep):
        """The data; updates the offsets and checksums of blocks, except the fields in `keep`."""
        table, data, at = self.find(BLOCKS), bytearray(), data_offset
        for i, block in enumerate(self.blocks):
            record = i * table.record_size
            if record + 40 > len(table.content):
                break
            at = align(at)
            data += bytes(at - data_offset - len(data)) + block
            encoding, = struct.unpack_from("<I", table.content, record + 36)
            kind, = struct.unpack_from("<I", table.content, record)
            crc = chunk_checksums(block) if kind == 4 and encoding in (1, 2) else zlib.crc32(block)
            for field, layout, value in (("crc", "<I", crc), ("offset", "<Q", at), ("size", "<Q", len(block))):
                if (i, field) not in keep:
                    struct.pack_into(layout, table.content, record + {"crc": 12, "offset": 16, "size": 24}[field], value)
            at += len(block)
        return data

    def bytes(self, keep=()):
        """The file with correct offsets, sizes and checksums."""
        table = self.find(BLOCKS)
        guess = self.data_offset
        for _ in range(4):  # the size of a packed table of blocks depends on the offsets in it
            data = self.lay_blocks(guess, keep) if table else bytearray()
            found = self.lay_directory()
            if len(found) == guess:
                break
            guess = len(found)
        directory = found
        struct.pack_into("<2Q", directory, 16, len(directory) + len(data), len(directory))
        struct.pack_into("<I", directory, 124, zlib.crc32(directory[:124]))
        return bytes(directory + data)

    def lay_directory(self):
        stored, pages = [], bytearray()
        for section in self.sections:
            stored.append(section.store() if section.kind != PAGES else None)
            if section.kind != PAGES and not section.flags & PACKED:
                content = stored[-1][0]
                for i in range(0, len(content), PAGE):
                    pages += struct.pack("<I", zlib.crc32(content[i:i + PAGE]))
        out, table, at = bytearray(), bytearray(), 128 + 40 * len(self.sections)
        for section, found in zip(self.sections, stored):
            if section.kind == PAGES:
                section.content, section.count = pages, len(pages) // 4
                found = bytes(pages), zlib.crc32(pages)
            content, crc = found
            begin = align(at)
            out += bytes(begin - at) + content
            table += struct.pack("<IIQQQII", section.kind, section.flags, begin, len(content), section.count,
                                 section.record_size, crc)
            at = begin + len(content)
        out += bytes(align(at) - at)
        struct.pack_into("<2I", self.header, 32, len(self.sections), zlib.crc32(table))
        return bytearray(self.header + table + out)


def chunk_checksums(block):
    """Updates the chunk checksums in an octave's table, if it has one. @return the block's checksum"""
    for count in range(2, min(64, len(block) // 8 + 1)):
        sizes = [struct.unpack_from("<I", block, 8 * i)[0] for i in range(count)]
        if 8 * count + sum(sizes) == len(block):
            at = 8 * count
            for i, size in enumerate(sizes):
                struct.pack_into("<I", block, 8 * i + 4, zlib.crc32(block[at:at + size]))
                at += size
            return zlib.crc32(block[:8 * count])
    return zlib.crc32(block)


def spoil_number(random, content, at):
    """Replaces a number: u32, u64, f32, f64, a byte, or one near the old value."""
    layout, value = random.choice((("<I", random.choice(NUMBERS)), ("<Q", random.choice(NUMBERS) << random.choice((0, 31, 32))),
                                   ("<f", random.choice(FLOATS)), ("<d", random.choice(FLOATS) * random.choice((1, 1e270))),
                                   ("<B", random.randrange(256)), ("near", 0), ("<B", None)))
    if layout == "near" and at + 4 <= len(content):
        old, = struct.unpack_from("<I", content, at)
        struct.pack_into("<I", content, at, (old + random.choice((-1, 1, 2, -2, 64, 1 << 16))) & 0xFFFFFFFF)
    elif layout == "<B" and value is None:
        content[at] ^= 1 << random.randrange(8)
    elif layout != "near" and at + struct.calcsize(layout) <= len(content):
        struct.pack_into(layout, content, at, value)


def spoil_section(random, file):
    section = random.choice([s for s in file.sections if s.content and s.kind != PAGES])
    step = 4 if section.record_size % 4 == 0 else 1
    for _ in range(random.choice((1, 1, 1, 2, 8))):
        spoil_number(random, section.content, random.randrange(0, len(section.content), step))
    if random.random() < 0.1:
        section.flags ^= PACKED


def spoil_shape(random, file):
    """Truncates, extends, drops or moves sections, or changes their record size."""
    section = random.choice(file.sections)
    what = random.randrange(6)
    if what == 0 and section.count:
        section.count = random.randrange(section.count)
        del section.content[section.count * section.record_size:]
    elif what == 1 and section.content and section.record_size:
        more = random.choice((1, 2, 1000))
        section.content += section.content[-section.record_size:] * more
        section.count += more
    elif what == 2:
        file.sections.remove(section)
    elif what == 3:
        file.sections.insert(random.randrange(len(file.sections)), section)
    elif what == 4:
        section.kind = random.choice((section.kind ^ 1, random.randrange(40), 0x80000001))
    else:
        section.record_size = random.choice((0, 1, 4, 40, 65535, 65537, 0xFFFFFFFF))


def spoil_block(random, file):
    if not file.blocks:
        return ()
    index = random.randrange(len(file.blocks))
    block = file.blocks[index]
    if block and random.random() < 0.8:
        for _ in range(random.choice((1, 1, 2, 16))):
            spoil_number(random, block, random.randrange(len(block)))
        return ()
    if random.random() < 0.5:
        del block[random.randrange(len(block) + 1):]
        return ()
    return ((index, random.choice(("offset", "size", "crc"))),)


def spoil_header(random, data):
    data = bytearray(data)
    spoil_number(random, data, random.randrange(8, 124))
    struct.pack_into("<I", data, 124, zlib.crc32(data[:124]))
    return bytes(data)


def mutate(random, data):
    """Mutates a .stip file: most have a single fault."""
    file = Stip(data)
    keep = ()
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        kind = random.random()
        if kind < 0.45:
            spoil_section(random, file)
        elif kind < 0.6:
            spoil_shape(random, file)
        else:
            keep += tuple(spoil_block(random, file))
    made = file.bytes(keep)
    return spoil_header(random, made) if random.random() < 0.05 else made
