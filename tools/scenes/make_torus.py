#!/usr/bin/env python3
"""Writes torus.obj: a ring that lies on the x-z plane, faces turned outwards."""
import math
import pathlib

RING, TUBE = 0.42, 0.14  # m: from the ring's middle to the tube's, the tube's own radius
AROUND, ACROSS = 36, 18  # faces


def main():
    lines = ["# A torus, by make_torus.py; metres"]
    for i in range(AROUND):
        for j in range(ACROSS):
            u, v = 2 * math.pi * i / AROUND, 2 * math.pi * j / ACROSS
            r = RING + TUBE * math.cos(v)
            lines.append(f"v {r * math.cos(u):.6f} {TUBE * math.sin(v):.6f} {r * math.sin(u):.6f}")
    for i in range(AROUND):
        for j in range(ACROSS):
            at = [a % AROUND * ACROSS + b % ACROSS + 1 for a, b in ((i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j))]
            lines.append("f {} {} {}".format(*at[:3]))
            lines.append("f {} {} {}".format(at[0], at[2], at[3]))
    path = pathlib.Path(__file__).with_name("torus.obj")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
