"""The numpy prototype's reconstruction from nothing.

Started with the prototype's folder and a log that ``cargo xtask bench-peers`` writes; each line that comes in asks for
one run and is answered by the seconds that it took, and ψ at each sample.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, sys.argv[1])
import grow


def main():
    """Answers until nothing more is asked."""
    log = json.loads(Path(sys.argv[2]).read_text())
    angles = [np.array(log[name]) for name in ("phi1_rad", "phi2_rad")]
    contacts_mm = [1e3 * np.array(log[name]) for name in ("s1_m", "s2_m")]
    for _ in sys.stdin:
        began = time.perf_counter()
        found = grow.solve(*angles, *contacts_mm)
        print(time.perf_counter() - began, *found[0][2].tolist(), flush=True)


if __name__ == "__main__":
    main()
