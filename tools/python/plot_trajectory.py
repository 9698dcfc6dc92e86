#!/usr/bin/python3
"""Draws where a few bouncing particles go: plot_trajectory.py [PICTURE.png]

They fall, are blown aside and bounce on a floor. Needs python3-matplotlib.
"""

import sys

import dvdx
import matplotlib
import numpy as np

matplotlib.use("Agg")  # a file, no window
from matplotlib import pyplot  # noqa: E402


def trajectories(particles, steps, step):
    """Positions at every step, of shape (steps + 1, particles, 3); m."""
    positions = np.zeros((particles, 3), np.float32)
    positions[:, 1] = np.linspace(0.5, 2.0, particles)
    velocities = np.zeros_like(positions)
    velocities[:, 0] = 1.0

    scene = dvdx.Scene()
    scene.constant(acceleration=(0, -9.81, 0))
    scene.drag(coefficient=0.1, wind=(2, 0, 0))
    scene.plane(normal=(0, 1, 0), restitution=0.8)
    state = dvdx.State(positions, velocities)
    plan = dvdx.compile(scene, state, step=step)

    path = np.empty((steps + 1, particles, 3), np.float32)
    path[0] = positions
    for i in range(steps):
        plan.step(state)  # moves `positions` and `velocities` themselves
        path[i + 1] = positions
    return path


def main(picture="trajectory.png"):
    path = trajectories(particles=5, steps=360, step=1 / 120)
    figure, axes = pyplot.subplots(figsize=(8, 3.5), layout="constrained")
    for particle in range(path.shape[1]):
        axes.plot(path[:, particle, 0], path[:, particle, 1], linewidth=1)
    axes.set(xlabel="x, m", ylabel="y, m", ylim=(0, None), title="Falling, blown aside, bouncing: 3 s")
    figure.savefig(picture, dpi=120)


if __name__ == "__main__":
    main(*sys.argv[1:])
