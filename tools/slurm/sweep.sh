#!/bin/sh
# One scene with many values: a run for each line of a file, each with its own report.
#
#   sbatch --array 1-$(wc -l < values.txt) tools/slurm/sweep.sh SCENE values.txt REPORTS
#
# A line holds options of `dvdx run`, parted by blanks: --seed 7 --set forces[0].stiffness=40. Run n writes REPORTS/n.json, which is
# there whole or not at all, and is not run again where it is there. Without slurm all lines run here, one after the other. DVDX: the
# command, `dvdx` where not set.
#SBATCH --job-name=dvdx-sweep
set -u
if [ $# -ne 3 ]; then
  echo "usage: $0 SCENE VALUES REPORTS" >&2
  exit 2
fi
scene=$1
values=$2
reports=$3
mkdir -p "$reports" || exit 4

# run_line N
run_line() {
  if [ -e "$reports/$1.json" ]; then return 0; fi
  options=$(sed -n "$1p" "$values")
  set -f # brackets of a path stand for themselves
  # shellcheck disable=SC2086
  "${DVDX:-dvdx}" run "$scene" $options --json > "$reports/.$1.part"
  status=$?
  set +f
  # A run that diverged (5) has a report too.
  if [ "$status" -eq 0 ] || [ "$status" -eq 5 ]; then mv "$reports/.$1.part" "$reports/$1.json"; else rm -f "$reports/.$1.part"; fi
  return "$status"
}

if [ -n "${SLURM_ARRAY_TASK_ID:-}" ]; then
  run_line "$SLURM_ARRAY_TASK_ID"
  exit
fi
worst=0
lines=$(wc -l < "$values")
n=1
while [ "$n" -le "$lines" ]; do
  run_line "$n" || worst=$?
  n=$((n + 1))
done
exit "$worst"
