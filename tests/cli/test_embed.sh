#!/usr/bin/env bash
# An installed copy as embedded by programs: its files, the symbols of the shared library,
# self-contained headers, and the examples, built by pkg-config and by CMake and run. Arguments:
# executable, scratch folder, source folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
source=$3
build=$(dirname "$(dirname "$stipple")")
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
for program in cmake cc c++ nm readelf pkg-config python3; do
    installed $program "everything" || exit 77
done
skip_sanitizers
mkdir -p "$scratch"
cd "$scratch" || exit 1
prefix=$PWD/prefix
cmake --install "$build" --prefix "$prefix" > install.log 2>&1 || { cat install.log; fail "it cannot be installed"; exit 1; }
library=$(find "$prefix" -name 'libstipple.so.[0-9]*.*')
lib=$(dirname "$library")
for file in "$lib/libstipple.a" "$lib/libstipple.so" "$lib/pkgconfig/stipple.pc" "$lib/cmake/stipple/stipple-config.cmake" \
    "$lib/cmake/stipple/stipple-config-version.cmake" "$prefix/bin/stipple" "$prefix/share/man/man1/stipple.1"; do
    [ -e "$file" ] || fail "$file is not installed"
done
grep -rqF "$source" "$prefix/include" "$lib/pkgconfig" "$lib/cmake" && fail "installed files name the source folder"

# symbols: exactly what the headers declare, and no more than what they include
readelf -d "$library" | grep -q 'SONAME.*\[libstipple\.so\.0\]' || fail "the soname is not libstipple.so.0"
python3 - "$prefix/include/stipple" > declared << 'END_PYTHON'
import pathlib, re, sys
text = "".join(re.sub(r"//.*", "", path.read_text()) for path in sorted(pathlib.Path(sys.argv[1]).glob("*.h")))
for match in re.finditer(r"STP_API\b(?!\s+__attribute__)([^;{]*)\(", text):
    print(re.search(r"\b(stp_\w+)\s*\(", match[0])[1])
END_PYTHON
sort -o declared declared
nm -D --defined-only "$library" | awk '{ print $3 }' | sort > exported
[ "$(wc -l < exported)" -ge 30 ] || fail "the library exports too few symbols"
diff declared exported > differences || fail "declared (<) and exported (>) functions differ: $(cat differences)"

# the static library, too, takes no names but its own (and those of C++ templates)
nm --defined-only -g "$lib/libstipple.a" 2> /dev/null | awk 'NF == 3 { print $3 }' | grep -vE '^(stp_|_Z|DW\.ref\.|__clang_call_terminate$)' | sort -u > foreign
[ ! -s foreign ] || fail "libstipple.a defines $(head -n 5 foreign | tr '\n' ' ')"

# each header alone, in either language, by clang (by the compiler of the build: tests header.*)
for header in "$prefix"/include/stipple/*.h; do
    installed clang "headers by clang" || break
    for language in c:c11 c++:c++17; do
        clang -x "${language%:*}" -std="${language#*:}" -fsyntax-only -Wall -Wextra -Wpedantic -Werror \
            -I"$prefix/include" -include "$header" /dev/null 2> header.log ||
            fail "$header as ${language#*:}: $(head -n 3 header.log)"
    done
done

# examples, both ways
export PKG_CONFIG_PATH=$lib/pkgconfig LD_LIBRARY_PATH=$lib
[ "$(pkg-config --modversion stipple)" = "$("$stipple" --version | tr -dc '0-9.')" ] || fail "pkg-config prints a different version"
window=no
pkg-config --exists sdl2 gl && window=yes
[ $window = yes ] || echo "skipped: examples/window.c: SDL2 is not installed"
mkdir by-pkg-config
examples="picture points"
[ $window = yes ] && examples="$examples window"
for name in $examples; do
    packages=stipple
    [ $name = window ] && packages="stipple sdl2 gl"
    # shellcheck disable=SC2046,SC2086
    cc -std=c11 -Wall -Wextra -Werror "$source/examples/$name.c" $(pkg-config --cflags --libs $packages) -lm \
        -o by-pkg-config/$name 2> cc.log || fail "examples/$name.c by pkg-config: $(head -n 5 cc.log)"
    lines=$(wc -l < "$source/examples/$name.c")
    [ "$lines" -lt 150 ] || fail "examples/$name.c has $lines lines"
done
{ cmake -S "$source/examples" -B by-cmake -DCMAKE_PREFIX_PATH="$prefix" && cmake --build by-cmake; } > cmake.log 2>&1 ||
    fail "the examples by CMake: $(tail -n 5 cmake.log)"
printf '#include <stipple/stipple.h>\nint main() { return stp_version() == 0; }\n' > cpp.cpp
# shellcheck disable=SC2046
c++ -std=c++17 cpp.cpp $(pkg-config --cflags --libs stipple) -o cpp && ./cpp || fail "a C++ program does not link or run"

# shown FILE.ppm COLOUR: the percentage of pixels that differ from a background "r,g,b"
shown()
{
    python3 -c "
import sys
data = open(sys.argv[1], 'rb').read()
magic, size, depth, pixels = data.split(b'\n', 3)
width, height = map(int, size.split())
assert magic == b'P6' and len(pixels) == 3 * width * height
back = bytes(map(int, sys.argv[2].split(',')))
print(100 * sum(pixels[i:i + 3] != back for i in range(0, len(pixels), 3)) // (width * height))" "$1" "$2"
}
"$stipple" build scene:boxes -o boxes.stip 2> build.log || fail "no model: $(cat build.log)"
for way in by-pkg-config by-cmake; do
    ./$way/picture boxes.stip $way.ppm > picture.out || fail "$way: picture fails"
done
cmp by-pkg-config.ppm by-cmake.ppm || fail "pictures of both builds differ"
[ "$(shown by-cmake.ppm 255,255,255)" -ge 10 ] || fail "the picture is empty"
./by-cmake/points points.ppm torus.stip > points.out || fail "points fails"
grep -q '^500 of 20000 points cover all within' points.out || fail "output of points: $(cat points.out)"
[ "$(shown points.ppm 0,0,0)" -ge 10 ] || fail "the picture of points is empty"
if [ $window = yes ]; then
    SDL_VIDEODRIVER=offscreen LIBGL_ALWAYS_SOFTWARE=1 ./by-cmake/window boxes.stip --frames 3 window.ppm 2> window.err
    code=$?
    if [ $code -eq 77 ]; then
        echo "skipped: window: there is no OpenGL: $(cat window.err)"
    elif [ $code -ne 0 ]; then
        fail "window fails: $(cat window.err)"
    else
        [ "$(shown window.ppm 32,34,37)" -ge 10 ] || fail "the window is empty"
    fi
fi
"$stipple" check torus.stip > /dev/null || fail "the file of points is damaged"
"$stipple" info torus.stip | grep -q '20,000\|20000' || fail "points are missing in the file"
./by-cmake/picture nothing.stip none.ppm 2> err && fail "a missing file is drawn"
grep -q '^picture: error: nothing.stip' err || fail "message about a missing file: $(cat err)"
exit $((failures > 0))
