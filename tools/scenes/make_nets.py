#!/usr/bin/env python3
"""Writes rope-bridge.json and net-stiff.json, whose springs are listed one by one."""
import json
import pathlib

PER_LINE = 10

SCENE = """{{
  "format": "dvdx-scene/1",
  "name": "{name}",
  "about": "{about}",
  "step": 0.016666666666666666,
  "duration": {duration},
  "particles": {{
    "count": {count},
    "mass": {mass},
    "position": {{"values": {positions}}}
  }},
  "network": {{
    "type": "springs",
    "pairs": {pairs},
    "stiffness": {{"values": {stiffness}}},
    "rest_length": "start",
    "damping": {damping},
    "fixed": {fixed}
  }},
  "forces": [
    {forces}
  ]
}}
"""


def listed(values):
    entries = [json.dumps(value) for value in values]
    rows = [", ".join(entries[i : i + PER_LINE]) for i in range(0, len(entries), PER_LINE)]
    return "[\n      " + ",\n      ".join(rows) + "\n    ]"


def write(file, positions, springs, forces, **rest):
    text = SCENE.format(
        count=len(positions),
        positions=listed(positions),
        pairs=listed([pair for pair, _ in springs]),
        stiffness=listed([k for _, k in springs]),
        forces=",\n    ".join(json.dumps(force) for force in forces),
        **rest,
    )
    pathlib.Path(__file__).with_name(file).write_text(text)


def rope_bridge():
    last = 48  # stations along 24 m
    positions, masses, springs = [], [], []
    for station in range(last + 1):
        x = 24 * station / last - 12
        sag = 1.2 * (x / 12) ** 2
        for z, y, mass in ((-0.5, sag, 6), (0.5, sag, 6), (-0.6, sag + 1, 1.5), (0.6, sag + 1, 1.5)):
            positions.append([x, round(y, 4), z])
            masses.append(mass)
        foot, hand = 4 * station, 4 * station + 2
        springs.append(([foot, foot + 1], 200000))  # a plank
        springs += [([foot, hand], 20000), ([foot + 1, hand + 1], 20000)]  # hangers
        if station < last:
            springs += [([foot + side, foot + 4 + side], 400000) for side in (0, 1)]
            springs += [([hand + side, hand + 4 + side], 150000) for side in (0, 1)]
            springs += [([foot, foot + 5], 40000), ([foot + 1, foot + 4], 40000)]  # keep the planks square
    write(
        "rope-bridge.json",
        positions,
        springs,
        [
            {"type": "constant", "acceleration": [0, -9.81, 0]},
            {"type": "drag", "coefficient": 0.4, "wind": [0, 0, 8]},
        ],
        name="rope bridge",
        about="A foot bridge of four ropes over 24 m, with planks and hangers, let go before its ropes are tight and blown "
        "sideways: it drops into them and swings.",
        duration=4.0,
        mass=json.dumps({"values": masses}),
        damping=20,
        fixed=[0, 1, 2, 3] + [4 * last + k for k in range(4)],
    )


def net_stiff():
    side = 14
    positions = [[round(0.1 * c, 4), round(-0.1 * r, 4) + 0.0, 0.0] for r in range(side) for c in range(side)]
    springs = []
    drawn = 1
    for r in range(side):
        for c in range(side):
            own = side * r + c
            for other, is_inside in ((own + 1, c + 1 < side), (own + side, r + 1 < side)):
                drawn = drawn * 16807 % 2147483647
                if is_inside:
                    springs.append(([own, other], 2 * 10 ** (drawn % 7)))
    write(
        "net-stiff.json",
        positions,
        springs,
        [{"type": "constant", "acceleration": [0.5, -9.81, 2]}],
        name="net, stiff",
        about="A net of 0.2 kg knots that hangs from its top row, with springs from 2 N/m to 2 million N/m side by side: the "
        "stiffest set the sub-steps, the softest make the motion.",
        duration=2.0,
        mass=0.2,
        damping=0,
        fixed=list(range(side)),
    )


if __name__ == "__main__":
    rope_bridge()
    net_stiff()
