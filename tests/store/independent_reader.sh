#!/bin/bash
# SPDX-License-Identifier: MIT
# Reads files of the library and golden files with an independent reader written from docs/format.md.
# Arguments: the test executable, a scratch folder, the source folder.
set -eu
tests=$1 folder=$2 source=$3
rm -rf "$folder"
mkdir -p "$folder"
STP_STORE_SAMPLE="$folder/sample" "$tests" store_writes_samples_for_another_reader > "$folder/log"
cp "$source"/tests/golden/store/v1/sample.stip "$folder/golden.stip"
cp "$source"/tests/golden/store/v1/sample.json "$folder/golden.json"
cp "$source"/tests/golden/store/v1/sample-1.1.stip "$folder/golden-1.1.stip"
cp "$source"/tests/golden/store/v1/sample-1.1.json "$folder/golden-1.1.json"
STP_STORE_SAMPLE="$folder/sample" "$tests" store_writes_chunks_for_another_reader >> "$folder/log"
STP_STORE_SAMPLE="$folder/sample" "$tests" store_writes_operators_for_another_reader >> "$folder/log"
cp "$source"/tests/golden/store/v1/sample-1.2.stip "$folder/golden-1.2.stip"
cp "$source"/tests/golden/store/v1/sample-1.2.json "$folder/golden-1.2.json"
cp "$source"/tests/golden/store/v1/packed-1.2.stip "$folder/packed.stip"
cp "$source"/tests/golden/store/v1/sample-1.2.json "$folder/packed.json"
cp "$source"/tests/golden/store/v1/clusters-1.1.stip "$folder/clusters.stip"
cp "$source"/tests/golden/store/v1/clusters-1.1.json "$folder/clusters.json"
cp "$source"/tests/golden/store/v1/pictures-1.2.stip "$folder/pictures.stip"
cp "$source"/tests/golden/store/v1/pictures-1.2.json "$folder/pictures.json"
cp "$source"/tests/golden/store/v1/methods-1.2.stip "$folder/methods.stip"
cp "$source"/tests/golden/store/v1/methods-1.2.json "$folder/methods.json"
cp "$source"/tests/golden/store/v1/operators-1.2.stip "$folder/operators.stip"
cp "$source"/tests/golden/store/v1/operators-1.2.json "$folder/operators.json"
cp "$source"/tests/golden/store/v1/attributes-1.2.stip "$folder/attributes.stip"
cp "$source"/tests/golden/store/v1/attributes-1.2.json "$folder/attributes.json"
cp "$source"/tests/golden/store/v1/levels-1.3.stip "$folder/levels.stip"
cp "$source"/tests/golden/store/v1/levels-1.3.json "$folder/levels.json"
count=0
for file in "$folder"/*.stip; do
    python3 "$source/scripts/read_store.py" "$file" --expect "${file%.stip}.json" > "${file%.stip}.out"
    count=$((count + 1))
done
# the first picture from ranges: golden files of all versions
for file in "$folder"/golden*.stip "$folder"/packed.stip; do
    python3 "$source/scripts/first_picture.py" "$file" -o "$folder/first.ppm" --size 64x48 > "$folder/first.json"
    python3 - "$folder" "$(stat -c %s "$file")" << 'END'
import json, sys
folder, size = sys.argv[1], int(sys.argv[2])
found = json.load(open(folder + "/first.json"))
assert 0 < found["bytes"] < size / 2, found
picture = open(folder + "/first.ppm", "rb").read()
assert len(picture) == len(b"P6 64 48 255\n") + 3 * 64 * 48 and len(set(picture[13:])) > 3
END
done
test "$count" -ge 19
# the check can fail: a wrong byte in the middle of the last file
size=$(stat -c %s "$file")
byte=$(od -An -tu1 -j $((size / 2)) -N 1 "$file")
printf "\\x$(printf %02x $((byte ^ 1)))" | dd of="$file" bs=1 seek=$((size / 2)) conv=notrunc status=none
if python3 "$source/scripts/read_store.py" "$file" > "$folder/damaged.out" 2>&1; then
    echo "a damaged file was accepted: $file"
    exit 1
fi
echo "$count files read"
