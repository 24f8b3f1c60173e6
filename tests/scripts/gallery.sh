#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# gallery.sh MCVISI GALLERY SOURCES FOLDER: what `gallery draw` makes of renders of a wrong size: a sentence.
set -eu
mcvisi=$1
gallery=$2
cd "$3"
folder=$4/gallery
failures=0
rm -rf "$folder"
mkdir -p "$folder/small" "$folder/pictures"
"$mcvisi" render scenes/scratch.gltf --resolution 5x4 --spp 4 -o "$folder/small.exr" \
    --png "$folder/small.png" >/dev/null 2>&1
"$gallery" list | while read -r stem _; do
    ln "$folder/small.exr" "$folder/small/$stem.exr"
    ln "$folder/small.png" "$folder/small/$stem.png"
done

# expect WHAT RENDERS SENTENCE
expect() {
    code=0
    "$gallery" draw "$2" "$folder/pictures" >"$folder/section.md" 2>"$folder/errors" || code=$?
    if [ "$code" != 3 ] || ! grep -q "$3" "$folder/errors"; then
        echo "$1: exit $code, not 3 with '$3':"
        cat "$folder/errors"
        failures=$((failures + 1))
    fi
}
expect "renders of 5 x 4 pixels" "$folder/small" "is of 5 x 4 pixels"
exit $failures
