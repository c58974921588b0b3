#!/bin/sh
# Submits this job to Slurm: sh slurm.sh [OPTIONS OF sbatch]. What is done is left, so that the same command
# continues a job that stopped. RHYTID names the program on the machines.
set -eu
folder=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
export RHYTID_PROGRAM="${RHYTID:-rhytid}" RHYTID_FOLDER="$folder" RHYTID_STEP RHYTID_FIRST
most=$(scontrol show config | sed -n 's/^MaxArraySize *= *\([0-9]*\).*/\1/p')
mkdir -p "$folder/logs"

# submit STEP TASKS [OPTIONS]: submits arrays of at most $most tasks, and leaves their numbers in $numbers.
submit() {
    RHYTID_STEP=$1 tasks=$2 RHYTID_FIRST=0 numbers=
    shift 2
    while [ "$RHYTID_FIRST" -lt "$tasks" ]; do
        count=$((tasks - RHYTID_FIRST))
        [ "$count" -le "$most" ] || count=$most
        number=$(sbatch --parsable --requeue --array="0-$((count - 1))" --job-name="rhytid-$RHYTID_STEP" \
            --chdir="$folder" --output="logs/slurm-$RHYTID_STEP-%A-%a.txt" "$@" <<'TASK'
#!/bin/sh
exec "$RHYTID_PROGRAM" farm-task "$RHYTID_STEP" "$((SLURM_ARRAY_TASK_ID + RHYTID_FIRST))" \
    --job "$RHYTID_FOLDER/job.json"
TASK
        )
        numbers=$numbers:${number%%;*}
        RHYTID_FIRST=$((RHYTID_FIRST + count))
    done
    echo "rhytid: $RHYTID_STEP: $tasks tasks in the jobs ${numbers#:}"
}

