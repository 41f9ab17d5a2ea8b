"""Runs a sweep on a Ray cluster of two nodes on this machine.

It is stopped and taken up again; a worker is killed on the way, and then a whole node:

python cluster.py PLAN.toml FOLDER
"""

from __future__ import annotations

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


def main() -> None:
    cluster = Cluster(initialize_head=True, head_node_args=NODE)
    node = cluster.add_node(**NODE)
    killed: list[str] = []

    def kill(_: str, share: float) -> None:
        if share >= 0.2 and not killed:
            mine = psutil.Process().children(recursive=True)
            worker = next(each for each in mine if each.cmdline()[:1] == ["ray::_do"])
            killed.append("worker")
            worker.kill()
            print("worker killed")
        elif share >= 0.4 and len(killed) == 1:
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
