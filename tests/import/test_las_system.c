// SPDX-License-Identifier: MIT
//
// Metadata of LAS files: coordinate systems, units, extra bytes, the COPC hierarchy.
#include "las_points.h"

#include "import/las/las.h"

enum { COUNT = 40 };

static las_point points[COUNT];

static const char metres[] =
    "PROJCS[\"WGS 84 / UTM zone 33N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS "
    "84\",6378137,"
    "298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],PROJECTION["
    "\"Transverse_Mercator\"],PARAMETER[\"scale_factor\",0.9996],UNIT[\"metre\",1,AUTHORITY["
    "\"EPSG\","
    "\"9001\"]],AXIS[\"Easting\",EAST]]";
static const char feet[] =
    "COMPD_CS[\"both\",PROJCS[\"a [strange] name\",GEOGCS[\"g\",UNIT[\"degree\",0.0174]],UNIT["
    "\"US survey "
    "foot\",0.3048006096012192]],VERT_CS[\"NAVD88\",VERT_DATUM[\"n\",2005],UNIT[\"metre\","
    "1],AXIS[\"Up\",UP]]]";
static const char newer[] =
    "PROJCRS[\"RGF93 / Lambert-93\",BASEGEOGCRS[\"RGF93\",DATUM[\"d\",ELLIPSOID[\"GRS "
    "1980\",6378137,"
    "298.2572221,LENGTHUNIT[\"metre\",1]]]],CONVERSION[\"c\",METHOD[\"m\"],PARAMETER[\"False "
    "easting\","
    "700000,LENGTHUNIT[\"kilometre\",1000]]],CS[Cartesian,2],AXIS[\"easting (X)\",east,LENGTHUNIT["
    "\"foot\",0.3048]],AXIS[\"northing (Y)\",north,LENGTHUNIT[\"foot\",0.3048]]]";
static const char degrees[] = "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS "
                              "84\",6378137,298.257223563]],UNIT[\"degree\","
                              "0.0174532925199433]]";
static const char newer_degrees[] =
    "GEODCRS[\"WGS "
    "84\",DATUM[\"d\",ELLIPSOID[\"e\",6378137,298]],CS[ellipsoidal,2],AXIS[\"lat\",north,"
    "ANGLEUNIT[\"degree\",0.0174]]]";
static const char geocentric[] = "GEODCRS[\"WGS 84\",CS[Cartesian,3],LENGTHUNIT[\"metre\",1]]";

void test_las_finds_units_in_wkt(test_state* test)
{
    stp_las_units u = stp_las_wkt_units(metres, strlen(metres));
    CHECK(u.horizontal == 1.0 && u.vertical == 0.0 && !u.geographic);
    u = stp_las_wkt_units(feet, strlen(feet));
    CHECK(fabs(u.horizontal - 1200.0 / 3937.0) < 1e-12 && u.vertical == 1.0 && !u.geographic);
    u = stp_las_wkt_units(newer, strlen(newer));
    CHECK(fabs(u.horizontal - 0.3048) < 1e-12 && !u.geographic);
    u = stp_las_wkt_units(degrees, strlen(degrees));
    CHECK(u.horizontal == 0.0 && u.geographic);
    CHECK(stp_las_wkt_units(newer_degrees, strlen(newer_degrees)).geographic);
    CHECK(!stp_las_wkt_units(geocentric, strlen(geocentric)).geographic);
    char text[sizeof(feet)];
    for (size_t cut = 0; cut < sizeof(feet); ++cut) { // parsing ends for any truncation
        memcpy(text, feet, sizeof(text));
        text[cut] = '\n';
        u = stp_las_wkt_units(text, cut);
        CHECK(u.horizontal >= 0.0);
    }
    memset(text, '[', sizeof(text));
    u = stp_las_wkt_units(text, sizeof(text) - 1);
    CHECK(u.horizontal == 0.0);
}

typedef struct system_case {
    las_desc desc;
    const char* text;     ///< the scene's coordinate system; NULL: none
    double unit;          ///< 0: not known
    const char* sentence; ///< part of the logged message; NULL: no message
    stp_result result;
} system_case;

static int system_is_right(system_case c)
{
    las_make_points(points, COUNT, c.desc.format, 2);
    c.desc.points = points;
    c.desc.count = COUNT;
    las_buffer file = las_write(&c.desc);
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.las", file.bytes, file.size, &result);
    int good = result == c.result;
    if (scene != NULL) {
        const char* text = scene->sources[0].coordinate_system;
        good = good && fabs(scene->unit_metres - c.unit) < 1e-9 &&
               (text == NULL) == (c.text == NULL) && (text == NULL || strcmp(text, c.text) == 0) &&
               strcmp(scene->up, "z") == 0;
    }
    const char* said = scene != NULL ? log.warning : log.text;
    good = good && (c.sentence != NULL ? strstr(said, c.sentence) != NULL : said[0] == '\0');
    const char* guess = "may be degrees";
    bool expected = c.sentence != NULL && strstr(c.sentence, guess) != NULL;
    good = good && (strstr(said, guess) != NULL) == expected;
    if (!good) {
        fprintf(stderr, "result %d, \"%s\", unit %g\n", result, said,
                scene != NULL ? scene->unit_metres : 0.0);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(file.bytes);
    return good;
}

void test_las_keeps_its_coordinate_system(test_state* test)
{
    static const uint16_t utm[] = {1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633};
    static const uint16_t us_feet[] = {1,    1, 0, 3,    1024, 0, 1, 1,
                                       3072, 0, 1, 2994, 3076, 0, 1, 9003};
    static const uint16_t no_unit[] = {1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 2994};
    static const uint16_t angles[] = {1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326};
    const double foot = 1200.0 / 3937.0;
    CHECK(system_is_right((system_case){{.wkt = metres}, metres, 1.0, NULL, STP_OK}));
    CHECK(system_is_right((system_case){{.wkt = newer}, newer, 0.3048, NULL, STP_OK}));
    CHECK(system_is_right((system_case){
        {.wkt = metres, .format = 6, .extended_wkt = true}, metres, 1.0, NULL, STP_OK}));
    CHECK(system_is_right(
        (system_case){{.wkt = feet}, feet, foot, "its heights have another unit", STP_OK}));
    CHECK(system_is_right((system_case){
        {.wkt = metres, .keys = us_feet, .key_numbers = 16}, metres, 1.0, NULL, STP_OK}));
    CHECK(system_is_right(
        (system_case){{.keys = utm, .key_numbers = 12}, "EPSG:32633", 1.0, NULL, STP_OK}));
    CHECK(system_is_right(
        (system_case){{.keys = us_feet, .key_numbers = 16}, "EPSG:2994", foot, NULL, STP_OK}));
    const char* unknown = "a.las: its unit of length is unknown";
    CHECK(system_is_right(
        (system_case){{.keys = no_unit, .key_numbers = 12}, "EPSG:2994", 0.0, unknown, STP_OK}));
    CHECK(system_is_right((system_case){{.format = 3}, NULL, 0.0, unknown, STP_OK}));
    // undeclared degrees are suspected only where numbers are small and have many digits
    const char* suspected = "(set it with unit_metres); its coordinates may be degrees";
    CHECK(system_is_right((system_case){{.scale = 1e-7}, NULL, 0.0, suspected, STP_OK}));
    CHECK(system_is_right((system_case){{.scale = 1e-6}, NULL, 0.0, unknown, STP_OK}));
    // degrees are rejected; if coordinates exceed them, the declaration is wrong
    CHECK(system_is_right((system_case){{.wkt = degrees, .scale = 1e-7},
                                        NULL,
                                        0.0,
                                        "its coordinates are degrees",
                                        STP_ERROR_UNSUPPORTED}));
    CHECK(system_is_right((system_case){{.keys = angles, .key_numbers = 12, .scale = 1e-7},
                                        NULL,
                                        0.0,
                                        "its coordinates are degrees",
                                        STP_ERROR_UNSUPPORTED}));
    CHECK(system_is_right((system_case){{.wkt = degrees}, degrees, 0.0, unknown, STP_OK}));
}

// Units by their codes, and as a number of their own, which is in a record beside the keys.
void test_las_reads_units_of_keys(test_state* test)
{
    static const struct {
        uint16_t code;
        double metres;
    } units[] = {{9001, 1.0}, {9002, 0.3048}, {9003, 1200.0 / 3937.0}, {9036, 1000.0}, {9102, 0.0}};
    const char* unknown = "its unit of length is unknown";
    for (size_t i = 0; i < sizeof(units) / sizeof(units[0]); ++i) {
        const uint16_t keys[] = {1, 1, 0, 2, 3072, 0, 1, 2994, 3076, 0, 1, units[i].code};
        double unit = units[i].metres;
        CHECK(system_is_right((system_case){{.keys = keys, .key_numbers = 12},
                                            "EPSG:2994",
                                            unit,
                                            unit > 0.0 ? NULL : unknown,
                                            STP_OK}));
    }
    const uint16_t own[] = {1, 1, 0, 3, 3072, 0, 1, 32767, 3076, 0, 1, 32767, 3077, 34736, 1, 1};
    static const double sizes[] = {2.5, 1e-7, 1e7, 0.0};
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); ++i) {
        const double numbers[] = {7.0, sizes[i]};
        las_desc desc = {.keys = own,
                         .key_numbers = 16,
                         .vlr_user = "LASF_Projection",
                         .vlr_id = 34736,
                         .vlr = (const unsigned char*)numbers,
                         .vlr_size = sizeof(numbers)};
        double unit = i == 0 ? sizes[i] : 0.0;
        CHECK(
            system_is_right((system_case){desc, NULL, unit, unit > 0.0 ? NULL : unknown, STP_OK}));
        desc.vlr_size = sizeof(double); // the number is beyond the record
        CHECK(system_is_right((system_case){desc, NULL, 0.0, unknown, STP_OK}));
    }
}

// Codes of systems in metres; those beside the ranges are of other units.
void test_las_knows_metric_systems(test_state* test)
{
    static const struct {
        uint16_t first, last;
    } ranges[] = {{32601, 32660}, {32701, 32760}, {25828, 25838}, {26901, 26923}, {3857, 3857}};
    for (size_t i = 0; i < sizeof(ranges) / sizeof(ranges[0]); ++i) {
        for (int end = 0; end < 4; ++end) {
            int code = end < 2 ? ranges[i].first - end : ranges[i].last + end - 2;
            bool metric = end == 0 || end == 2;
            char text[16];
            snprintf(text, sizeof(text), "EPSG:%d", code);
            const uint16_t keys[] = {1, 1, 0, 1, 3072, 0, 1, (uint16_t)code};
            CHECK(system_is_right((system_case){{.keys = keys, .key_numbers = 8},
                                                text,
                                                metric ? 1.0 : 0.0,
                                                metric ? NULL : "its unit of length is unknown",
                                                STP_OK}));
        }
    }
}

// Heights in metres with horizontal coordinates in feet.
void test_las_brings_heights_to_the_unit_of_the_plane(test_state* test)
{
    las_make_points(points, COUNT, 0, 2);
    las_desc desc = {.points = points, .count = COUNT, .wkt = feet};
    las_buffer file = las_write(&desc);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.las", file.bytes, file.size, &result);
    CHECK_EQUAL(STP_OK, result);
    const float* p = scene->point_sets[0].positions;
    stp_vec3d at = stp_affine_point(&scene->objects[0].transform,
                                    (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]});
    CHECK(fabs(at.x - 0.01 * points[0].position[0]) < 1e-3 + 2e-7 * fabs((double)p[0]));
    CHECK(fabs(at.y - 0.01 * points[0].position[2] * 3937.0 / 1200.0) <
          1e-3 + 2e-7 * fabs((double)p[2]));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(file.bytes);
}

void test_las_names_what_it_does_not_keep(test_state* test)
{
    unsigned char entries[2 * 192] = {0};
    memcpy(entries + 4, "Reflectance", 11);
    memcpy(entries + 192 + 4, "Deviation", 9);
    las_make_points(points, COUNT, 4, 2);
    las_desc desc = {.points = points,
                     .count = COUNT,
                     .format = 4,
                     .extra = 4,
                     .wkt = metres,
                     .vlr_user = "LASF_Spec",
                     .vlr_id = 4,
                     .vlr = entries,
                     .vlr_size = sizeof(entries)};
    las_buffer file = las_write(&desc);
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.las", file.bytes, file.size, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(strcmp(log.warning, "a.las: not kept: 40 point waveforms") == 0);
    stp_scene_destroy(scene);
    desc.format = 3;
    free(file.bytes);
    file = las_write(&desc);
    scene = import_bytes(context, "a.las", file.bytes, file.size, &result);
    CHECK(strcmp(log.warning,
                 "a.las: 4 extra bytes of each point are not kept: Reflectance, Deviation") == 0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(file.bytes);
}

// A hierarchy of a page and a child page, after the COPC information. Damage causes a warning, but
// no points are lost.
void test_las_checks_the_hierarchy_of_copc(test_state* test)
{
    static const char* const sentences[] = {NULL, "its number of points differs",
                                            "an entry of it lies outside the file",
                                            "a page of it lies outside the file"};
    for (int kind = 0; kind < 4; ++kind) {
        unsigned char vlr[160 + 3 * 32] = {0};
        uint64_t pages = 375 + 54 + 160;
        las_buffer b = {.bytes = vlr, .capacity = sizeof(vlr), .size = 40};
        las_put_number(&b, kind == 3 ? pages + 1000000 : pages, 8);
        las_put_number(&b, 64, 8);
        b.size = 160 + 16; // after the key of the root's entry
        las_put_number(&b, 0, 8);
        las_put_number(&b, kind == 2 ? 1 << 30 : 1, 4);
        las_put_number(&b, kind == 1 ? 7 : COUNT / 2, 4);
        b.size += 16;
        las_put_number(&b, pages + 64, 8);
        las_put_number(&b, 32, 4);
        las_put_number(&b, UINT32_MAX, 4);
        b.size += 24;
        las_put_number(&b, 1, 4);
        las_put_number(&b, COUNT / 2, 4);
        las_make_points(points, COUNT, 7, 2);
        las_desc desc = {.points = points,
                         .count = COUNT,
                         .format = 7,
                         .coding = LAZ_VARIABLE,
                         .chunk_size = 10,
                         .wkt = metres,
                         .vlr_user = "copc",
                         .vlr_id = 1,
                         .vlr = vlr,
                         .vlr_size = sizeof(vlr)};
        las_buffer file = las_write(&desc);
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.copc.laz", file.bytes, file.size, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK_EQUAL(COUNT, scene->point_sets[0].point_count);
        CHECK(kind == 0 ? log.warning[0] == '\0' : strstr(log.warning, sentences[kind]) != NULL);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        free(file.bytes);
    }
}
