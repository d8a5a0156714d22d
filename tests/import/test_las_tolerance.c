// SPDX-License-Identifier: MIT
// LAS: units that files state wrongly or leave to their system, and a chunk size of zero.
#include "las_points.h"

#include "base/io/bytes.h"
#include "import/las/las.h"

static stp_las_units units_of(const char* text)
{
    char copy[1024];
    snprintf(copy, sizeof(copy), "%s\n", text);
    return stp_las_wkt_units(copy, strlen(text));
}

// The factor 1 of a unit whose name is a foot is wrong.
void test_las_names_of_feet_correct_their_factor(test_state* test)
{
    static const struct {
        const char* unit;
        double metres;
    } cases[] = {{"\"US survey foot\",1.0", 1200.0 / 3937.0},
                 {"\"foot_survey_us\",1", 1200.0 / 3937.0},
                 {"\"ftUS\",1", 1200.0 / 3937.0},
                 {"\"foot\",1", 0.3048},
                 {"\"International Feet\",1.0", 0.3048},
                 {"\"metre\",1", 1.0},
                 {"\"US survey foot\",0.5", 0.5},
                 {"\"foot\",0", 0.0}};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        char text[256];
        snprintf(text, sizeof(text), "PROJCS[\"x\",UNIT[\"metre\",1],VERTCS[\"v\",UNIT[%s]]]",
                 cases[i].unit);
        CHECK(units_of(text).vertical == cases[i].metres);
        snprintf(text, sizeof(text), "PROJCS[\"x\",UNIT[%s]]", cases[i].unit);
        CHECK(units_of(text).horizontal == cases[i].metres);
    }
}

void test_las_geocentric_systems_are_metric(test_state* test)
{
    static const char* const metric[] = {
        ("GEODCRS[\"W\",DATUM[\"d\",ELLIPSOID[\"e\",6378137,298,LENGTHUNIT[\"foot\",0.3]]],"
         "CS[Cartesian,3],AXIS[\"(X)\",geocentricX],LENGTHUNIT[\"metre\",1]]"),
        "GEODCRS[\"W\",CS[Cartesian,3],AXIS[\"(X)\",geocentricX]]", "GEOCCS[\"W\",DATUM[\"d\"]]",
        "GEOCCS[\"W\",UNIT[\"metre\",1]]"};
    for (int i = 0; i < 4; ++i) {
        CHECK(units_of(metric[i]).horizontal == 1.0 && !units_of(metric[i]).geographic);
    }
    CHECK(units_of("GEOCCS[\"W\",UNIT[\"kilometre\",1000]]").horizontal == 1000.0);
    CHECK(units_of("PROJCRS[\"p\",BASEGEODCRS[\"W\",DATUM[\"d\"]],CS[Cartesian,2]]").horizontal ==
          0.0);
}

// Coordinates near zero could be degrees, but not in a geocentric system.
void test_las_geocentric_keys(test_state* test)
{
    static const uint16_t keys[][16] = {
        {1, 1, 0, 2, 1024, 0, 1, 3, 2048, 0, 1, 4978},
        {1, 1, 0, 1, 2048, 0, 1, 4978},
        {1, 1, 0, 1, 3072, 0, 1, 4978},
        {1, 1, 0, 2, 1024, 0, 1, 3, 3076, 0, 1, 9036}, // kilometres
    };
    static const size_t numbers[] = {12, 8, 8, 12};
    las_point point = {.position = {1, 2, 3}};
    for (int i = 0; i < 4; ++i) {
        las_buffer file = las_write(
            &(las_desc){.points = &point, .count = 1, .keys = keys[i], .key_numbers = numbers[i]});
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.las", file.bytes, file.size, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK(scene->unit_metres == (i == 3 ? 1000.0 : 1.0));
        CHECK_EQUAL(0, log.warnings);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        free(file.bytes);
    }
}

// LASzip reads a chunk size of zero as chunks of varying size.
void test_laz_chunk_size_of_zero(test_state* test)
{
    enum { COUNT = 200 };
    static las_point points[COUNT];
    for (unsigned format = 1; format <= 6; format += 5) {
        las_make_points(points, COUNT, format, 3);
        las_desc desc = {.points = points,
                         .count = COUNT,
                         .format = format,
                         .coding = LAZ_VARIABLE,
                         .chunk_size = 30};
        las_buffer file = las_write(&desc);
        size_t at = stp_read_u16(file.bytes + 94);
        while (strcmp((const char*)file.bytes + at + 2, "laszip encoded") != 0) {
            at += 54 + (size_t)stp_read_u16(file.bytes + at + 20);
            CHECK(at + 54 < file.size);
        }
        CHECK_EQUAL(UINT32_MAX, stp_read_u32(file.bytes + at + 54 + 12));
        stp_write_u32(file.bytes + at + 54 + 12, 0);
        stp_context* context = test_context(NULL, 2, NULL);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.laz", file.bytes, file.size, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK(las_set_is_right(&desc, &scene->point_sets[0], 0, &scene->objects[0].transform));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        free(file.bytes);
    }
}
