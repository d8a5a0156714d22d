// SPDX-License-Identifier: MIT
// Colours of points under the names and in the ranges that programs use.
#include "e57_writer.h"
#include "points_test.h"

static const uint8_t wanted[3][3] = {{200, 100, 50}, {0, 255, 0}, {10, 20, 250}};

static int has_wanted_colors(const char* name, const void* bytes, size_t size)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 2, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, name, bytes, size, &result);
    int good = scene != NULL && scene->point_set_count == 1 &&
               scene->point_sets[0].point_count == 3 && scene->point_sets[0].colors != NULL &&
               strstr(log.warning, "not kept") == NULL;
    for (size_t i = 0; good && i < 9; ++i) {
        good = scene->point_sets[0].colors[4 * (i / 3) + i % 3] == wanted[i / 3][i % 3];
    }
    if (!good) {
        fprintf(stderr, "%s: other colours (result %d, %s %s):\n%.*s\n", name, result, log.text,
                log.warning, (int)size, (const char*)bytes);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    return good;
}

static int text_has_wanted_colors(const char* name, const char* text)
{
    return has_wanted_colors(name, text, strlen(text));
}

void test_pcd_names_in_any_case(test_state* test)
{
    static const char pcd[] =
        "# .PCD v0.7\nVERSION 0.7\nFIELDS X Y Z Intensity Classification Red Green Blue\n"
        "SIZE 8 8 8 2 1 2 2 2\nTYPE F F F U U U U U\nCOUNT 1 1 1 1 1 1 1 1\nWIDTH 3\nHEIGHT 1\n"
        "DATA ascii\n0 0 0 500 2 200 100 50\n1 0 0 500 2 0 255 0\n0 1 0 500 2 10 20 250\n";
    CHECK(text_has_wanted_colors("a.pcd", pcd));
    CHECK(is_the_same_everywhere("a.pcd", pcd, strlen(pcd)));
}

// Separate fields: whole numbers and floats to 255, fractions, and whole numbers to 65535.
void test_pcd_separate_colors(test_state* test)
{
    static const char head[] = "FIELDS x y z red green blue\nSIZE 4 4 4 8 8 8\nTYPE F F F F F F\n"
                               "WIDTH 3\nHEIGHT 1\nDATA ";
    static const double factors[] = {1.0, 1.0 / 255.0, 257.0};
    for (int i = 0; i < 3; ++i) {
        char text[512];
        unsigned char bytes[512];
        int length = snprintf(text, sizeof(text), "%sascii\n", head);
        size_t at = (size_t)sprintf((char*)bytes, "%sbinary\n", head);
        for (int k = 0; k < 3; ++k) {
            const uint8_t* c = wanted[k];
            length += snprintf(text + length, sizeof(text) - (size_t)length, "%d 0 0 %g %g %g\n", k,
                               c[0] * factors[i], c[1] * factors[i], c[2] * factors[i]);
            for (int axis = 0; axis < 3; ++axis, at += 4) {
                stp_write_f32(bytes + at, (float)k);
            }
            for (int channel = 0; channel < 3; ++channel, at += 8) {
                stp_write_f64(bytes + at, c[channel] * factors[i]);
            }
        }
        CHECK(text_has_wanted_colors("a.pcd", text));
        CHECK(has_wanted_colors("a.pcd", bytes, at));
    }
}

void test_xyz_colors_with_decimals(test_state* test)
{
    CHECK(text_has_wanted_colors("a.xyz", "0.0 0.0 0.0 200.000000 100.000000 50.000000\n"
                                          "1.0 0.0 0.0 0.000000 255.000000 0.000000\n"
                                          "0.0 1.0 0.0 10.000000 20.000000 250.000000\n"));
    CHECK(text_has_wanted_colors("a.asc", "//X,Y,Z,Rf,Gf,Bf\n0,0,0,0.784314,0.392157,0.196078\n"
                                          "1,0,0,0.000000,1.000000,0.000000\n"
                                          "0,1,0,0.039216,0.078431,0.980392\n"));
}

// Three records with three values after the position.
static unsigned char* write_e57(const char* fields, unsigned bits, uint64_t values[3][3],
                                const double places[3], size_t* size)
{
    uint64_t v[6][3];
    for (size_t i = 0; i < 3; ++i) {
        memcpy(&v[0][i], &places[i], sizeof(uint64_t));
        v[1][i] = v[2][i] = 0;
        for (size_t k = 0; k < 3; ++k) {
            v[3 + k][i] = values[i][k];
        }
    }
    const e57_stream streams[] = {{64, v[0]},   {64, v[1]},   {64, v[2]},
                                  {bits, v[3]}, {bits, v[4]}, {bits, v[5]}};
    e57_file f = e57_begin();
    unsigned long long section = e57_add_points(&f, streams, 6, 3, 1000);
    char xml[2048];
    snprintf(xml, sizeof(xml),
             "<e57Root><data3D><vectorChild><points fileOffset=\"%llu\" recordCount=\"3\">"
             "<prototype><cartesianX type=\"Float\"/><cartesianY type=\"Float\"/><cartesianZ "
             "type=\"Float\"/>%s</prototype></points></vectorChild></data3D></e57Root>",
             section, fields);
    return e57_finish(&f, xml, size);
}

static const double places[3] = {0.0, 1.0, 2.0};

void test_e57_colors_without_limits(test_state* test)
{
    static const char* const fields[] = {
        "<colorRed type=\"Float\"/><colorGreen type=\"Float\"/><colorBlue type=\"Float\"/>",
        ("<colorRed type=\"Float\" minimum=\"-1.7e308\" maximum=\"1.7e308\"/>"
         "<colorGreen type=\"Float\"/><colorBlue type=\"Float\"/>"),
        "<colorRed type=\"Integer\"/><colorGreen type=\"Integer\"/><colorBlue type=\"Integer\"/>"};
    static const double factors[] = {1.0, 1.0 / 255.0, 257.0};
    for (int i = 0; i < 9; ++i) {
        uint64_t values[3][3];
        for (int k = 0; k < 9; ++k) {
            double value = wanted[k / 3][k % 3] * factors[i % 3];
            memcpy(&values[k / 3][k % 3], &value, sizeof(value));
            if (i >= 6) { // stored as the difference from the smallest integer
                values[k / 3][k % 3] = (uint64_t)value + (UINT64_C(1) << 63);
            }
        }
        size_t size;
        unsigned char* bytes = write_e57(fields[i / 3], 64, values, places, &size);
        CHECK(i == 7 || has_wanted_colors("a.e57", bytes, size)); // integers are no fractions
        CHECK(is_the_same_everywhere("a.e57", bytes, size));
        free(bytes);
    }
}

// Without limits, all intensities decide on the scale; positions that are not finite are counted.
void test_e57_intensities_without_limits(test_state* test)
{
    uint64_t strengths[3][3] = {{0}};
    for (int i = 0; i < 3; ++i) {
        double value = i == 0 ? 10.0 : i == 1 ? 2000.0 : 500.0;
        memcpy(&strengths[i][0], &value, sizeof(value));
    }
    const double odd[3] = {0.0, 1.0, (double)NAN};
    size_t size;
    unsigned char* bytes =
        write_e57("<intensity type=\"Float\"/><other type=\"Float\"/><another type=\"Float\"/>", 64,
                  strengths, odd, &size);
    test_log log = {0};
    stp_context* context = test_context(NULL, 2, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.e57", bytes, size, &result);
    CHECK_EQUAL(STP_OK, result);
    const stp_point_set* p = &scene->point_sets[0];
    CHECK_EQUAL(2, p->point_count);
    CHECK_EQUAL(10, ((uint16_t*)p->attributes[STP_ATTRIBUTE_INTENSITY])[0]);
    CHECK_EQUAL(2000, ((uint16_t*)p->attributes[STP_ATTRIBUTE_INTENSITY])[1]);
    CHECK(strstr(log.warning, "1 point without a finite position") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(bytes);
}
