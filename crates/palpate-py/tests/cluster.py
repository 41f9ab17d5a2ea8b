"""Runs a sweep on a Ray cluster of two nodes on this machine.

It is stopped and taken up again; a worker is killed on the way, and then a whole node:

python cluster.py PLAN.toml FOLDER
"""

from __future__ import annotations

import contextlib
import sys

import psutil
from ray.cluster_utils import Cluster

import palpate

NODE = {"num_cpus": 1, "object_store_memory": 80 * 2**20, "include_dashboard": False}


class EnoughError(RuntimeError):
    """What a listener raises comes out as it is, whatever Ray raises of that kind."""


def enough(_: str, share: float) -> None:
    if share > 0:
        raise EnoughError


def at_work() -> psutil.Process | None:
    """A worker that has jobs to do just now."""
    for process in psutil.Process().children(recursive=True):
        with contextlib.suppress(psutil.Error):  # it may have ended
            if process.cmdline()[:1] == ["ray::_do"]:
                return process
    return None


def main() -> None:
    cluster = Cluster(initialize_head=True, head_node_args=NODE)
    node = cluster.add_node(**NODE)
    killed: list[str] = []

    def kill(_: str, __: float) -> None:
        """A worker as soon as one is at work, the node at the next call: most jobs are still to do then."""
        if not killed:
            worker = at_work()
            if worker is None:
                return  # all have done what they had; there will be more
            killed.append("worker")
            worker.kill()
            print("worker killed")
        elif len(killed) == 1:
            killed.append("node")
            cluster.remove_node(node, allow_graceful=False)
            print("node killed")

    try:
        try:
            palpate.sweep(sys.argv[1], sys.argv[2], engine=cluster.address, progress=enough)
        except EnoughError:
            print("stopped")
        print(palpate.sweep(sys.argv[1], sys.argv[2], engine=cluster.address, progress=kill))
    finally:
        cluster.shutdown()


if __name__ == "__main__":
    main()
