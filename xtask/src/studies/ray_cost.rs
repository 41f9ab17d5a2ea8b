//! `cargo xtask ray-cost`: what it costs to do a sweep on a Ray cluster rather than on the threads of this machine.
//!
//! The same sweep is done by turns on two threads and on a cluster of two nodes with one processor each, which is this
//! machine twice. The cluster stands before the clock starts; what is timed is the whole call, connection and table included.

use anyhow::{Context, bail};

use crate::python::Environment;

/// Does the sweep by turns, and prints how long each took.
const SWEEPS: &str = r#"
import os, sys, tempfile, time

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
import palpate
from ray.cluster_utils import Cluster

jobs, rounds = int(sys.argv[1]), int(sys.argv[2])
plan = f"""
kind = "simulate"
trials = {jobs}
samples = 60
objects.named = {{ name = "egg" }}
touchpads = [{{ noise_sd_m = 0.1e-3 }}]
reconstruct.method = "quadrature"
"""
node = {"num_cpus": 1, "object_store_memory": 80 * 2**20, "include_dashboard": False}
cluster = Cluster(initialize_head=True, head_node_args=node)
cluster.add_node(**node)
cluster.wait_for_nodes()

def timed(folder, **options):
    started = time.perf_counter()
    result = palpate.sweep(plan, folder, progress=False, **options)
    return time.perf_counter() - started, result

for _ in range(rounds):
    with tempfile.TemporaryDirectory() as folder:
        local_s, local = timed(os.path.join(folder, "local"), threads=2)
        ray_s, ray = timed(os.path.join(folder, "ray"), engine=cluster.address)
        assert local.table.read_bytes() == ray.table.read_bytes(), "the tables differ"
    print(f"{jobs} jobs: two threads {local_s:.1f} s, two nodes {ray_s:.1f} s,", end=" ")
    print(f"throughput on the cluster {1e2 * local_s / ray_s:.1f} %", flush=True)
cluster.shutdown()
"#;

/// Options of `cargo xtask ray-cost`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Jobs of the sweep, a tenth of a second each
    #[arg(long, default_value_t = 2000)]
    jobs: u32,
    /// Times that both are timed
    #[arg(long, default_value_t = 1)]
    rounds: u32,
}

/// Measures and prints.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let environment = Environment::provide()?;
    environment.install_wheel(if cfg!(debug_assertions) { "dev" } else { "release" })?;
    let (jobs, rounds) = (arguments.jobs.to_string(), arguments.rounds.to_string());
    let status = environment.python().args(["-c", SWEEPS, &jobs, &rounds]).status().context("python")?;
    if !status.success() {
        bail!("the sweeps failed ({status})");
    }
    Ok(())
}
