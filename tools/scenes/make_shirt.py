#!/usr/bin/env python3
"""Writes shirt.obj: the front and the back of a shirt, cut alike from squares and sewn along sides, sleeves and shoulders.

Hem, cuffs and neck stay open. The shirt lies on the x-z plane, its neck towards +z, blown up a little in y.
"""
import math
import pathlib

SQUARE = 0.0125  # m
BODY = 22  # squares from the middle to a side
SLEEVE = 40  # to a cuff
HEM, ARMPIT, SHOULDER = 0, 38, 54  # rows
NECK = 8  # squares from the middle to either end of the opening
PUFF = 0.04  # m, half the thickness far from a seam
RISE = 0.08  # m from a seam, where that is reached


def is_cloth(column, row):
    reach = BODY if row < ARMPIT else SLEEVE
    return HEM <= row < SHOULDER and -reach <= column < reach


def is_open(a, b):
    """Whether the side from a to b of the pattern's outline is an opening."""
    if a[1] == b[1]:
        is_neck = a[1] == SHOULDER and max(abs(a[0]), abs(b[0])) <= NECK
        return a[1] == HEM or is_neck
    return abs(a[0]) == SLEEVE


def corners(column, row):
    return (column, row), (column + 1, row), (column + 1, row + 1), (column, row + 1)


def main():
    squares = [(c, r) for r in range(HEM, SHOULDER) for c in range(-SLEEVE, SLEEVE) if is_cloth(c, r)]
    sides = {}
    for square in squares:
        loop = corners(*square)
        for a, b in zip(loop, loop[1:] + loop[:1]):
            sides[min(a, b), max(a, b)] = sides.get((min(a, b), max(a, b)), 0) + 1
    seam = {end for side, faces in sides.items() if faces == 1 and not is_open(*side) for end in side}
    points = sorted({corner for square in squares for corner in corners(*square)}, key=lambda p: (p[1], p[0]))

    def height(point):
        away = SQUARE * min(math.dist(point, other) for other in seam)
        return PUFF * math.sqrt(1 - (1 - min(away / RISE, 1)) ** 2)

    lines = ["# The front and the back of a shirt, by make_shirt.py; metres"]
    numbers = {}
    for layer in (1, -1):
        for point in points:
            if point in seam and layer < 0:
                numbers[layer, point] = numbers[1, point]
                continue
            x, z = SQUARE * point[0], SQUARE * point[1]
            lines.append(f"v {x:.4f} {layer * height(point) + 0.0:.4f} {z:.4f}")
            numbers[layer, point] = len(lines) - 1
    for layer in (1, -1):
        for square in squares:
            loop = corners(*square)[::-layer]
            lines.append("f " + " ".join(str(numbers[layer, corner]) for corner in loop))
    pathlib.Path(__file__).with_name("shirt.obj").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
