#!/usr/bin/env bash
# Draws the pictures of the README: plans the demo's flight and photographs its report, light and dark.
# Needs `./go demo` (the program and out/demo.swm) and chromium; the pictures are nicest with the font Inter installed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

report=out/demo.html
[[ -f $report ]] || { echo "$report is missing: run ./go demo first" >&2; exit 1; }

for theme in light dark; do
  picture=docs/figures/demo-$theme.png
  chromium --headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --hide-scrollbars \
    --force-device-scale-factor=1.5 --window-size=1280,1552 --virtual-time-budget=8000 \
    --screenshot="$picture" "file://$PWD/$report#theme=$theme" 2>/dev/null
  echo "$picture"
done
