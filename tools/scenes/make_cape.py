#!/usr/bin/env python3
"""Writes cape.json: a cape on a figure of capsules that walks in a circle. Usage: make_cape.py cape.json"""
import json
import math
import sys

RADIUS = 1.2  # m, of the circle
DURATION = 10.0  # s
KEYS = 80  # a motion
STRIDE = 2 * math.pi  # rad/s: a stride a second
WAY = 2 * math.pi * 0.95  # rad, round the circle


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def applied(a, v):
    return [sum(a[i][k] * v[k] for k in range(3)) for i in range(3)]


def about_x(angle):
    c, s = math.cos(angle), math.sin(angle)
    return [[1, 0, 0], [0, c, -s], [0, s, c]]


def about_y(angle):
    c, s = math.cos(angle), math.sin(angle)
    return [[c, 0, s], [0, 1, 0], [-s, 0, c]]


def rotation_vector(turn):
    """Axis times angle; half a turn, where the axis has two signs, does not occur."""
    angle = math.acos(max(-1, min(1, (turn[0][0] + turn[1][1] + turn[2][2] - 1) / 2)))
    if angle < 1e-12:
        return [0, 0, 0]
    part = angle / (2 * math.sin(angle))
    return [part * (turn[2][1] - turn[1][2]), part * (turn[0][2] - turn[2][0]), part * (turn[1][0] - turn[0][1])]


def rounded(v):
    return [round(x, 6) + 0.0 for x in v]


def key(time, center, swing):
    """The figure faces -z on the circle's +x side; `swing` turns a limb about its joint, `center`."""
    vigour = min(1, time)
    vigour *= vigour * (3 - 2 * vigour)  # it sets off within a second
    walked = WAY * (time - 0.5 if time >= 1 else 0.5 * time * time) / (DURATION - 0.5)
    round_circle = about_y(walked)
    turn = product(round_circle, about_x(vigour * swing * math.sin(STRIDE * time)))
    joint = applied(round_circle, center)
    joint[1] += 0.01 * vigour * (math.cos(2 * STRIDE * time) - 1)
    return {"time": round(time, 6), "translation": rounded([joint[k] - center[k] for k in range(3)]),
            "rotation": rounded(rotation_vector(turn))}


def motion(center, swing):
    return {"center": rounded(center), "keys": [key(DURATION * n / KEYS, center, swing) for n in range(KEYS + 1)]}


def figure():
    """Motions and contacts."""
    joints = {"left_leg": ([RADIUS - 0.1, 0.92, 0], 0.42), "right_leg": ([RADIUS + 0.1, 0.92, 0], -0.42),
              "left_arm": ([RADIUS - 0.2, 1.42, 0], -0.3), "right_arm": ([RADIUS + 0.2, 1.42, 0], 0.3)}
    motions = {"body": motion([0, 0, 0], 0)}
    motions |= {name: motion(center, swing) for name, (center, swing) in joints.items()}
    skin = {"friction": 0.2, "thickness": 0.012}

    def capsule(start, end, radius, of):
        return {"type": "capsule", "ends": [rounded(start), rounded(end)], "radius": radius, "motion": of, **skin}

    contacts = [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "friction": 0.5},
                capsule([RADIUS, 0.95, 0], [RADIUS, 1.38, 0], [0.14, 0.16], "body"),
                capsule([RADIUS - 0.15, 1.44, 0], [RADIUS + 0.15, 1.44, 0], 0.08, "body"),
                {"type": "sphere", "center": [RADIUS, 1.68, 0], "radius": 0.12, "motion": "body", **skin}]
    for name, (x, y, radii) in {"left_leg": (-0.1, 0.08, [0.1, 0.06]), "right_leg": (0.1, 0.08, [0.1, 0.06]),
                                "left_arm": (-0.27, 0.85, [0.06, 0.045]), "right_arm": (0.27, 0.85, [0.06, 0.045])}.items():
        contacts.append(capsule(joints[name][0], [RADIUS + x, y, 0], radii, name))
    return motions, contacts


def scene():
    motions, contacts = figure()
    cape = {"type": "grid", "rows": 44, "columns": 24, "origin": [RADIUS - 0.25, 1.47, 0.175], "edge_u": [0.5, 0, 0],
            "edge_v": [0, -1.02, 0.25], "mass": 0.3, "structural": 60, "shear": 20, "bend": 0.5, "damping": 0.002,
            "aerodynamics": {"density": 1.2, "drag": 1.0, "lift": 0.5}}
    gusts = [{"amplitude": [1.5, 0, 0.8], "angular_frequency": 2.1, "phase": 0},
             {"amplitude": [0.6, 0.2, -1.0], "angular_frequency": 5.3, "phase": 1.1}]
    return {"format": "dvdx-scene/1", "name": "cape",
            "about": "A cape of 0.5 m x 1.05 m on a figure of capsules that walks in a circle, in wind that comes in gusts.",
            "step": 1 / 60, "duration": DURATION, "wind": {"mean": [1.5, 0, 0.5], "gusts": gusts}, "motions": motions,
            "network": cape, "kinematic": [{"particles": "edge_top", "motion": "body"}],
            "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}], "contacts": contacts}


def text(value, depth=0):
    """JSON, a line for each entry of the upper levels and for each key of a motion."""
    inner = "\n" + "  " * (depth + 1)
    if isinstance(value, dict) and depth < 3 and len(json.dumps(value)) > 100:
        entries = [f"{json.dumps(name)}: {text(entry, depth + 1)}" for name, entry in value.items()]
        return "{" + inner + ("," + inner).join(entries) + "\n" + "  " * depth + "}"
    if isinstance(value, list) and any(isinstance(entry, dict) for entry in value):
        return "[" + inner + ("," + inner).join(json.dumps(entry) for entry in value) + "\n" + "  " * depth + "]"
    return json.dumps(value)


def main():
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write(text(scene()) + "\n")


if __name__ == "__main__":
    main()
