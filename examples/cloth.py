"""A sheet that falls on a ball: cloth.py [FILE.html], or .png, .npz, .pc2."""

from __future__ import annotations

import sys

import dvdx
import numpy as np


def main(path: str | None = None) -> None:
    side = 24
    positions = np.array([(c / (side - 1), 0.7, r / (side - 1)) for r in range(side) for c in range(side)], np.float32)
    state = dvdx.State(positions, np.zeros_like(positions))

    scene = dvdx.Scene(mass=0.2 / side**2)
    scene.constant(acceleration=(0, -9.81, 0))
    scene.drag(coefficient=2e-4)
    scene.grid(rows=side, columns=side, edge_u=(1, 0, 0), edge_v=(0, 0, 1), structural=40, shear=10, damping=0.002)
    scene.sphere(center=(0.5, 0.3, 0.5), radius=0.3, friction=0.5, thickness=0.005)
    plan = dvdx.compile(scene, state, step=1 / 60)
    print(plan)

    recording = plan.record(state, steps=90, every=3, threads=2)
    apart = np.linalg.norm(state.positions - (0.5, 0.3, 0.5), axis=1)
    print(f"{recording}: {apart.min():.3f} m from the middle of the ball, {plan.check(state)['stretch']:.3f} of its length")
    if apart.min() < 0.305 - 1e-4:
        sys.exit("a particle is in the ball")
    if path is not None:
        recording.save(path)


if __name__ == "__main__":
    main(*sys.argv[1:])
