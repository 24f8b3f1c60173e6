#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# examples.sh SOURCES BUILD: adds the examples of docs/adding-an-element.md to a copy of the sources
# by the steps that stand there and no others, builds the program, and renders with the new
# elements. The copy stays in BUILD, so that only changes are compiled again.
set -euo pipefail
sources=$1 examples=$1/tests/example copy=$2/examples
export LC_ALL=C.UTF-8
most_files=6 # that one element touches

fail() {
    echo "examples: $1" >&2
    exit 1
}

# The copy's file that a step touches.
touches() {
    touched+=("$1")
}

# add FILE EXAMPLE: a new file.
add() {
    touches "$1"
    [ ! -e "$tree/$1" ] || fail "$1 is there already"
    cp "$examples/$2" "$tree/$1"
}

# put after|before FILE LINE TEXT: TEXT behind or in front of the first line that holds LINE, which
# must be there.
put() {
    touches "$2"
    grep -qF -- "$3" "$tree/$2" ||
        fail "$2 has no line with '$3': docs/adding-an-element.md is for other sources"
    WHERE=$1 LINE=$3 TEXT=$4 awk '
        function text() { print ENVIRON["TEXT"]; done = 1 }
        { found = !done && index($0, ENVIRON["LINE"]) }
        found && ENVIRON["WHERE"] == "before" { text() }
        { print }
        found && ENVIRON["WHERE"] == "after" { text() }' "$tree/$2" >"$tree/edited"
    mv "$tree/edited" "$tree/$2"
}

after() { put after "$@"; }

before() { put before "$@"; }

# element NAME FUNCTION: the steps, which touch few files.
element() {
    touched=()
    "$2"
    local count
    count=$(printf '%s\n' "${touched[@]}" | sort -u | wc -l)
    [ "$count" -le $most_files ] || fail "a new $1 touches $count files, more than $most_files"
    echo "a new $1 touches $count files"
}

# shellcheck disable=SC1003 # the backslash is C's
add_sensor() {
    # 1. The header.
    add include/mcvisi/sensors/crossed_slits.h sensor/crossed_slits.h
    # 2. Two short functions.
    touches host/scene/sensors.c
    cat "$examples/sensor/sensors.c" >>"$tree/host/scene/sensors.c"
    # 3. A line in the list, and the header's #include.
    after include/mcvisi/elements.h 'X(pinhole, "pinhole", PINHOLE)' '    X(crossed_slits, "crossedSlits", CROSSED_SLITS) \'
    before include/mcvisi/elements.h '#if !MCV_ON_DEVICE || defined(MCV_SENSOR_thin_lens)' \
        '#if !MCV_ON_DEVICE || defined(MCV_SENSOR_crossed_slits)
#include "mcvisi/sensors/crossed_slits.h"
#endif'
    # 4. The model once more, in the reference renderer.
    before host/reference/sensor_ray.c 'ref_sensor_ray ref_sensor_ray_sample' "$(cat "$examples/sensor/sensor_ray.c")"
    after host/reference/sensor_ray.c '    switch (sensor->type)' \
        '    case MCV_SENSOR_CROSSED_SLITS:
        return crossed_slits(sensor, column, row, x, y);'
}

# material NAME TYPE FOLDER LIST BESIDE: the steps that all materials have in common. BESIDE: whose
# header's #include the new one follows.
material() {
    local name=$1 type=$2 folder=$3 list=$4 beside=$5
    # 1. The header.
    add "include/mcvisi/materials/$name.h" "$folder/$name.h"
    # 2. A line in the list, and the header's #include.
    after include/mcvisi/elements.h "#define $list(X)" "    X($name, \"$type\", ${name^^}) \\"
    after include/mcvisi/elements.h "#include \"mcvisi/materials/$beside.h\"" \
        "#include \"mcvisi/materials/$name.h\""
    # 3. What the device needs of it.
    before host/device/pack_materials.c '    case MCV_MATERIAL_MIRROR:' \
        "$(cat "$examples/$folder/pack_materials.c")"
    # 4. Its functions on the device.
    add "kernels/bsdf/$name.h" "$folder/bsdf.h"
    # 5. The #include of that file.
    after kernels/bsdf/bsdf.h '#include "bsdf/diffuse.h"' "#include \"bsdf/$name.h\""
}

# scatterer NAME TYPE FOLDER ASSIGNMENTS: a scattering material, whose functions in the reference
# renderer the ASSIGNMENTS name.
scatterer() {
    material "$1" "$2" "$3" MCV_OWN_BSDFS retroreflector
    # 6. The model once more, in the reference renderer.
    before host/reference/path_surface.c 'bool ref_meet_surface' \
        "$(cat "$examples/$3/path_surface.c")"
    before host/reference/path_surface.c '    case MCV_MATERIAL_DIELECTRIC:' \
        "    case MCV_MATERIAL_${1^^}: {
        ref_scatterer s = scatterer_at(world, p, surface);
        $4
        return ref_scatter(world, p, surface, &s, last, random, tally, radiance);
    }"
}

add_material() {
    scatterer lunar_lambert lunarLambert material 's.evaluate = evaluate_lunar_lambert;'
}

add_film() {
    scatterer diffusing_film diffusingFilm film \
        's.evaluate = evaluate_diffusing_film; s.sample = sample_diffusing_film;'
}

add_plate() {
    material filter_glass filterGlass plate MCV_PLATES beam_splitter
    # 6. The model once more, in the reference renderer.
    before host/reference/plate.c '    case MCV_MATERIAL_BEAM_SPLITTER: {' \
        "$(cat "$examples/plate/plate.c")"
}

# shellcheck disable=SC1003 # the backslash is C's
add_interface() {
    material ground_glass groundGlass interface MCV_OWN_BSDFS retroreflector
    # 2. A line in the list of those that fill a body.
    after include/mcvisi/elements.h '#define MCV_MEDIUM_MATERIALS(X)' \
        '    X(ground_glass, "groundGlass", GROUND_GLASS) \'
    # 6. The model once more, in the reference renderer.
    before host/reference/path_surface.c '    case MCV_MATERIAL_DIELECTRIC:' \
        "$(cat "$examples/interface/path_surface.c")"
}

# shellcheck disable=SC1003
add_emitter() {
    # 1. The header.
    add include/mcvisi/emitters/led.h emitter/led.h
    # 2. A line in the list, and the header's #include.
    after include/mcvisi/elements.h '#define MCV_POINT_LIGHTS(X)' '    X(led, "led", LED) \'
    after include/mcvisi/elements.h '#include "mcvisi/emitters/directional.h"' '#include "mcvisi/emitters/led.h"'
    # 3. Its power.
    before host/scene/emitters.c '    case MCV_EMITTER_SPOT: /* 1 - cosθ' "$(cat "$examples/emitter/emitters.c")"
    before host/scene/emitters.c '    if (mcv_emitter_is_surface_light(emitter->type)) return 2 * M_PI;' \
        '    if (emitter->type == MCV_EMITTER_LED) return 2 * M_PI;'
    # 4. What the device needs of it.
    before host/scene/emitters_device.c '    if (emitter->type == MCV_EMITTER_SPOT) {' \
        "$(cat "$examples/emitter/emitters_device.c")"
    # 5. The model once more, in the reference renderer.
    before host/reference/lights.c '    case MCV_EMITTER_SPOT: {' "$(cat "$examples/emitter/lights.c")"
}

# shellcheck disable=SC1003
add_surface_light() {
    # 1. The header.
    add include/mcvisi/emitters/led_panel.h surface_light/led_panel.h
    # 2. A line in the list, and the header's #include.
    after include/mcvisi/elements.h '#define MCV_SURFACE_LIGHTS(X)' '    X(led_panel, "ledPanel", LED_PANEL) \'
    after include/mcvisi/elements.h '#include "mcvisi/emitters/area.h"' '#include "mcvisi/emitters/led_panel.h"'
    # 3. Its exitance.
    before host/scene/emitters.c '    const double beta = mcv_emitter_half_angle(emitter);' \
        "$(cat "$examples/surface_light/emitters.c")"
    # 4. What the device needs of it.
    after host/scene/emitters_device.c '*device = (mcv_surface_light)' \
        "$(cat "$examples/surface_light/emitters_device.c")"
    # 5. The model once more, in the reference renderer.
    before host/reference/emission.c '    case MCV_EMITTER_PARALLEL:' "$(cat "$examples/surface_light/emission.c")"
}

tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
cp -r "$sources"/{CMakeLists.txt,include,host,kernels,tools} "$tree"
element sensor add_sensor
element "light without extent" add_emitter
element "emitter with a surface" add_surface_light
element "reflecting material" add_material
element "scattering film" add_film
element plate add_plate
element "refracting material" add_interface

# Only what differs is copied, so that the build sees what changed; what is gone goes.
mkdir -p "$copy"
(cd "$tree" && find . -type f) | while read -r file; do
    cmp -s "$tree/$file" "$copy/$file" || install -D -m 644 "$tree/$file" "$copy/$file"
done
(cd "$copy" && find host include kernels tools -type f) | while read -r file; do
    [ -e "$tree/$file" ] || rm "$copy/$file"
done
[ -f "$copy/b/build.ninja" ] || cmake -S "$copy" -B "$copy/b" -G Ninja -DMCV_TESTS=OFF -DCMAKE_BUILD_TYPE=None \
    -DCMAKE_C_FLAGS=-O0 -DCMAKE_CXX_FLAGS=-O0 >"$copy/configure.log"
cmake --build "$copy/b" --target mcvisi_program >"$copy/build.log" || {
    tail -20 "$copy/build.log"
    fail "the sources with the examples do not build"
}
mcvisi=$copy/b/mcvisi
cd "$copy"

# expect SCENE SENSOR SPP TRUTH TOLERANCE [REFERENCE]: both renderers have that mean, and the same
# picture. REFERENCE: the reference renderer's tolerance, where it has more noise. `settings` change
# the scene.
settings=()
expect() {
    local result mean off
    local render=("$mcvisi" render "$1" --sensor "$2" --spp "$3" "${settings[@]}" --json
        --parts replicates --replicates 16)
    "${render[@]}" -o device.exr --png device.png --seed 1 >device.json
    "${render[@]}" -o reference.exr --png reference.png --seed 2 --device reference >reference.json
    for result in device.json reference.json; do
        mean=$(sed -n 's/.*"mean": *\([0-9.e+-]*\).*/\1/p' $result | head -1)
        off=$([ $result = device.json ] && echo "$5" || echo "${6:-$5}")
        awk -v mean="$mean" -v truth="$4" -v off="$off" 'BEGIN { exit !(mean > truth - off && mean < truth + off) }' ||
            fail "$2, $result: the mean is $mean instead of $4, by more than $off"
    done
    "$mcvisi" compare device.exr reference.exr >compare.txt ||
        fail "$2: device and reference differ: $(sed -n 2p compare.txt)"
}

# expect_check SCENE PATTERN
expect_check() {
    "$mcvisi" check "$1" >check.txt
    grep -q -- "$2" check.txt || fail "$1: check does not print '$2'"
}

# expect_refusal SCENE SETTING SENTENCE
expect_refusal() {
    ! "$mcvisi" check "$1" --set "$2" 2>refusal.txt >/dev/null || fail "$2 is not refused"
    grep -qF -- "$3" refusal.txt || fail "$2 is refused with: $(cat refusal.txt)"
}

# --- the camera with crossed slits ---

# Its 100 columns see 10 mm at 0.2 m and 30 mm at 0.6 m; its 100 rows, whose slit lies 0.1 m ahead,
# 10 mm and 50 mm. The square of 6 mm and radiance 8 fills 60 x 60 and 20 x 12 whole pixels: a sample
# within rounding of an edge may fall to either side, 1e-5 of them at most.
scene=$examples/sensor/crossed_slits.gltf
expect "$scene" slits 64 2.88 8e-5
expect "$scene" slits-2 64 0.192 8e-5
# What follows from the parameter list.
expect_check "$scene" 'slitDistance.*100 mm'
expect_refusal "$scene" sensors/slits/slitDistanc=1 \
    'unknown key "slitDistanc": did you mean "slitDistance"?'
expect_refusal "$scene" sensors/slits/slitDistance=0 'sensors/slits/slitDistance: 0 must be above 0'
expect_refusal "$scene" sensors/slits/radiometry=irradiance \
    'sensors/slits/radiometry: a camera with slits has no aperture'

# --- the LED ---

# Its power of π/2 with n = 3 is I = 1. A plate of reflectance 1/2 at the distance h = 0.1 m on the
# axis has the irradiance I/h²; one at 60°, at 2 h and turned by as much, I cos³(60°) cos(60°)/(4 h²).
# No sample has noise. Over the field of a = 0.16 mm to either side the mean differs by the second
# order, less than (n + 3)²/2 (a/h)² = 4.6e-5 of it.
scene=$examples/emitter/led.gltf
expect "$scene" camera 16 "$(awk 'BEGIN { print 50 / atan2(0, -1) }')" 7.4e-4
expect "$scene" camera-2 16 "$(awk 'BEGIN { print 50 / 64 / atan2(0, -1) }')" 1.2e-5
expect_check "$scene" 'intensity  *1 W/sr'
expect_refusal "$scene" emitters/led/exponent=0 'emitters/led/exponent: 0 must be an integer from 1 to 127'

# --- the LED panel ---

# n = 4. Its power of 2π/5 W from 1 mm² is L = 1e6, I = 1. Cameras see L, and L cos³(60°), whose mean
# over a pupil of 1 mrad differs by less than 1e-5. The plates get what the LED would give them with
# n = 4; by the panel's and the field's extent of ρ = 1 mm together the mean differs by the second
# order, less than (n + 3)²/2 (ρ/d)², and a sample by less than (n + 3) ρ/d: of 32 x 32 x 16 samples
# five standard errors are 5/128 of it. d = 0.1 and 0.2 m: 5.2e-3 and 2.0e-3.
scene=$examples/surface_light/led_panel.gltf
expect "$scene" camera 16 1e6 10
expect "$scene" camera-2 16 1.25e5 1.25
expect "$scene" camera-3 16 "$(awk 'BEGIN { print 50 / atan2(0, -1) }')" 8.3e-2
expect "$scene" camera-4 16 "$(awk 'BEGIN { print 50 / 128 / atan2(0, -1) }')" 2.5e-4
expect_check "$scene" 'radiance  *1e+06 W/(m² sr)'
expect_refusal "$scene" emitters/panel/halfPowerAngle=1.2 'emitters/panel/halfPowerAngle: 1.2 must lie from'

# --- the Lunar-Lambert reflector ---

# The sun has E = π and c_i = 1/2, the sky radiance 1: with l = 3/4 the radiance is
#     0.8 ((l/(2 (1/2 + c_o)) + 1 - l)/2 + l (1 - c_o ln((1 + c_o)/c_o)) + 1 - l).
# The sun's share has no noise. A sample of the sky is between 0.8 (l/(2 (1 + c_o)) + 1 - l) and
# 0.8 (l/(2 c_o) + 1 - l), a range of 0.15 and 0.4, and no value deviates from its mean by more than
# half of its range, root mean square: of 32 x 32 x 64 samples five standard errors are 5/256 of it.
scene=$examples/material/lunar_lambert.gltf
expect "$scene" camera 64 "$(awk 'BEGIN { print 0.8 * (0.25 + 0.75 * (1 - log(2)) + 0.25) }')" 0.00146
expect "$scene" camera-2 64 "$(awk 'BEGIN { print 0.8 * (0.3125 + 0.75 * (1 - log(3) / 2) + 0.25) }')" 0.0039
expect_check "$scene" 'lunar  *0.75'
expect_refusal "$scene" materials/powder/lunar=2 'materials/powder/lunar: 2 must lie from 0 to 1'

# --- the diffusing film ---

# It passes T = 0.8 about the way straight on, with a = tan(30°) = √(1/3). Of the sky's radiance 1
# the camera sees T times the mean cosine of these directions, 1/b - (1 - b) artanh(√b)/b^(3/2)
# with b = 1 - a². The sun has E = π and stands 60° off: T π p(60°) cos(60°) = T 3/25. Its share has
# no noise. A sample of the sky is between 0 and 0.8: of 32 x 32 x 64 five standard errors are 5/512
# of it.
scene=$examples/film/diffusing_film.gltf
expect "$scene" camera 64 "$(awk 'BEGIN { b = 2 / 3; s = sqrt(b)
    print 0.8 * (1 / b - (1 - b) * log((1 + s) / (1 - s)) / 2 / (b * s) + 3 / 25) }')" 0.0078
expect_check "$scene" 'transmittance  *0.8'

# --- the filter glass ---

# The screen has the radiance 1. With Fresnel's R and τ = 0.1^(1/cosθ') the cameras see T at 0° and
# at 60°, and what is reflected at 60°. The device has no noise: it follows both ways. Over the pupil
# of 1 mrad the mean differs by less than 1e-6. The reference chooses one way: a sample is 0 or T + R,
# 0.14 at most; of such coins five standard errors are 5/512 of it for 32 x 32 x 64 samples.
filter() {
    awk -v c="$1" -v way="$2" 'BEGIN {
        n = 1.5; b = sqrt(1 - (1 - c * c) / (n * n)); tau = exp(log(0.1) / b)
        r = (((c - n * b) / (c + n * b))^2 + ((n * c - b) / (n * c + b))^2) / 2
        t = (1 - r)^2 * tau / (1 - (r * tau)^2)
        printf "%.9g", way == "passed" ? t : r * (1 + t * tau) }'
}
scene=$examples/plate/filter_glass.gltf
expect "$scene" camera 64 "$(filter 1 passed)" 1e-6 1.4e-3
expect "$scene" camera-2 64 "$(filter 0.5 passed)" 1e-6 1.4e-3
expect "$scene" camera-3 64 "$(filter 0.5 reflected)" 1e-6 1.4e-3
expect_check "$scene" 'internalTransmittance  *0.1'
expect_refusal "$scene" materials/filter/ior=0.9 'materials/filter/ior: 0.9 must lie from 1 to 10'

# --- the ground glass ---

# With the reflectance ρ = 1/4, T = 1 - ρ and n = 1.5, light leaves the glass with the share
# q = T/n². In the ball each wall element lights all others evenly. Without absorption the sky's
# radiance 1 stays 1. The sun, E = π, sends T E π R² into the ball, whose wall then has the
# irradiance T E/(4 q), and shines with T E/(4 π) = T/4 where the sun does not reach it. With x = 2 R
# times the absorption, a ray from wall to wall keeps τ = 2 (1 - (1 + x) exp(-x))/x² on average: the
# sky is then seen as ρ + T q τ/(1 - (1 - q) τ).
# A path meets the inner wall k times with the chance q (1 - q)^(k-1), each time q cosθ' of the sun,
# where cosθ' is 0 or more with the moments 1/4 and 1/6: the second moment of their sum is
# q²/6 k + q²/16 k (k - 1), on average q/6 + (1 - q)/8 = 0.14, a deviation of 0.38. Of
# 32 x 32 x 64 samples five standard errors are 5/256 of it. Under the absorbed sky a sample lies
# between 0 and 1, no further than 1/2 from its mean.
scene=$examples/interface/ground_glass.gltf
expect "$scene" camera 64 1.1875 0.0075
settings=(--set materials/glass/absorption=50 --set emitters/sun/irradiance=0)
expect "$scene" camera 64 "$(awk 'BEGIN { T = 0.75; q = T / 2.25; tau = 2 * (1 - 2 * exp(-1))
    print 0.25 + T * q * tau / (1 - (1 - q) * tau) }')" 0.0098
settings=()
expect_check "$scene" 'diffuseReflectance  *0.25'
expect_refusal "$scene" materials/glass/ior=0.9 'materials/glass/ior: 0.9 must lie from 1 to 10'
expect_refusal "$scene" materials/glass/priority=0.5 'materials/glass: priority 0.5 must be an integer'
echo "the examples work"
