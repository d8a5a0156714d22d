#!/usr/bin/env python3
"""Draws the house, docs/images/house.svg: a band for each floor (library, program, laboratory), a box for each room, as
tall as its code is long, and an arrow for each necessary include. An include is necessary unless a chain of other
arrows implies it. Rooms and floors are those of scripts/check_rooms.py. Lengths and numbers of includes are rounded, so
that the picture changes only where the house does. `--check` compares the picture instead of writing it."""
import argparse
import collections
import itertools
import math
import re
import sys

import check_rooms

PICTURE = check_rooms.ROOT / "docs" / "images" / "house.svg"
WIDTH, MARGIN, BAND_TITLE, BAND_GAP = 1000, 18, 44, 46
ROOM_WIDTH, ROOM_MIN, ROOM_GAP, LANE, LINES_PER_PIXEL = 104, 36, 12, 8, 125
FLOORS = [  # from the top: name, folder, how it is described, colours of band and room
    ("laboratory", "lab", "lab/, the executable stipple-lab", "#f6efe3", "#fffaf0", "#a8813c"),
    ("program", "program", "program/, the executable stipple", "#e6f0e9", "#f6fcf8", "#4b8a63"),
    ("library", "src", "src/, libstipple", "#e6edf5", "#f6f9fd", "#44709d"),
]
INTERFACES = {"stipple/order.h": "order"}  # a room whose interface is a public header


def rounded(count):
    """The nearest of 1, 1.5, 2, 3, 4, 6, 8, 10, 15, ..., so that small changes do not show."""
    power = 10 ** (len(str(count)) - 1)
    return min((step * power for step in (1, 1.5, 2, 3, 4, 6, 8, 10)), key=lambda r: max(r / count, count / r))


class Room:
    def __init__(self, name):
        self.name = name
        self.label = name.split("/", 1)[1] if "/" in name else "main.c" if name in ("program", "lab") else name
        self.lines = 0
        self.folders = set()
        self.column = 0
        self.y = self.height = 0.0


class Lane(Room):
    """The place where an arrow passes a column on its way to a farther one."""


def read_house():
    """Rooms by name, and how many includes lead from one to another."""
    rooms, includes = {}, collections.Counter()
    for path in check_rooms.files("src", "program", "lab"):
        relative = path.relative_to(check_rooms.ROOT)
        name, inside = check_rooms.room_of(relative)
        room = rooms.setdefault(name, Room(name))
        text = path.read_text()
        room.lines += text.count("\n")
        if inside:
            room.folders.add(inside)
        for header in re.findall(r'^#include "([a-z_0-9]+/[a-z_0-9/]+\.h)"', text, re.M):
            includes[name, check_rooms.room_of(header)[0]] += 1
        for header in set(re.findall(r"^#include <(stipple/\w+\.h)>", text, re.M)) & INTERFACES.keys():
            includes[name, INTERFACES[header]] += 1
    return rooms, includes


def folder_of(room):
    return "src" if room in check_rooms.LIBRARY else room.split("/")[0]


def necessary(edges):
    """The transitive reduction of a graph without cycles."""
    below = collections.defaultdict(set)
    for upper, lower in edges:
        below[upper].add(lower)

    def reaches(start, goal):
        return any(next_room == goal or reaches(next_room, goal) for next_room in below[start])

    return {edge for edge in edges
            if not any(reaches(other, edge[1]) for other in below[edge[0]] if other != edge[1])}


def set_columns(rooms, edges):
    """A room stands to the right of all that it includes; where its users allow several columns, in the emptiest."""
    def depth(room):
        return max((depth(lower) + 1 for upper, lower in edges if upper == room), default=0)

    loads = collections.Counter()
    for room in rooms:
        room.column = depth(room)
        loads[room.column] += room.height
    for room in sorted(rooms, key=lambda r: (-r.column, -r.height)):
        users = [upper.column for upper, lower in edges if lower == room]
        if users and room.column > 0:
            loads[room.column] -= room.height
            room.column = min(range(room.column, min(users)), key=lambda column: loads[column])
            loads[room.column] += room.height


def make_paths(edges, columns):
    """Each arrow as the rooms and lanes that it passes, from right to left."""
    paths = {}
    for upper, lower in sorted(edges, key=lambda edge: (edge[0].name, edge[1].name)):
        lanes = []
        for column in range(upper.column - 1, lower.column, -1):
            lane = Lane(f"{upper.name} {lower.name}")
            lane.column, lane.height = column, LANE
            columns[column].append(lane)
            lanes.append(lane)
        paths[upper, lower] = [upper, *lanes, lower]
    return paths


def place(column, wanted):
    """Centres as near as possible to the wanted ones, in order and without overlap (pooled adjacent violators)."""
    offsets, at = [], 0.0
    for room in column:
        offsets.append(at + room.height / 2)
        at += room.height + ROOM_GAP
    pools = []
    for centre, offset in zip(wanted, offsets):
        pools.append([centre - offset, 1])
        while len(pools) > 1 and pools[-2][0] > pools[-1][0]:
            (a, m), (b, n) = pools[-2:]
            pools[-2:] = [[(a * m + b * n) / (m + n), m + n]]
    starts = [start for start, count in pools for _ in range(count)]
    for room, start, offset in zip(column, starts, offsets):
        room.y = start + offset


def relax(columns, links):
    """Moves rooms towards those that they are joined to. Returns how steep the arrows are."""
    for column in columns:
        place(column, [0.0] * len(column))
    neighbours = collections.defaultdict(list)
    for a, b in links:
        neighbours[a].append(b)
        neighbours[b].append(a)
    for _ in range(12):
        for column in itertools.chain(columns, reversed(columns)):
            place(column, [math.fsum(n.y for n in neighbours[room]) / len(neighbours[room]) if neighbours[room] else room.y
                           for room in column])
    crossings = sum((a.y - c.y) * (b.y - d.y) < 0 for (a, b), (c, d) in itertools.combinations(links, 2)
                    if a.column == c.column)
    bottom = max(r.y + r.height / 2 for column in columns for r in column)
    top = min(r.y - r.height / 2 for column in columns for r in column)
    return 400 * crossings + 2 * (bottom - top) + math.fsum(abs(a.y - b.y) for a, b in links)


def arrange(columns, links):
    """Orders each column by swaps, as long as they help."""
    best = relax(columns, links)
    improved = True
    while improved:
        improved = False
        for column in columns:
            for i, j in itertools.combinations(range(len(column)), 2):
                column[i], column[j] = column[j], column[i]
                cost = relax(columns, links)
                if cost < best - 1:
                    best, improved = cost, True
                else:
                    column[i], column[j] = column[j], column[i]
    relax(columns, links)


def wrap(words, width):
    """Lines of words that fit a width, at 6.1 pixels a letter."""
    lines = []
    for word in words:
        if lines and 6.1 * len(f"{lines[-1]}, {word}") <= width:
            lines[-1] += f", {word}"
        else:
            lines.append(word)
    return lines


def text(x, y, words, size, style=""):
    return f'<text x="{round(x)}" y="{round(y)}" font-size="{size}"{style}>{words}</text>'


class Floor:
    def __init__(self, floor, rooms, includes):
        self.name, self.folder, self.about, self.band, self.fill, self.line = floor
        self.rooms = [rooms[name] for name in sorted(rooms) if folder_of(name) == self.folder]
        edges = {(rooms[a], rooms[b]) for a, b in includes
                 if a != b and folder_of(a) == folder_of(b) == self.folder}
        self.counts = {edge: includes[edge[0].name, edge[1].name] for edge in edges}
        kept = necessary(edges)
        for room in self.rooms:
            room.height = self.height_of(room)
        set_columns(self.rooms, kept)
        self.columns = [[] for _ in range(max(room.column for room in self.rooms) + 1)]
        self.step = (WIDTH - 4 * MARGIN - ROOM_WIDTH) / max(len(self.columns) - 1, 1)
        for room in self.rooms:
            self.columns[room.column].append(room)
        self.paths = make_paths(kept, self.columns)
        arrange(self.columns, [link for path in self.paths.values() for link in zip(path, path[1:])])
        everything = [room for column in self.columns for room in column]
        self.top = min(room.y - room.height / 2 for room in everything)
        self.height = BAND_TITLE + max(room.y + room.height / 2 for room in everything) - self.top + MARGIN

    @staticmethod
    def height_of(room):
        names = wrap(sorted(room.folders), ROOM_WIDTH - 14)
        return max(rounded(room.lines) / LINES_PER_PIXEL, ROOM_MIN + (14 * len(names) + 4 if names else 0))

    def left(self, room):
        return 2 * MARGIN + room.column * self.step

    def ports(self):
        """Where each arrow leaves and enters, spread along the sides of rooms by the direction it comes from."""
        ports = {}
        for end, other in ((0, 1), (-1, -2)):
            by_room = collections.defaultdict(list)
            for path in self.paths.values():
                by_room[path[end]].append(path)
            for room, paths in by_room.items():
                paths.sort(key=lambda path: (path[other].y, path[0].name, path[-1].name))
                for i, path in enumerate(paths):
                    spread = min(room.height - 16, 22 * (len(paths) - 1))
                    at = room.y + (i / (len(paths) - 1) - 0.5) * spread if len(paths) > 1 else room.y
                    ports[path[0], path[-1], end] = at
        return ports

    def draw_arrow(self, path, ports, y):
        x, at = self.left(path[0]), ports[path[0], path[-1], 0] + y
        parts = [f"M{round(x)} {round(at)}"]
        for room in path[1:]:
            last = room is path[-1]
            right = self.left(room) + ROOM_WIDTH + (9 if last else 0)
            goal = (ports[path[0], path[-1], -1] if last else room.y) + y
            middle = (x + right) / 2
            parts.append(f"C{round(middle)} {round(at)} {round(middle)} {round(goal)} {round(right)} {round(goal)}")
            x, at = right, goal
            if not last:
                x = self.left(room)
                parts.append(f"H{round(x)}")
        width = 1 + math.log2(max(rounded(self.counts[path[0], path[-1]]), 1)) / 2
        x, at = round(x), round(at)
        return [f'<path d="{"".join(parts)}" fill="none" stroke="{self.line}" stroke-width="{width:.1f}"/>',
                f'<path d="M{x - 9} {at}l10 -5v10z" fill="{self.line}"/>']

    def draw_room(self, room, y):
        x, top = self.left(room), y + room.y - room.height / 2
        size = min(13.0, math.floor(10 * (ROOM_WIDTH - 14) / (0.66 * len(room.label))) / 10)
        parts = [f'<rect x="{round(x)}" y="{round(top)}" width="{round(ROOM_WIDTH)}" height="{round(room.height)}" '
                 f'rx="4" fill="{self.fill}" stroke="{self.line}" stroke-width="1.2"/>',
                 text(x + 8, top + 16, room.label, size, ' font-weight="bold"'),
                 text(x + 8, top + 30, f"{rounded(room.lines):,.0f} lines", 10.5, ' fill="#667"')]
        for i, line in enumerate(wrap(sorted(room.folders), ROOM_WIDTH - 14)):
            parts.append(text(x + 8, top + 47 + 14 * i, line, 11, ' fill="#334"'))
        return parts

    def draw(self, top):
        y = top + BAND_TITLE - self.top
        parts = [f'<rect x="{MARGIN}" y="{round(top)}" width="{WIDTH - 2 * MARGIN}" height="{round(self.height)}" '
                 f'rx="8" fill="{self.band}"/>',
                 text(2 * MARGIN, top + 25, f'<tspan font-weight="bold" font-size="17">{self.name}</tspan>'
                      f'<tspan dx="10" fill="#556">{self.about}</tspan>', 13)]
        ports = self.ports()
        for path in self.paths.values():
            parts += self.draw_arrow(path, ports, y)
        for room in self.rooms:
            parts += self.draw_room(room, y)
        return parts


def draw_between(upper, lower, x, top, bottom, count):
    """A broad arrow from a floor to one below."""
    width = round(2 * math.log2(rounded(count)))
    return [f'<path d="M{x} {round(top)}V{round(bottom) - 13}" stroke="{upper.line}" stroke-width="{width}"/>',
            f'<path d="M{x} {round(bottom)}l-{width} -14h{2 * width}z" fill="{upper.line}"/>',
            text(x + width + 6, bottom - 14, f"{upper.name} includes {lower.name}", 12, ' fill="#445"')]


def draw_house():
    rooms, includes = read_house()
    floors = [Floor(floor, rooms, includes) for floor in FLOORS]
    between = collections.Counter()
    for (a, b), count in includes.items():
        between[folder_of(a), folder_of(b)] += count
    parts, tops, y = [], [], MARGIN
    for floor in floors:
        tops.append(y)
        parts += floor.draw(y)
        y += floor.height + BAND_GAP
    for i, floor in enumerate(floors[:-1]):
        below = floors[i + 1]
        parts += draw_between(floor, below, WIDTH // 2, tops[i] + floor.height, tops[i + 1],
                              between[floor.folder, below.folder])
    y += 4 - BAND_GAP
    notes = ["An arrow points to the included room and is the wider the more includes it stands for; what a chain of "
             "arrows implies is left out.",
             "A room is as tall as its code is long. Every floor may include the floors below it."]
    for note in notes:
        y += 17
        parts.append(text(2 * MARGIN, y, note, 12, ' fill="#445"'))
    height = round(y + MARGIN)
    return "\n".join([f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" '
                      f'viewBox="0 0 {WIDTH} {height}" font-family="DejaVu Sans, Verdana, sans-serif">',
                      f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>', *parts, "</svg>", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="fails if the picture is not up to date")
    arguments = parser.parse_args()
    picture = draw_house()
    if not arguments.check:
        PICTURE.write_text(picture)
    elif not PICTURE.exists() or PICTURE.read_text() != picture:
        sys.exit(f"{PICTURE.relative_to(check_rooms.ROOT)} is out of date: run scripts/draw_house.py")


if __name__ == "__main__":
    main()
