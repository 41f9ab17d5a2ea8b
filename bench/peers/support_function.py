"""The boundary of an object that a scene gives by the harmonics of its support function, for the peers that want vertices."""

import numpy as np


def outline(scene, vertices):
    """The boundary points at evenly spread normal angles."""
    theta = 2 * np.pi * np.arange(vertices) / vertices
    a, b = np.array(scene["harmonics_m"]).T
    k = np.arange(1, len(a) + 1)
    cos, sin = np.cos(np.outer(theta, k)), np.sin(np.outer(theta, k))
    r = scene["mean_radius_m"] + cos @ a + sin @ b
    d = sin @ (k * a) - cos @ (k * b)
    return np.stack([r * np.cos(theta) + d * np.sin(theta), r * np.sin(theta) - d * np.cos(theta)], axis=1)
