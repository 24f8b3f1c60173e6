#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# example_sensor.sh SOURCES BUILD: adds the example of docs/adding-an-element.md, "A sensor", to a
# copy of the sources by the steps that stand there and no other, builds the program, and renders
# with the new sensor. The copy stays in BUILD, so that only changes are compiled again.
set -euo pipefail
sources=$1 example=$1/tests/example copy=$2/example_sensor
export LC_ALL=C.UTF-8

fail() {
    echo "example_sensor: $1" >&2
    exit 1
}

# after FILE LINE TEXT: puts TEXT behind the first line that holds LINE, which must be there.
after() {
    grep -qF -- "$2" "$tree/$1" ||
        fail "$1 has no line with '$2': docs/adding-an-element.md is for other sources"
    LINE=$2 TEXT=$3 awk '{ print } !done && index($0, ENVIRON["LINE"]) { print ENVIRON["TEXT"]; done = 1 }' "$tree/$1" >"$tree/edited"
    mv "$tree/edited" "$tree/$1"
}

tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
cp -r "$sources"/{CMakeLists.txt,include,host,kernels,tools} "$tree"

# 1. The header.
cp "$example/line_scan.h" "$tree/include/mcvisi/sensors/"
# 2. Two short functions.
cat "$example/sensors.c" >>"$tree/host/scene/sensors.c"
# 3. A line in the list, and the header's #include on both sides.
# shellcheck disable=SC1003 # the backslash is C's
after include/mcvisi/elements.h 'X(pinhole, "pinhole", PINHOLE)' '    X(line_scan, "lineScan", LINE_SCAN) \'
after host/scene/elements.h '#include "mcvisi/sensors/light_field.h"' '#include "mcvisi/sensors/line_scan.h"'
after kernels/world.h '#define MCV_JOIN(a, b, c)' '#ifdef MCV_SENSOR_line_scan
#include "mcvisi/sensors/line_scan.h"
#endif'
# The model once more, in the reference renderer.
awk -v file="$example/sensor_ray.c" '/^ref_sensor_ray ref_sensor_ray_sample/ { while ((getline line < file) > 0) print line } { print }
    /^    switch \(sensor->type\)/ { print "    case MCV_SENSOR_LINE_SCAN:\n        return line_scan(sensor, column, row, x, y);" }' \
    "$tree/host/reference/sensor_ray.c" >"$tree/edited"
mv "$tree/edited" "$tree/host/reference/sensor_ray.c"

# Only what differs is copied, so that the build sees what changed.
mkdir -p "$copy"
(cd "$tree" && find . -type f) | while read -r file; do
    cmp -s "$tree/$file" "$copy/$file" || install -D -m 644 "$tree/$file" "$copy/$file"
done
[ -f "$copy/b/build.ninja" ] || cmake -S "$copy" -B "$copy/b" -G Ninja -DMCV_TESTS=OFF -DCMAKE_BUILD_TYPE=None \
    -DCMAKE_C_FLAGS=-O0 -DCMAKE_CXX_FLAGS=-O0 >"$copy/configure.log"
cmake --build "$copy/b" --target mcvisi_program >"$copy/build.log" || {
    tail -20 "$copy/build.log"
    fail "the sources with the example do not build"
}
mcvisi=$copy/b/mcvisi
scene=$example/line_scan.gltf
cd "$copy"

# Its 100 columns see 10 mm at 0.2 m and 20 mm at 0.4 m; its 100 rows 10 mm at any depth. The square of 5 mm and radiance 8 lies inside and fills
# a quarter and an eighth, whole pixels: a sample within rounding of an edge may fall to either side, 1e-5 of them at most.
for sensor in line:2 line-2:1; do
    "$mcvisi" render "$scene" --sensor "${sensor%:*}" --spp 64 -o device.exr --png device.png --parts replicates --replicates 16 --seed 1 --json >device.json
    "$mcvisi" render "$scene" --sensor "${sensor%:*}" --spp 64 -o reference.exr --png reference.png --parts replicates --replicates 16 --seed 2 \
        --device reference --json >reference.json
    "$mcvisi" compare device.exr reference.exr >compare.txt || fail "$sensor: device and reference differ: $(sed -n 2p compare.txt)"
    for result in device.json reference.json; do
        mean=$(sed -n 's/.*"mean": *\([0-9.e+-]*\).*/\1/p' $result | head -1)
        awk -v mean="$mean" -v truth="${sensor#*:}" 'BEGIN { exit !(mean > (1 - 1e-5) * truth && mean < (1 + 1e-5) * truth) }' ||
            fail "$sensor, $result: the mean is $mean instead of ${sensor#*:}"
    done
done

# What follows from the parameter list.
"$mcvisi" check "$scene" | grep -q 'linePitch.*100 µm' || fail "check does not print linePitch"
expect_refusal() {
    ! "$mcvisi" check "$scene" --set "$1" 2>refusal.txt >/dev/null || fail "$1 is not refused"
    grep -qF -- "$2" refusal.txt || fail "$1 is refused with: $(cat refusal.txt)"
}
expect_refusal sensors/line/linePich=1 'unknown key "linePich": did you mean "linePitch"?'
expect_refusal sensors/line/linePitch=0 'sensors/line/linePitch: 0 must be above 0'
expect_refusal sensors/line/radiometry=irradiance 'sensors/line/radiometry: a line scan camera has no aperture'
echo "the example sensor works"
