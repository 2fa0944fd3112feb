#!/usr/bin/env bash
# Draws the pictures of the README: photographs the report of `./go demo`, or the page given, light and dark.
# Needs chromium; the pictures are nicest with the font Inter installed.
set -euo pipefail

figures=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
report=$(realpath -m "${1:-$figures/../../out/demo.html}")
[[ -f $report ]] || { echo "$report is missing: run ./go demo first" >&2; exit 1; }

for theme in light dark; do
  picture=$figures/demo-$theme.png
  chromium --headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --hide-scrollbars \
    --force-device-scale-factor=1.25 --window-size=1280,1552 --virtual-time-budget=8000 \
    --screenshot="$picture" "file://$report#theme=$theme" 2>/dev/null
  echo "$picture"
done
