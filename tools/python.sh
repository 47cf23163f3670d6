#!/usr/bin/env bash
# The Python wheel, and its tests in a virtual environment of its own. The environment is made anew where
# the pinned packages changed. PROFILE=release is cargo's profile.
set -euo pipefail
cd "$(dirname "$0")/.."
profile="${PROFILE:-release}"
here=target/python
pins=host/python/requirements.txt
python="$here/venv/bin/python"

if ! cmp -s "$pins" "$here/venv/pins"; then
    echo "python: making an environment in $here/venv"
    python3 -m venv --clear "$here/venv"
    "$python" -m pip install --quiet --disable-pip-version-check --requirement "$pins"
    cp "$pins" "$here/venv/pins"
fi

# `make lint` leaves this crate out.
PYO3_PYTHON="$PWD/$python" cargo clippy --quiet -p stickslip-python -- -D warnings
rm -rf "$here/wheels"
"$here/venv/bin/maturin" build --quiet --profile "$profile" --manifest-path host/python/Cargo.toml --out "$here/wheels" \
    --interpreter "$python"
"$python" -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps "$here"/wheels/*.whl
echo "python: $(ls "$here"/wheels)"

export PYTHONDONTWRITEBYTECODE=1
"$python" -m mypy --config-file host/python/pyproject.toml --cache-dir "$here/mypy"
cd host/python
exec "$OLDPWD/$python" -m pytest -q -p no:cacheprovider "$@"
