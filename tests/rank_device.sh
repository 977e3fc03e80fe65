#!/bin/sh
# rank_device.sh FOLDER FAKE_CUDA COMMAND...: what a rank runs on a device of its own without hardware (cuda_device.py)
FAKE_CUDA_DIR="$1/device-${PMI_RANK:-${OMPI_COMM_WORLD_RANK:-0}}"
FAKE_CUDA_LOG="$FAKE_CUDA_DIR/calls"
fake="$2"
shift 2
mkdir -p "$FAKE_CUDA_DIR"
export FAKE_CUDA_DIR FAKE_CUDA_LOG
exec sh "$fake" "$@"
