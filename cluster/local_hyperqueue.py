"""A HyperQueue server and two workers of one core each, until the process is ended."""

import signal

from hyperqueue import LocalCluster
from hyperqueue.cluster import WorkerConfig

with LocalCluster() as cluster:
    for _ in range(2):
        cluster.start_worker(WorkerConfig(cores=1))
    print("ready", cluster.cluster.server_dir, flush=True)
    signal.sigwait({signal.SIGTERM, signal.SIGINT})
