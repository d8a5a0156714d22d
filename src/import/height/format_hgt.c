// SPDX-License-Identifier: MIT
//
// Heights of the Shuttle Radar Topography Mission: a square of 1201 or 3601 heights in metres,
// big-endian, northernmost row first, over one degree. The file's name gives the south-western
// corner: N48E010. It becomes a mesh in metres, x to the east, y to the north, z up, centred on the
// tile. Degrees of longitude have the length that they have at the tile's middle latitude. Voids
// leave holes.
#include "import/reading/surface.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define VOID (-32768)
#define DEGREE 111319.490793273573 ///< metres per degree on the equator of WGS 84, a = 6378137
#define GRAIN ((size_t)16)         ///< rows
#define PI 3.14159265358979323846

typedef struct tile {
    stp_import* import;
    const unsigned char* bytes;
    uint32_t side;         ///< heights in a row
    double step_x, step_y; ///< metres
    stp_mesh mesh;
    uint32_t* first; ///< per row: number of triangles of the rows before it
} tile;

// Cosine of an angle up to 90 degrees: a power series, for the same result on every machine.
static double cosine_of_degrees(double degrees)
{
    assert(degrees >= -90.0 && degrees <= 90.0 && "the series converges fast");
    double x = degrees * (PI / 180.0), square = x * x, term = 1.0, sum = 1.0;
    for (int i = 1; i <= 14; ++i) {
        term *= -square / (double)((2 * i - 1) * (2 * i));
        sum += term;
    }
    return sum;
}

static int height_at(const tile* t, uint32_t row, uint32_t column)
{
    assert(row < t->side && column < t->side);
    const unsigned char* at = t->bytes + 2 * ((size_t)row * t->side + column);
    return (int16_t)(at[0] << 8 | at[1]);
}

// Reads a letter and digits. @return the rest of the text, or NULL
static const char* read_angle(const char* at, char plus, char minus, int* degrees)
{
    char letter = (char)(*at & ~0x20);
    if ((letter != plus && letter != minus) || at[1] < '0' || at[1] > '9') {
        return NULL;
    }
    char* end;
    long value = strtol(at + 1, &end, 10);
    *degrees = (int)(letter == plus ? value : -value);
    return value <= 180 ? end : NULL;
}

// The middle latitude from the file's name; the equator if the name has none.
static double find_latitude(const tile* t)
{
    const char* slash = strrchr(t->import->path, '/');
    int latitude = 0, longitude = 0;
    const char* at = read_angle(slash != NULL ? slash + 1 : t->import->path, 'N', 'S', &latitude);
    at = at != NULL ? read_angle(at, 'E', 'W', &longitude) : NULL;
    if (at == NULL || latitude < -90 || latitude >= 90) {
        stp_warn(t->import->context,
                 "%s: its name has no coordinates such as N48E010: assumes a tile at the equator",
                 t->import->path);
        return 0.0;
    }
    return latitude + 0.5;
}

static void place_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    tile* t = user;
    double middle = 0.5 * (t->side - 1);
    for (uint32_t row = (uint32_t)begin; row < end; ++row) {
        float* p = t->mesh.positions + 3 * (size_t)row * t->side;
        for (uint32_t column = 0; column < t->side; ++column, p += 3) {
            int height = height_at(t, row, column);
            p[0] = (float)((column - middle) * t->step_x);
            p[1] = (float)((middle - row) * t->step_y);
            p[2] = height == VOID ? 0.0f : (float)height; // no triangle uses it
        }
    }
}

// The corners of a cell that have data, one bit each: upper left, upper right, lower left, lower
// right.
static unsigned corners_of(const tile* t, uint32_t row, uint32_t column)
{
    unsigned held = 0;
    for (unsigned i = 0; i < 4; ++i) {
        held |= (unsigned)(height_at(t, row + i / 2, column + i % 2) != VOID) << i;
    }
    return held;
}

static uint32_t triangles_of(unsigned held)
{
    return held == 15 ? 2 : __builtin_popcount(held) == 3 ? 1 : 0;
}

static void count_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    tile* t = user;
    for (uint32_t row = (uint32_t)begin; row < end; ++row) {
        uint32_t count = 0;
        for (uint32_t column = 0; column + 1 < t->side; ++column) {
            count += triangles_of(corners_of(t, row, column));
        }
        t->first[row + 1] = count;
    }
}

// A cell with three heights gives one triangle, one with four gives two, counterclockwise from
// above.
static uint32_t* write_cell(const tile* t, uint32_t row, uint32_t column, uint32_t* out)
{
    static const uint8_t three[4][3] = {{2, 3, 1}, {0, 2, 3}, {0, 3, 1}, {0, 2, 1}};
    unsigned held = corners_of(t, row, column);
    uint32_t corners[4];
    for (uint32_t i = 0; i < 4; ++i) {
        corners[i] = (row + i / 2) * t->side + column + i % 2;
    }
    for (unsigned missing = 0; missing < 4 && triangles_of(held) == 1; ++missing) {
        if ((held >> missing & 1) == 0) {
            for (int k = 0; k < 3; ++k) {
                *out++ = corners[three[missing][k]];
            }
        }
    }
    for (int k = 0; k < 6 && held == 15; ++k) {
        *out++ = corners[three[k < 3 ? 3 : 0][k % 3]];
    }
    return out;
}

static void write_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    tile* t = user;
    for (uint32_t row = (uint32_t)begin; row < end; ++row) {
        uint32_t* out = t->mesh.indices + 3 * (size_t)t->first[row];
        for (uint32_t column = 0; column + 1 < t->side; ++column) {
            out = write_cell(t, row, column, out);
        }
        assert(out == t->mesh.indices + 3 * (size_t)t->first[row + 1] && "as counted");
    }
}

static stp_result make_mesh(tile* t)
{
    stp_context* context = t->import->context;
    size_t side = t->side;
    assert(side >= 2 && side * side < STP_NONE);
    t->first = STP_NEW_ZEROED(context, uint32_t, side + 1);
    t->mesh.positions = STP_NEW_ARRAY(context, float, 3 * side * side);
    if (t->first == NULL || t->mesh.positions == NULL) {
        return stp_fail_memory(context);
    }
    stp_parallel_for(context, side, GRAIN, place_rows, t);
    stp_parallel_for(context, side - 1, GRAIN, count_rows, t);
    for (size_t row = 0; row < side; ++row) {
        t->first[row + 1] += t->first[row];
    }
    assert(t->first[side] <= 2 * (side - 1) * (side - 1));
    t->mesh.vertex_count = (uint32_t)(side * side);
    t->mesh.triangle_count = t->first[side];
    t->mesh.indices = STP_NEW_ARRAY(context, uint32_t, 3 * (size_t)t->mesh.triangle_count);
    if (t->mesh.indices == NULL) {
        return stp_fail_memory(context);
    }
    stp_parallel_for(context, side - 1, GRAIN, write_rows, t);
    return STP_OK;
}

static stp_result add_mesh(tile* t)
{
    stp_scene* scene = t->import->scene;
    uint32_t material = STP_NONE;
    stp_result result = stp_add_plain_material(t->import, &material);
    t->mesh.material = material;
    if (result != STP_OK || t->mesh.triangle_count == 0) {
        return result;
    }
    stp_part part = {.kind = STP_PART_MESH};
    stp_mesh mesh = t->mesh;
    t->mesh = (stp_mesh){0};
    result = stp_scene_add_mesh(scene, &mesh, &part.index);
    return result == STP_OK ? stp_scene_add_part(scene, part) : result;
}

static stp_result read(stp_import* import)
{
    tile t = {.import = import, .bytes = import->file.bytes};
    stp_import_set_axes(import, import->desc.up != 0 ? import->desc.up : 'z', 1.0);
    static const uint32_t sides[] = {1201, 3601};
    for (int i = 0; i < 2; ++i) {
        size_t size = 2 * (size_t)sides[i] * sides[i];
        t.side = import->file.size == size ? sides[i] : t.side;
    }
    if (t.side == 0) {
        return stp_fail(
            import->context, STP_ERROR_FORMAT,
            "%s: has %zu bytes, but a tile has 1201 x 1201 or 3601 x 3601 heights of two bytes",
            import->path, import->file.size);
    }
    double latitude = find_latitude(&t);
    t.step_y = DEGREE / (t.side - 1);
    t.step_x = t.step_y * cosine_of_degrees(latitude);
    stp_result result = make_mesh(&t);
    result = result == STP_OK ? add_mesh(&t) : result;
    stp_free(import->context, t.first);
    stp_free(import->context, t.mesh.positions);
    stp_free(import->context, t.mesh.indices);
    return result;
}

const stp_importer stp_importer_hgt = {
    .name = "hgt", .title = "SRTM heights", .extensions = "hgt", .read = read};
