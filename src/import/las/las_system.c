// SPDX-License-Identifier: MIT
// The coordinate system of a LAS file: as WKT, or as the keys of GeoTIFF (OGC 19-008r4).
#include "base/io/bytes.h"
#include "import/las/las.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    WKT_ID = 2112,
    KEYS_ID = 34735,
    NUMBERS_ID = 34736,
    KEY_SIZE = 8,
    MODEL_TYPE = 1024,
    MODEL_GEOGRAPHIC = 2,
    MODEL_GEOCENTRIC = 3,
    GEOGRAPHIC_CODE = 2048,
    PROJECTED_CODE = 3072,
    LINEAR_UNIT = 3076,
    LINEAR_SIZE = 3077,
    VERTICAL_UNIT = 4099,
    USER_DEFINED = 32767,
    MAX_TEXT = 1 << 20
};

static const char user[] = "LASF_Projection";

typedef struct coordinate_system {
    char* text; ///< owned; NULL: the file does not say
    stp_las_units units;
} coordinate_system;

static stp_result read_wkt(const stp_las* las, coordinate_system* s)
{
    stp_las_record record;
    if (!stp_las_find_record(las, user, WKT_ID, &record) || record.size > MAX_TEXT) {
        return STP_OK;
    }
    size_t size = strnlen((const char*)record.bytes, (size_t)record.size);
    if (size == 0) {
        return STP_OK;
    }
    s->text = stp_alloc(las->context, size + 2);
    if (s->text == NULL) {
        return stp_fail_memory(las->context);
    }
    memcpy(s->text, record.bytes, size);
    s->text[size] = '\n'; // numbers are read up to it
    s->text[size + 1] = '\0';
    s->units = stp_las_wkt_units(s->text, size);
    s->text[size] = '\0';
    return STP_OK;
}

// The value of a 16-bit key; 0 if it is missing.
static unsigned find_key(const stp_las_record* keys, unsigned id)
{
    for (uint64_t at = KEY_SIZE; at + KEY_SIZE <= keys->size; at += KEY_SIZE) {
        const unsigned char* key = keys->bytes + at;
        if (stp_read_u16(key) == id && stp_read_u16(key + 2) == 0) {
            return stp_read_u16(key + 6);
        }
    }
    return 0;
}

// The value of a double key; 0 if it is missing.
static double find_number(const stp_las* las, const stp_las_record* keys, unsigned id)
{
    stp_las_record numbers;
    for (uint64_t at = KEY_SIZE; at + KEY_SIZE <= keys->size; at += KEY_SIZE) {
        const unsigned char* key = keys->bytes + at;
        size_t index = stp_read_u16(key + 6);
        if (stp_read_u16(key) == id && stp_read_u16(key + 2) == NUMBERS_ID &&
            stp_las_find_record(las, user, NUMBERS_ID, &numbers) &&
            8 * (index + 1) <= numbers.size) {
            return stp_read_f64(numbers.bytes + 8 * index);
        }
    }
    return 0.0;
}

// Metres per unit of length by its EPSG code; 0: unknown.
static double unit_of_code(unsigned code)
{
    switch (code) {
    case 9001:
        return 1.0;
    case 9002:
        return 0.3048;
    case 9003:
        return 1200.0 / 3937.0;
    case 9036:
        return 1000.0;
    default:
        return 0.0;
    }
}

// Systems whose unit is the metre: UTM on WGS 84, ETRS89, NAD83 and WGS 72, and Web Mercator.
static bool code_is_metric(unsigned code)
{
    return (code >= 32601 && code <= 32660) || (code >= 32701 && code <= 32760) ||
           (code >= 25828 && code <= 25838) || (code >= 26901 && code <= 26923) || code == 3857;
}

// Axes in metres from the centre of the Earth: WGS 84 and ETRS89.
static bool code_is_geocentric(unsigned code)
{
    return code == 4978 || code == 4936;
}

static stp_result read_keys(const stp_las* las, coordinate_system* s)
{
    enum { CODE_SIZE = 16 };
    stp_las_record keys;
    if (!stp_las_find_record(las, user, KEYS_ID, &keys)) {
        return STP_OK;
    }
    unsigned projected = find_key(&keys, PROJECTED_CODE);
    unsigned geographic = find_key(&keys, GEOGRAPHIC_CODE);
    unsigned linear = find_key(&keys, LINEAR_UNIT);
    unsigned model = find_key(&keys, MODEL_TYPE);
    bool geocentric = model == MODEL_GEOCENTRIC || code_is_geocentric(projected) ||
                      (projected == 0 && code_is_geocentric(geographic));
    s->units.geographic =
        !geocentric && (model == MODEL_GEOGRAPHIC || (projected == 0 && geographic != 0));
    s->units.horizontal = unit_of_code(linear);
    s->units.vertical = unit_of_code(find_key(&keys, VERTICAL_UNIT));
    if (linear == USER_DEFINED) {
        double size = find_number(las, &keys, LINEAR_SIZE);
        s->units.horizontal = size > 1e-6 && size < 1e6 ? size : 0.0;
    }
    if (linear == 0 && (geocentric || code_is_metric(projected))) {
        s->units.horizontal = 1.0;
    }
    unsigned code = projected != 0 ? projected : geographic;
    if (code == 0 || code == USER_DEFINED) {
        return STP_OK;
    }
    s->text = stp_alloc(las->context, CODE_SIZE);
    if (s->text == NULL) {
        return stp_fail_memory(las->context);
    }
    snprintf(s->text, CODE_SIZE, "EPSG:%u", code);
    return STP_OK;
}

// The usual precision of degrees: 1e-7 of them is a centimetre. Metres and feet have at most six
// digits after the point.
#define DEGREE_STEP 1e-6

// Some files declare degrees but contain metres: angles cannot be that large.
static bool box_is_angles(const stp_las* las)
{
    return fabs(las->low[0]) <= 360.0 && fabs(las->high[0]) <= 360.0 &&
           fabs(las->low[1]) <= 360.0 && fabs(las->high[1]) <= 360.0;
}

static bool may_be_degrees(const stp_las* las, const coordinate_system* s)
{
    return s->text == NULL && box_is_angles(las) && las->scale[0] < DEGREE_STEP &&
           las->scale[1] < DEGREE_STEP;
}

static void scale_heights(stp_las* las, double factor)
{
    assert(factor > 0.0 && isfinite(factor));
    las->scale[2] *= factor;
    las->offset[2] *= factor;
    las->low[2] *= factor;
    las->high[2] *= factor;
    if (las->import->desc.sample_points != 0) {
        return;
    }
    stp_warn(las->context,
             "%s: its heights have another unit than its horizontal coordinates: multiplies them "
             "by %.9g",
             las->import->path, factor);
}

static stp_result apply_units(stp_las* las, const coordinate_system* s)
{
    stp_import* import = las->import;
    double unit = s->units.horizontal, vertical = s->units.vertical;
    if (s->units.geographic && box_is_angles(las)) {
        return stp_fail(las->context, STP_ERROR_UNSUPPORTED,
                        "%s: its coordinates are degrees: reproject it to a projected system "
                        "first, for example with the reprojection filter of PDAL",
                        import->path);
    }
    unit = s->units.geographic ? 0.0 : unit;
    if (unit > 0.0 && vertical > 0.0 && fabs(vertical / unit - 1.0) > 1e-9) {
        scale_heights(las, vertical / unit);
    }
    bool quiet = import->desc.sample_points != 0;
    if (unit == 0.0 && !(import->desc.unit_metres > 0.0) && !quiet) {
        stp_warn(las->context, "%s: its unit of length is unknown (set it with unit_metres)%s",
                 import->path,
                 may_be_degrees(las, s)
                     ? "; its coordinates may be degrees: if so, reproject the file "
                       "to a projected system first"
                     : "");
    }
    stp_import_set_axes(import, import->desc.up != 0 ? import->desc.up : 'z', unit);
    return STP_OK;
}

stp_result stp_las_read_system(stp_las* las)
{
    stp_scene* scene = las->import->scene;
    coordinate_system s = {0};
    stp_result result = read_wkt(las, &s);
    if (result == STP_OK && s.text == NULL) {
        result = read_keys(las, &s);
    }
    result = result == STP_OK ? apply_units(las, &s) : result;
    if (result == STP_OK && s.text != NULL) {
        result = stp_scene_set_coordinate_system(scene, scene->source_count - 1, s.text);
    }
    stp_free(las->context, s.text);
    return result;
}
