"""A campaign in shards under submitit: python with_submitit.py FILE FOLDER SHARDS.

Shards that were killed go on where they were, whether Slurm requeues them or this is called again.
"""

import os
import shlex
import signal
import subprocess
import sys

import submitit

# Several words: the program, and what it is to do.
CAMPAIGN = shlex.split(os.environ.get("CAMPAIGN", "flotilla campaign"))


def run_shard(file: str, folder: str, index: int, shards: int) -> None:
    shard = ["--shard", f"{index}/{shards}", "--out", folder, "--jobs", "1"]
    code = subprocess.run([*CAMPAIGN, file, *shard]).returncode
    if code < 0:
        # A signal ended it: Slurm is about to end this task too, and starts it again if it is requeued. A result that
        # is written now would be taken for the shard's.
        signal.pause()
    if code != 0:
        raise RuntimeError(f"shard {index} ended with {code}")


def main() -> None:
    file, folder, shards = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), int(sys.argv[3])
    executor = submitit.AutoExecutor(folder=os.path.join(folder, "submitit"))
    executor.update_parameters(name="campaign", timeout_min=60, cpus_per_task=1)
    executor.update_parameters(slurm_additional_parameters={"requeue": True})
    count = range(1, shards + 1)
    jobs = executor.map_array(run_shard, [file] * shards, [folder] * shards, count, [shards] * shards)
    for job in jobs:
        job.result()
    subprocess.run([*CAMPAIGN, "merge", folder], check=True)


if __name__ == "__main__":
    main()
