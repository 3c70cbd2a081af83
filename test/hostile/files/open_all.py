"""Open every hostile file with every loader, and print a line of JSON about the result of each.

The arguments are the folder in which the files are created, and a seed.
"""
import faulthandler
import json
import re
import resource
import sys
import traceback

import numpy as np
from aruco_ar import InputError
from aruco_ar.painting.sources import open_source
from aruco_ar.simulation.robot import load_path
from aruco_ar.walls.wall import load_wall
from aruco_node.parameters.settings import load_areas

from hostile.files.samples import cases

MEMORY_BYTES = 8 * 2**30  # no file should need more
HANG_S = 300


def look(path):
    """Open a picture source, and look at its pictures for a while."""
    source = open_source(path, lambda sentence: None)
    for stamp in np.arange(0, 1, 0.1):
        picture = source.at(stamp)
        assert picture.dtype == np.uint8 and picture.ndim == 3 and picture.shape[2] in (3, 4) and picture.size
        assert max(picture.shape) <= 4096


LOADERS = {'picture': look, 'wall': load_wall, 'areas': load_areas, 'path': load_path}


def peak_mb():
    """The peak memory of this process since the last call."""
    with open('/proc/self/status') as file:
        peak = int(re.search(r'VmHWM:\s*(\d+)', file.read()).group(1)) / 1024
    with open('/proc/self/clear_refs', 'w') as file:
        file.write('5')
    return peak


def main(folder, seed):
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    for case in cases(folder, int(seed)):
        for loader, load in LOADERS.items():
            began = peak_mb()
            refusal = fault = None
            faulthandler.dump_traceback_later(HANG_S, exit=True)
            try:
                load(case.path)
            except InputError as error:
                refusal = str(error)
            except Exception:
                fault = traceback.format_exc()
            faulthandler.cancel_dump_traceback_later()
            print(json.dumps({**case._asdict(), 'loader': loader, 'refusal': refusal, 'fault': fault,
                              'peak_mb': peak_mb(), 'began_mb': began}), flush=True)


if __name__ == '__main__':
    main(*sys.argv[1:])
