"""How far a calibrated lens is off."""
import numpy as np


def off_in_frame(lens, truth):
    """(4,) by how many pixels a lens is off at the corners of the frame.

    A calibration may turn the whole camera a little: that changes no measurement, so it is taken away.
    """
    width, height = truth.width - 1, truth.height - 1
    grid = np.stack(np.meshgrid(np.linspace(0, width, 9), np.linspace(0, height, 7)), axis=-1).reshape(-1, 2)
    true_rays, rays = (np.column_stack([each.rays(grid), np.ones(len(grid))]) for each in (truth, lens))
    true_rays, rays = (each / np.linalg.norm(each, axis=1, keepdims=True) for each in (true_rays, rays))
    left, _, right = np.linalg.svd(rays.T @ true_rays)
    turned = rays @ (left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right)
    off = np.linalg.norm(truth.project(turned) - grid, axis=1)
    return off[[0, 8, -9, -1]]
