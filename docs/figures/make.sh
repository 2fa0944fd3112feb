#!/usr/bin/env bash
# Draws the pictures of the README: photographs the two pages of `./go demo`, or the plan's and the flight's page given,
# light and dark. Needs chromium and pngquant; the pictures are nicest with the font Inter installed.
set -euo pipefail

figures=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
out=$figures/../../out
plan=$(realpath -m "${1:-$out/demo.html}")
flight=$(realpath -m "${2:-$out/demo_flight.html}")
moment='t=24.5&follow'

# photograph PAGE NAME HEIGHT PLACE: the page's upper HEIGHT, opened at PLACE, as NAME-light.png and NAME-dark.png.
photograph() {
  [[ -f $1 ]] || { echo "$1 is missing: run ./go demo first" >&2; exit 1; }
  local theme picture
  for theme in light dark; do
    picture=$figures/$2-$theme.png
    chromium --headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --hide-scrollbars \
      --force-device-scale-factor=1.25 --window-size="1280,$3" --virtual-time-budget=8000 \
      --screenshot="$picture" "file://$1#theme=$theme$4" 2>/dev/null
    pngquant --force --skip-if-larger --quality=70-95 --output "$picture" "$picture" || true  # or as it was
    echo "$picture"
  done
}

photograph "$plan" demo 1552 ''
photograph "$flight" demo-flight 1420 "&$moment"
