#!/usr/bin/env bash
# A laboratory's day, as typed in a folder that holds nothing: relative paths, two surfaces, a bad picture of the board, a
# stop and a resume, a correction, the report in both formats.
set -euo pipefail
trap 'status=$?; set +e; jobs -p | xargs -r kill; wait; exit $status' EXIT
export STROBE_GPIOCHIP_DIR=chip

for surface in hard soft; do
  printf 'inherits = "zero_23"\n[camera]\npx_per_m = 2000\n' > $surface.toml
done
printf '[bounce]\ne = 0.80\n' >> soft.toml

# Morning: the camera. One of the pictures is not of the board.
strobe-sim board --scene hard.toml --spacing-mm 70 --slanted 4 --out board
strobe-sim photograph --scene hard.toml --shots 1 --seed 3 --out wrong
mv wrong/*.tif board/slanted_9.tif
for surface in hard soft; do
  strobe-sim run --scene $surface.toml --photographs camera --write-rig $surface-rig.toml
  sed -i 's/^\[camera\]/&\ncalibration = "camera.toml"/; s/^operator = .*/operator = "A. Author"/' $surface-rig.toml
done
strobe calibrate board/plane.tif board/slanted_*.tif --spacing-mm 70 --rig hard-rig.toml 2> calibrate.log

# The first surface, stopped in between and gone on with.
strobe-sim run --scene hard.toml --seed 1 --photographs camera -- \
  strobed --config hard-rig.toml --session hard --allow-no-rt 2> hard-rig.log &
rig=$!
strobe-sim join -- strobe fire --until 5 --retries 20 --rig hard-rig.toml --session hard --spin zero --angle 23 &
fire=$!
while kill -0 $fire && [ "$(cat hard/results.csv | wc -l)" -le 2 ]; do sleep 0.2; done 2> /dev/null
kill -INT $fire
wait $fire && echo "was not stopped" >&2 && exit 1
strobe-sim join -- strobe fire --resume --session hard
kill $rig; wait $rig || true

# The second one, in the afternoon.
strobe-sim run --scene soft.toml --seed 2 --photographs camera -- \
  strobed --config soft-rig.toml --session soft --allow-no-rt 2> soft-rig.log &
rig=$!
strobe-sim join -- strobe fire --shots 4 --retries 20 --rig soft-rig.toml --session soft --spin zero --angle 23
kill $rig; wait $rig || true

# An image put right by hand.
cat > corrections.toml <<'END'
[[remove]]
at_px = [1890, 588]
END
strobe shot hard 3 --edit corrections.toml
strobe replay hard --results

# Evening. The printer of PDF is one of the packages for tests.
strobe report hard soft --json > report.json
strobe report hard soft --out report.html --pdf
