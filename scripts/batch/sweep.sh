#!/usr/bin/env bash
#
# One shard of a sweep, as a task of a job array:
#
#   sbatch --array=1-SHARDS --time=TIME sweep.sh SHARDS SWEEP.nml [OPTION...]
#
# scripts/batch/submit fills this in, for Slurm, PBS, Grid Engine and LSF. OPTIONs go to `contensou sweep`.
# CONTENSOU names the executable if it is not on the PATH. A shard that is complete is skipped at once and
# one that was begun goes on where it was, so the same command may be given again after any trouble.
#
# Before the time limit USR1 comes (PBS: TERM at it): the program saves what it has and ends with status
# 75. Under Slurm the task then puts itself back into the queue, Grid Engine does so for status 99 and LSF
# for 75 (-Q); under PBS it is to be submitted again. A task that is cancelled stays cancelled.
# CONTENSOU_RESTARTS limits how often a task of Slurm is put back (default 50).
#
#SBATCH --job-name=sweep
#SBATCH --output=%x_%A_%a.log
#SBATCH --open-mode=append
#SBATCH --requeue
#SBATCH --signal=B:USR1@60
#SBATCH --nodes=1
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1

set -u

say() { printf '%(%F %T)T sweep.sh: %s\n' -1 "$*" >&2; }

# Which shard, on how many cores. Grid Engine says "undefined" where there is no array, LSF 0.
shard=${SLURM_ARRAY_TASK_ID:-${PBS_ARRAY_INDEX:-${CONTENSOU_SHARD:-}}}
[ -n "$shard" ] || shard=${SGE_TASK_ID:-${LSB_JOBINDEX:-}}
cores=${SLURM_CPUS_PER_TASK:-${NCPUS:-${NSLOTS:-${LSB_DJOB_NUMPROC:-1}}}}
if [ $# -lt 2 ] || ! [[ $shard =~ ^[1-9][0-9]*$ ]]; then
   say "use: sbatch --array=1-SHARDS --time=TIME sweep.sh SHARDS SWEEP.nml [OPTION...], or scripts/batch/submit"
   exit 2
fi
# PBS begins in the home folder.
if [ -n "${PBS_O_WORKDIR-}" ]; then cd -- "$PBS_O_WORKDIR" || exit 2; fi
shards=$1
shift
program=${CONTENSOU:-contensou}
if ! command -v -- "$program" >/dev/null; then
   say "there is no program $program; put contensou on the PATH or its full name into CONTENSOU"
   exit 2
fi
restarts=${SLURM_RESTART_COUNT:-0}
say "shard $shard of $shards on ${SLURMD_NODENAME:-$(hostname)}, restart $restarts"

# A signal that is for this script alone is passed on.
child=
asked=
cancelled=no
pass_on() {
   asked=$1
   [ -z "$child" ] || kill -s "$1" "$child" 2>/dev/null
}
trap 'pass_on USR1' USR1
trap 'cancelled=yes; pass_on TERM' TERM

"$program" sweep "$@" -j "$cores" --shard "$shard/$shards" &
child=$!
[ -z "$asked" ] || pass_on "$asked"

# Look now and then, and `wait` only for what has ended: bash 5.2 loses the status of a program that
# ends while a signal interrupts `wait`. A signal that comes during a nap is passed on after it.
nap=0.1
while kill -0 "$child" 2>/dev/null; do
   sleep "$nap"
   [ "$SECONDS" -lt 2 ] || nap=1
done
wait "$child"
status=$?

# 128 + USR1: the signal came before the program could handle it.
case $status in
75 | 138)
   # Slurm sends TERM to all of a task at once; let this script's own copy arrive.
   sleep 1
   if [ -n "${PBS_JOBID-}" ]; then
      say "cancelled or out of time; what is done is saved, submit again to go on"
   elif [ "$cancelled" = yes ]; then
      say "cancelled; what is done is saved, submit again to go on"
   elif [ -n "${SGE_TASK_ID-}" ]; then
      say "out of time; what is done is saved, and the task goes back into the queue"
      exit 99
   elif [ -n "${LSB_JOBINDEX-}" ]; then
      say "out of time; what is done is saved, and the task goes back into the queue"
      exit 75
   elif [ "$restarts" -ge "${CONTENSOU_RESTARTS:-50}" ]; then
      say "not complete after $restarts restarts; submit again to go on"
   else
      # Slurm may end this script before scontrol does.
      say "out of time; what is done is saved, and the task goes back into the queue"
      scontrol requeue "$SLURM_JOB_ID" ||
         say "the task could not be put back into the queue; submit again to go on"
   fi
   ;;
esac
exit "$status"
