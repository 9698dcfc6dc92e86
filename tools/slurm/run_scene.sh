#!/bin/sh
# One scene, in as many jobs as it takes: each goes on from the checkpoint that the one before left.
#
#   sbatch --time 24:00:00 tools/slurm/run_scene.sh SCENE CHECKPOINT STEPS [OPTION...]
#
# STEPS from checkpoint to checkpoint; OPTION: what `dvdx run` takes, such as --out. DVDX: the command, `dvdx` where not set. LAUNCH:
# what starts it, such as srun. Without slurm it runs here and is started again, at most RETRIES times (10), where it was ended
# by a signal.
#SBATCH --job-name=dvdx
#SBATCH --open-mode=append
set -u
if [ $# -lt 3 ]; then
  echo "usage: $0 SCENE CHECKPOINT STEPS [OPTION...]" >&2
  exit 2
fi
scene=$1
checkpoint=$2
steps=$3
shift 3

# The job that comes next is queued first, so that it is there however this one ends; it is taken back where it is not needed.
next=
if [ -n "${SLURM_JOB_ID:-}" ]; then
  script=$(scontrol show job "$SLURM_JOB_ID" | sed -n 's/^ *Command=\([^ ]*\).*/\1/p')
  next=$(sbatch --parsable --dependency="afternotok:$SLURM_JOB_ID" "$script" "$scene" "$checkpoint" "$steps" "$@")
fi

run() {
  if [ -e "$checkpoint" ]; then
    ${LAUNCH:-} "${DVDX:-dvdx}" run "$scene" --checkpoint "$checkpoint" --checkpoint-every "$steps" --resume "$checkpoint" "$@"
  else
    ${LAUNCH:-} "${DVDX:-dvdx}" run "$scene" --checkpoint "$checkpoint" --checkpoint-every "$steps" "$@"
  fi
}

tries=0
while :; do
  run "$@"
  status=$?
  tries=$((tries + 1))
  # Codes up to 6 are those of dvdx: it is done, or would fail again.
  if [ "$status" -le 6 ]; then
    if [ -n "$next" ]; then scancel "$next"; fi
    exit "$status"
  fi
  if [ -n "${SLURM_JOB_ID:-}" ] || [ "$tries" -gt "${RETRIES:-10}" ]; then exit "$status"; fi
done
