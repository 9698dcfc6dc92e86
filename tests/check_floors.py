#!/usr/bin/env python3
"""Includes run down: tests/check_floors.py [ROOT]. A line for each fault, and the status 1 where there is one.

A house is a list of floors, the lowest first. A floor is a folder, or several that know nothing of each other. A file includes
files of its own folder and of lower floors. The folders of a slice are one. And no file is longer than a reader takes in.
"""
import os
import re
import sys

HOUSES = {
    "kernel": {
        "under": ["kernel/src"],
        "slices": ["kernel/src/springs", "kernel/src/contact"],
        "floors": [
            "kernel/src/math",  # numbers
            "kernel/src/simd",  # registers
            "kernel/src/work",  # tasks, columns, the environment of a step
            "kernel/src/forces",  # one force a file
            "kernel/src/scene",  # plain values and their checks
            "kernel/src/motion",  # poses that go somewhere
            "kernel/src/topology",  # who is joined to whom
            "kernel/src/flow",  # particles by themselves between impacts
            "kernel/src/springs",  # networks
            "kernel/src/constraint",  # rods, chains, limits
            "kernel/src/air",  # triangles in wind
            "kernel/src/skin",  # back-stops and tethers
            "kernel/src/contact",  # surfaces
            "kernel/src/free",  # the block loop and its coefficients
            "kernel/src/meet",  # particles that meet
            "kernel/src/stability",  # ranges, accuracy, sub-steps
            "kernel/src/lifecycle/pass",  # births and removals
            "kernel/src/isa",  # one table of passes
            "kernel/src/plan",  # what puts the slices together
            "kernel/src/lifecycle",  # particles that come and go
            "kernel/src/c_api",  # the C functions
            "kernel/src/adapters",  # OpenMP and MPI
        ],
    },
    "tools": {
        "under": ["tools/dvdx", "tools/lab"],
        "floors": [
            "tools/dvdx/scene_io",  # a scene's file, as values
            "tools/dvdx/ranks",  # who has which particles, and what ranks send each other
            "tools/dvdx/files",  # bytes on the disk, there whole or not at all
            "tools/dvdx/output",  # states, pages and pictures in each format; what a person reads
            "tools/dvdx/checkpoint",  # a run that stops and goes on
            "tools/dvdx/state",  # a scene's particles at one time, and the machine that steps them
            "tools/dvdx/watch",  # all that is seen of a run, its outcome and what that warns of
            "tools/dvdx/run",  # dvdx run, on one rank or many
            "tools/dvdx/scale",  # many ranks, foretold
            ["tools/lab/closed_form", "tools/lab/plain"],
            "tools/lab/report",
            ["tools/lab/heat", "tools/lab/maps", "tools/lab/tune", "tools/lab/verify"],
            "tools/lab/hard_cases",
            "tools/dvdx/commands",
            "tools/dvdx",
        ],
    },
}

# Where an include is looked for, behind the folder of the file that has it.
INCLUDE_ROOTS = ["kernel/src", "kernel/include", "layouts/include", "tools/dvdx", "tools/lab"]

MOST_LINES = 600
LENGTH_UNDER = ["bench", "examples", "kernel", "layouts", "tests", "tools"]

SOURCE = re.compile(r"\.(cpp|hpp|h)$")
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)


def sources(root, tops):
    """Paths of source files, from the root, and their texts."""
    for top in tops:
        for folder, folders, names in os.walk(os.path.join(root, top)):
            folders[:] = sorted(each for each in folders if each not in ("build", "node_modules"))
            for name in sorted(filter(SOURCE.search, names)):
                path = os.path.join(folder, name)
                with open(path, encoding="utf-8") as file:
                    yield os.path.relpath(path, root).replace(os.sep, "/"), file.read()


def folder_of(path):
    return path.rpartition("/")[0]


def room_of(path, slices):
    """The folder of a file, or the slice that it is in."""
    return next((each for each in slices if path.startswith(each + "/")), folder_of(path))


def included(root, path, text):
    """Files of this repository that the file includes."""
    for name in INCLUDE.findall(text):
        for start in [folder_of(path), *INCLUDE_ROOTS]:
            found = os.path.normpath(os.path.join(start, name))
            if os.path.isfile(os.path.join(root, found)):
                yield found
                break


def cycles(arrows):
    """Sets of folders each of which leads to each other one."""
    reached = {}
    for start in arrows:
        seen, ahead = set(), [start]
        while ahead:
            for folder in arrows.get(ahead.pop(), ()):
                if folder not in seen:
                    seen.add(folder)
                    ahead.append(folder)
        reached[start] = seen
    return {
        frozenset(other for other in reached[start] if start in reached.get(other, ()))
        for start in reached
        if start in reached[start]
    }


def faults_of_house(root, house):
    floors = [[floor] if isinstance(floor, str) else floor for floor in house["floors"]]
    floor_of = {folder: number for number, floor in enumerate(floors) for folder in floor}
    arrows = {folder: set() for folder in floor_of}
    homeless, lived_in = set(), set()
    for path, text in sources(root, house["under"]):
        here = room_of(path, house.get("slices", []))
        lived_in.add(here)
        if here not in floor_of:
            homeless.add(here)
            continue
        for other in included(root, path, text):
            there = room_of(other, house.get("slices", []))
            if there == here or there not in floor_of:
                continue
            arrows[here].add(there)
            if floor_of[there] >= floor_of[here]:
                way = "up" if floor_of[there] > floor_of[here] else "across"
                yield f"{path} includes {other}: runs {way}, from {here} to {there}"
    for cycle in sorted(map(sorted, cycles(arrows))):
        yield "include each other: " + ", ".join(cycle)
    for folder in sorted(homeless):
        yield f"{folder}: is on no floor"
    for folder in sorted(set(floor_of) - lived_in):
        yield f"{folder}: is on a floor, and has no source file"


def faults_of_length(root):
    for path, text in sources(root, LENGTH_UNDER):
        lines = text.count("\n")
        if lines > MOST_LINES:
            yield f"{path}: has {lines} lines: must be at most {MOST_LINES}"


def main():
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    faults = [f"{name}: {fault}" for name, house in HOUSES.items() for fault in faults_of_house(root, house)]
    faults += faults_of_length(root)
    print("\n".join(faults) or "includes run down, and no file is longer than it may be")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
