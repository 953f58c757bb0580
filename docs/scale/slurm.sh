#!/usr/bin/env bash
# Many photos on many machines: a Slurm job array, each task of which does its part.
#
#     sbatch --array=1-100 docs/scale/slurm.sh LIST.txt edit.json OUT
#
# LIST.txt names the photos, one a line; OUT is the folder for the pictures, which all nodes see. What each task did
# stands in OUT-reports, a file a part. A task that was killed, or put back into the queue, goes on where it stopped.
# To run some tasks once more say how many parts there were: PARTS=100 sbatch --array=3,17 …
#
#SBATCH --job-name=plenoscope
#SBATCH --cpus-per-task=1
#SBATCH --mem=2G
#SBATCH --requeue
#SBATCH --open-mode=append
set -eu
[ $# = 3 ] || { echo "usage: sbatch --array=1-N $0 LIST.txt edit.json OUT" >&2; exit 2; }
list=$1 recipe=$2 out=$3
part=${SLURM_ARRAY_TASK_ID:?start it with sbatch --array=1-N}
parts=${PARTS:-$SLURM_ARRAY_TASK_COUNT}
cores=${SLURM_CPUS_PER_TASK:-1}
mkdir -p "$out-reports"
# The cache is of no use to whom every photo is new, and homes on a network would be slow.
exec "${PLENOSCOPE:-plenoscope}" batch --files-from "$list" --recipe "$recipe" -o "$out" \
    --shard "$part/$parts" --resume --report "$out-reports/$part-of-$parts.jsonl" \
    --jobs "$cores" --threads 1 --no-cache
