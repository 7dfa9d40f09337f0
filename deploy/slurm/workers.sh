#!/usr/bin/env bash
# Workers of studies as a job of Slurm, one of a core for each task:
#
#   sbatch deploy/slurm/workers.sh nats://queue.example:4222
#
# More arguments go to each worker. Ends when no case has come for five minutes. A worker that
# Slurm stops, for the time limit or a job of higher priority, gives its case back.
#SBATCH --job-name=signorini-workers
#SBATCH --ntasks=16
#SBATCH --cpus-per-task=1
#SBATCH --mem-per-cpu=2G
#SBATCH --time=04:00:00
# To the workers, a minute before the end.
#SBATCH --signal=INT@60
#SBATCH --requeue
set -euo pipefail

queue=${1:-${SIGNORINI_QUEUE:-}}
if [[ -z $queue ]]; then
    echo "usage: sbatch workers.sh nats://HOST:PORT [ARGUMENT OF signorini worker]..." >&2
    exit 2
fi
shift || true
threads=${SLURM_CPUS_PER_TASK:-1}
# One that fails leaves the others at work.
exec srun --kill-on-bad-exit=0 --cpus-per-task="$threads" \
    "${SIGNORINI_PROGRAM:-signorini}" worker --queue "$queue" --threads "$threads" --idle 300 "$@"
