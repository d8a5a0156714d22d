# SPDX-License-Identifier: MIT
"""Checks the levels of a .stip file. Written from docs/format.md alone; part of read_store.py."""

NONE = 0xFFFFFFFF


def need(condition, what):
    if not condition:
        raise ValueError(what)


def check_groups(t):
    for i, group in enumerate(t["level_groups"]):
        need(group["radius"] >= 0 and group["error"] > 0, f"level group {i}")
    for i, cluster in enumerate(t["level_clusters"]):
        made, used = (t["level_groups"][g]["error"] if g != NONE else None for g in (cluster["made_by"], cluster["used_by"]))
        need(made is None or used is None or made < used, f"level cluster {i}: errors")
        need(cluster["one_sided"] <= 128, f"level cluster {i}: one_sided")


def link_levels(t):
    """Names the mesh of each level, and gives it the rows of its clusters."""
    first, end = len(t["meshes"]) - len(t["levels"]), 0
    need(first >= 0, "more levels than meshes")
    for i, level in enumerate(t["levels"]):
        place = f"level {i}"
        need(level["node"] < len(t["nodes"]) and level["flags"] <= 1, f"{place}: node or flags")
        need(i == 0 or t["levels"][i - 1]["node"] <= level["node"], f"{place}: nodes do not ascend")
        level["mesh"] = first + i
        mesh = t["meshes"][level["mesh"]]
        need(mesh["cluster_count"] != NONE, f"{place}: its mesh is not clusters")
        mesh["one_sided"] = [c["one_sided"] for c in t["level_clusters"][end:end + mesh["cluster_count"]]]
        end += mesh["cluster_count"]
    need(end == len(t["level_clusters"]), "clusters of no level")
    need(all(part["kind"] or part["index"] < first for part in t["parts"]), "a part is a level")
    return first


def check_levels(t):
    """Levels, before blocks are read."""
    check_groups(t)
    first = link_levels(t)
    own = {thing["material"] for thing in t["meshes"][:first] + t["point_sets"]}
    apart = {mesh["material"] for mesh in t["meshes"][first:]} - own
    need(len(t["level_figures"]) <= 1, "level figures: more than one")
    for figures in t["level_figures"]:
        levels = t["meshes"][first:]
        triangles, sizes = (sum(values) for values in ((mesh["triangle_count"] for mesh in levels),
                                                       (t["blocks"][mesh["block"]]["size"] for mesh in levels)))
        need(figures == {"levels": len(levels), "triangles": triangles, "bytes": sizes}, "level figures")
    count = len(t["materials"])
    while count - 1 in apart:
        count -= 1
    for summary in t["summary"]:
        need(summary["mesh_count"] == first and summary["material_count"] == count, "summary: meshes or materials")
        triangles = sum(mesh["triangle_count"] for mesh in t["meshes"][:first])
        need(summary["unique_triangles"] == triangles, "summary: unique_triangles")
