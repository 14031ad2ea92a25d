#!/bin/sh
# tests/decoders.sh CELFX: what celfx writes, read by OpenImageIO and by the Cryptomatte API, and its views beside OpenColorIO's.
# All are Python packages, put into a folder of their own that is removed; without them a line says that this is skipped.
set -eu
celfx=$(realpath "$1")
cd "$(dirname "$0")"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT INT TERM

if ! { python3 -m venv "$folder/python" &&
    "$folder/python/bin/pip" install -q numpy OpenImageIO cryptomatte-api OpenColorIO; } >"$folder/log" 2>&1; then
    echo "SKIPPED: decoders: no Python with OpenImageIO, cryptomatte-api and OpenColorIO: $(tail -n 1 "$folder/log")"
    exit 0
fi
"$folder/python/bin/python" decoders.py "$celfx" "$folder"
