# SPDX-License-Identifier: MIT
"""Decodes operators: splats of progressive sets, coded as differences from the splats they replace.

Written from docs/format.md alone (Operators), using only the standard library; read_store.py uses
it.
"""
import heapq
import math
import struct

BASE, FIRST, SECOND = range(3)
INFINITE = 0xFF00
FLOAT_MOST = struct.unpack("<f", b"\xff\xff\x7f\x7f")[0]
SLOPE = struct.unpack("<f", struct.pack("<f", 0.005))[0]


class Decoder:
    """Bit decoder with adaptive models. A model is a list: the probability of 0 (of 65536), bits seen."""

    def __init__(self, data):
        self.data, self.at, self.range = data, 4, 0xFFFFFFFF
        self.code = int.from_bytes(data[:4].ljust(4, b"\0"), "big")
        self.models = {}

    def split(self, bound):
        if self.code >= bound:
            bit, self.code, self.range = 1, self.code - bound, self.range - bound
        else:
            bit, self.range = 0, bound
        while self.range < 1 << 24:
            self.range <<= 8
            self.code = (self.code << 8 | (self.data[self.at] if self.at < len(self.data) else 0)) & 0xFFFFFFFF
            self.at += 1
        return bit

    def bit(self, *name):
        model = self.models.setdefault(name, [0x8000, 0])
        zero, seen = model
        bit = self.split((self.range >> 12) * max(zero >> 4, 1))
        part = 2 * seen + 3
        model[0] = zero - 2 * zero // part if bit else zero + 2 * (65535 - zero) // part
        model[1] = min(seen + 1, 60)
        return bit

    def plain(self, count):
        value = 0
        for _ in range(count):
            value = value << 1 | self.split(self.range >> 1)
        return value

    def tree(self, name, count):
        node = 1
        for _ in range(count):
            node = node << 1 | self.bit(*name, node)
        return node - (1 << count)

    def number(self, *name):
        bits = self.tree(name + ("class",), 5)
        if bits > 16:
            raise ValueError("a number of more than 16 bits")
        if bits == 0:
            return 0
        negative = self.bit(*name, "sign", bits)
        learnt, value = min(bits - 1, 2), 1
        for _ in range(learnt):
            value = value << 1 | self.bit(*name, "upper", bits, value)
        left = bits - 1 - learnt
        value = value << left | self.plain(left)
        return -value if negative else value

    def difference(self, width, near, *name):
        return (near + self.number(*name)) % (1 << width)

    def ends_well(self):
        return self.at <= len(self.data) and self.code == 0 and not any(self.data[self.at:])


class Splat:
    """Numbers of one splat."""

    def __init__(self):
        self.position, self.normal, self.color = [0, 0, 0], [0, 0], [0, 0, 0]
        self.material = self.coverage = self.shape = self.lowest = self.highest = 0


def area(shape):
    radii = [struct.unpack("<f", struct.pack("<I", (code << 16) + (125 << 23)))[0] for code in (shape & 4095, shape >> 12 & 4095)]
    return radii[0] * radii[1]


def within(value, low, high):
    return low if value <= low else high if value >= high else math.floor(value + 0.5)


def unfold(normal):
    u, v = normal
    z = 127 - abs(u) - abs(v)
    fold = max(-z, 0)
    return [u - fold if u >= 0 else u + fold, v - fold if v >= 0 else v + fold, z]


class Operators:
    """The splats decoded so far, and the parents waiting to be split."""

    def __init__(self, step):
        self.step, self.splats, self.waiting = step, [], []
        self.base, self.parent = 0, None

    def find_parent(self, in_base):
        if in_base:
            self.base, self.parent = self.base + 1, None
        elif (len(self.splats) - self.base) % 2 == 0:
            self.parent = heapq.heappop(self.waiting)[1] if self.waiting else None

    def append(self, splat):
        if splat.lowest:
            heapq.heappush(self.waiting, (-splat.lowest, len(self.splats)))
        self.splats.append(splat)

    def skip(self, columns, count):
        """Adds uncoded splats from columns."""
        names = (("position", 3, "H"), ("normal", 2, "b"), ("material", 1, "B"), ("color", 3, "B"), ("coverage", 1, "B"),
                 ("shape", 1, "I"), ("range", 2, "H"))
        splats, at = [Splat() for _ in range(count)], 0
        for name, each, kind in names:
            values = struct.unpack_from(f"<{each * count}{kind}", columns, at)
            at += struct.calcsize(f"<{each * count}{kind}")
            for i, splat in enumerate(splats):
                own = list(values[each * i:each * i + each])
                if name == "range":
                    splat.lowest, splat.highest = own
                else:
                    setattr(splat, name, own if each > 1 else own[0])
        for splat in splats:
            self.find_parent(self.base == len(self.splats) and splat.highest >= INFINITE)
            self.append(splat)

    def decode(self, data, count):
        """Decodes the columns of the next splats."""
        d, first, self.leaf = Decoder(data), len(self.splats), 0
        for index in range(first, first + count):
            self.find_parent(self.base == index and d.bit("base"))
            if self.base <= index and self.parent is None:
                raise ValueError("a split without a parent")
            self.append(self.decode_splat(d, index))
        if not d.ends_well():
            raise ValueError("an end at the wrong place")
        own = self.splats[first:]
        return b"".join((b"".join(struct.pack("<3H", *s.position) for s in own),
                         b"".join(struct.pack("<2b", *s.normal) for s in own), bytes(s.material for s in own),
                         b"".join(bytes(s.color) for s in own), bytes(s.coverage for s in own),
                         b"".join(struct.pack("<I", s.shape) for s in own),
                         b"".join(struct.pack("<2H", s.lowest, s.highest) for s in own)))

    def decode_splat(self, d, index):
        if self.parent is None:
            kind, parent = BASE, self.splats[index - 1] if index else Splat()
        else:
            kind, parent = FIRST + (index - self.base) % 2, self.splats[self.parent]
        first, s = self.splats[index - 1] if kind == SECOND else None, Splat()
        leaf = d.bit("leaf", 0 if first is None else 1 if first.lowest == 0 else 2)
        self.decode_shape(d, kind, leaf, parent, s)
        s.material = d.difference(8, parent.material, "material", kind)
        s.coverage = d.tree(("coverage", leaf), 8)
        share = min(area(first.shape) / area(s.shape), 16.0) if first else 0.0
        self.decode_position(d, kind, parent, first, share, s)
        self.decode_range(d, kind, leaf, parent, s)

        def change(name):
            differences = [abs(a - b) for a, b in zip(getattr(first, name), getattr(parent, name))] if first else [0]
            return kind + max(differences).bit_length()

        models, near = change("normal"), parent.normal
        if first:
            near = [within(p + (p - f) * share, -127, 127) for p, f in zip(parent.normal, first.normal)]
        s.normal = [(d.difference(8, n, "normal", models) + 128) % 256 - 128 for n in near]
        models, near = change("color"), parent.color
        if first:
            near = [within(p + (p - f) * share, 0, 255) for p, f in zip(parent.color, first.color)]
        s.color[1] = d.difference(8, near[1], "green", models)
        for k in (0, 2):
            s.color[k] = d.difference(8, near[k] + s.color[1] - near[1], "other colors", models)
        return s

    def decode_shape(self, d, kind, leaf, parent, s):
        models = (kind, leaf)
        if leaf and d.bit("same", kind):
            s.shape = self.leaf
            return
        larger = d.difference(12, parent.shape & 4095, "larger", models)
        disk = d.bit("disk", models)
        smaller = larger if disk else (larger - d.difference(12, 0, "stretch", models)) % 4096
        direction = d.difference(8, parent.shape >> 24, "direction", models)
        s.shape = larger | smaller << 12 | direction << 24
        self.leaf = s.shape if leaf else self.leaf

    @staticmethod
    def decode_position(d, kind, parent, first, share, s):
        normal = unfold(parent.normal)
        last = max(range(3), key=lambda k: (abs(normal[k]), -k))
        a, b = (last + 1) % 3, (last + 2) % 3
        for k in (a, b, last):
            near = float(parent.position[k])
            if first:
                near += (parent.position[k] - first.position[k]) * share
            elif kind == FIRST and k == last:
                near -= (float(normal[a] * (s.position[a] - parent.position[a])) +
                         float(normal[b] * (s.position[b] - parent.position[b]))) / normal[k]
            s.position[k] = d.difference(16, within(near, 0, 65535), "across" if k == last else "along", kind)

    def decode_range(self, d, kind, leaf, parent, s):
        if not leaf:
            s.lowest = d.difference(16, parent.lowest, "lowest", kind)
        s.highest = INFINITE
        if kind != BASE:
            distance = self.step * math.sqrt(sum(float(a - b) ** 2 for a, b in zip(s.position, parent.position)))
            level = struct.unpack("<f", struct.pack("<I", parent.lowest << 15))[0] + SLOPE * distance
            bits = struct.unpack("<I", struct.pack("<f", min(level, FLOAT_MOST)))[0]
            s.highest = d.difference(16, min(bits + 0x7FFF >> 15, INFINITE), "highest", kind)
            if not s.lowest <= parent.lowest <= s.highest < INFINITE:
                raise ValueError("levels of a child")
        if (s.lowest == 0) != bool(leaf):
            raise ValueError("an invalid leaf")
