#!/usr/bin/env bash
# A Python environment with the MuJoCo wheel from PyPI, outside the repository.
set -euo pipefail
home="${STICKSLIP_MUJOCO_HOME:-${XDG_DATA_HOME:-$HOME/.local/share}/stickslip/mujoco}"
if [ ! -x "$home/bin/python" ]; then
    echo "making a Python environment in $home"
    python3 -m venv "$home"
fi
"$home/bin/python" -m pip install --quiet --upgrade "mujoco>=3.3,<5" "numpy>=1.26"
"$home/bin/python" -c 'import mujoco; print("MuJoCo", mujoco.__version__, "is ready")'
