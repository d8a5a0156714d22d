// SPDX-License-Identifier: MIT
//
// PCD in its three encodings with the same content, and invalid headers.
#include "points_test.h"

#include "base/io/bytes.h"
#include "import/reading/scan_info.h"

#include <lzf.h>

enum { POINTS = 3, ROW = 37 };

static const char fields[] = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
                             "FIELDS x y z normal_x normal_y normal_z rgb intensity label _\n"
                             "SIZE 4 4 4 4 4 4 4 4 1 1\nTYPE F F F F F F F F U U\n"
                             "COUNT 1 1 1 1 1 1 1 1 1 4\n";
static const float values[POINTS][7] = {{500001.0f, 2.5f, 3.0f, 0.0f, 2.0f, 0.0f, 10.0f},
                                        {NAN, NAN, NAN, 0.0f, 0.0f, 0.0f, 0.0f},
                                        {500002.0f, -2.5f, 4.0f, 0.0f, 0.0f, -1.0f, 255.0f}};
static const uint32_t colors[POINTS] = {0x00102030, 0, 0xff405060};

static size_t write_header(unsigned char* out, const char* data)
{
    return (size_t)sprintf((char*)out,
                           "%sWIDTH 1\nHEIGHT 3\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA %s\n",
                           fields, data);
}

static void write_row(unsigned char row[ROW], size_t i)
{
    memset(row, 0, ROW);
    for (size_t k = 0; k < 6; ++k) {
        stp_write_f32(row + 4 * k, values[i][k]);
    }
    stp_write_u32(row + 24, colors[i]);
    stp_write_f32(row + 28, values[i][6]);
    row[32] = (unsigned char)(i + 5);
}

static size_t write_binary(unsigned char* out)
{
    size_t at = write_header(out, "binary");
    for (size_t i = 0; i < POINTS; ++i, at += ROW) {
        write_row(out + at, i);
    }
    return at;
}

static size_t write_compressed(unsigned char* out)
{
    static const size_t sizes[] = {4, 4, 4, 4, 4, 4, 4, 4, 1, 4};
    unsigned char columns[POINTS * ROW], row[ROW];
    for (size_t i = 0; i < POINTS; ++i) {
        write_row(row, i);
        for (size_t k = 0, from = 0, to = 0; k < 10; ++k) {
            memcpy(columns + to + i * sizes[k], row + from, sizes[k]);
            from += sizes[k];
            to += POINTS * sizes[k];
        }
    }
    size_t at = write_header(out, "binary_compressed");
    unsigned packed = lzf_compress(columns, sizeof(columns), out + at + 8, sizeof(columns) - 1);
    stp_write_u32(out + at, packed);
    stp_write_u32(out + at + 4, sizeof(columns));
    return packed == 0 ? 0 : at + 8 + packed;
}

// Colours as a whole number and as the float with the same bits.
static size_t write_ascii(unsigned char* out)
{
    size_t at = write_header(out, "ascii");
    for (size_t i = 0; i < POINTS; ++i) {
        const float* v = values[i];
        for (size_t k = 0; k < 6; ++k) {
            at += (size_t)sprintf((char*)out + at, "%.9g ", (double)v[k]);
        }
        float same;
        memcpy(&same, &colors[i], sizeof(same));
        at += i == 0 ? (size_t)sprintf((char*)out + at, "%.9g", (double)same)
                     : (size_t)sprintf((char*)out + at, "%u", colors[i]);
        at += (size_t)sprintf((char*)out + at, " %g %zu 0 0 0 0\n", (double)v[6], i + 5);
    }
    return at;
}

typedef size_t (*writer)(unsigned char*);
static const writer writers[] = {write_binary, write_compressed, write_ascii};

static const stp_scan_field* field_named(const stp_scan_info* info, const char* name)
{
    for (uint32_t i = 0; i < info->field_count; ++i) {
        if (strcmp(info->fields[i].name, name) == 0) {
            return &info->fields[i];
        }
    }
    return NULL;
}

void test_pcd_headers_are_described(test_state* test)
{
    static const char* const versions[] = {"binary", "binary_compressed", "ascii"};
    for (size_t w = 0; w < 3; ++w) {
        unsigned char bytes[2048];
        size_t size = writers[w](bytes);
        stp_scan_info info;
        stp_scene* scene = NULL;
        stp_context* context = test_context(NULL, 1, NULL);
        CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
        CHECK_EQUAL(STP_OK, stp_import_memory(scene, "a.pcd", bytes, size,
                                              &(stp_import_desc){.scan = &info}));
        CHECK(strcmp(info.format, "pcd") == 0 && strcmp(info.version, versions[w]) == 0);
        CHECK_EQUAL(POINTS, info.point_count);
        CHECK(info.scan_count == 1 && info.point_format == -1);
        CHECK_EQUAL(w == 2 ? 0 : ROW, info.record_bytes);
        CHECK(info.compressed == (w == 1));
        CHECK(strcmp(info.compressor, w == 1 ? "LZF" : "") == 0);
        CHECK_EQUAL(9, info.field_count); // padding is no field
        const stp_scan_field *x = field_named(&info, "x"), *label = field_named(&info, "label");
        CHECK(x != NULL && strcmp(x->type, "f32") == 0 && x->count == 1 && x->kept);
        CHECK(label != NULL && strcmp(label->type, "u8") == 0 && label->count == 1);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_pcd_fields_of_every_type_are_described(test_state* test)
{
    static const char bytes[] = "VERSION 0.7\nFIELDS x y z a b c d e f\nSIZE 8 8 8 1 2 4 8 2 4\n"
                                "TYPE F F F I I I U U U\nCOUNT 1 1 1 1 2 3 1 1 1\n"
                                "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n"
                                "1 2 3 4 5 5 6 6 6 7 8 9\n";
    static const struct {
        const char *name, *type;
        uint32_t count;
    } expected[] = {{"x", "f64", 1}, {"a", "i8", 1},  {"b", "i16", 2}, {"c", "i32", 3},
                    {"d", "u64", 1}, {"e", "u16", 1}, {"f", "u32", 1}};
    stp_scan_info info;
    stp_scene* scene = NULL;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    CHECK_EQUAL(STP_OK, stp_import_memory(scene, "a.pcd", bytes, strlen(bytes),
                                          &(stp_import_desc){.scan = &info}));
    for (size_t i = 0; i < sizeof(expected) / sizeof(expected[0]); ++i) {
        const stp_scan_field* field = field_named(&info, expected[i].name);
        CHECK(field != NULL && strcmp(field->type, expected[i].type) == 0);
        CHECK_EQUAL(expected[i].count, field->count);
        CHECK(field->kept == (i == 0));
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_pcd_encodings(test_state* test)
{
    for (size_t w = 0; w < 3; ++w) {
        unsigned char bytes[2048];
        size_t size = writers[w](bytes);
        CHECK(size > 0);
        test_log log = {0};
        stp_context* context = test_context(NULL, 2, &log);
        stp_result result;
        stp_scene* scene =
            import_bytes(context, "a.bin", bytes, size, &result); // recognised by content
        CHECK_EQUAL(STP_OK, result);
        CHECK_EQUAL(1, log.warnings); // the unit
        const stp_point_set* p = &scene->point_sets[0];
        CHECK_EQUAL(2, p->point_count);
        CHECK(is_near(place_of(scene, 0, 0, 0), 500001, 2.5, 3, 0));
        CHECK(is_near(place_of(scene, 0, 0, 1), 500002, -2.5, 4, 0));
        CHECK(p->normals[1] == 1.0f && p->normals[5] == -1.0f);
        CHECK(p->colors[0] == 0x10 && p->colors[1] == 0x20 && p->colors[2] == 0x30 &&
              p->colors[3] == 255);
        CHECK(p->colors[4] == 0x40 && p->colors[6] == 0x60);
        const uint16_t* intensities = p->attributes[STP_ATTRIBUTE_INTENSITY];
        const uint8_t* classes = p->attributes[STP_ATTRIBUTE_CLASS];
        CHECK_EQUAL(2570, intensities[0]);
        CHECK_EQUAL(65535, intensities[1]);
        CHECK_EQUAL(5, classes[0]);
        CHECK_EQUAL(7, classes[1]);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK(is_the_same_everywhere("a.pcd", bytes, size));
        CHECK(survives_truncation("a.pcd", bytes, size));
        CHECK(survives_failing_allocator("a.pcd", bytes, size));
    }
}

void test_pcd_types(test_state* test)
{
    static const char header[] =
        "VERSION .7\nFIELDS x y z\nSIZE 8 2 1\nTYPE F I I\nPOINTS 1\nDATA binary\n";
    unsigned char bytes[256];
    size_t at = strlen(header);
    memcpy(bytes, header, at);
    stp_write_f64(bytes + at, 5400000.125);
    stp_write_u16(bytes + at + 8, 0xfffe);
    bytes[at + 10] = 0xfd;
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.pcd", bytes, at + 11, &result);
    CHECK(scene != NULL);
    CHECK(is_near(place_of(scene, 0, 0, 0), 5400000.125, -2, -3, 0));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_pcd_packed_colors_of_texts(test_state* test)
{
    static const char text[] =
        "FIELDS x y z rgba\nSIZE 4 4 4 4\nTYPE F F F I\nPOINTS 3\nDATA ascii\n"
        "0 0 0 1056816\n0 0 1 -12562336\n0 0 2 4282404960\n";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.pcd", text, strlen(text), &result);
    CHECK(scene != NULL);
    const uint8_t* c = scene->point_sets[0].colors;
    CHECK(c[0] == 0x10 && c[1] == 0x20 && c[2] == 0x30);
    for (size_t i = 1; i < 3; ++i) {
        CHECK(c[4 * i] == 0x40 && c[4 * i + 1] == 0x50 && c[4 * i + 2] == 0x60);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_pcd_bad_input_is_one_sentence(test_state* test)
{
    static const struct {
        const char* text;
        stp_result result;
        const char* says;
    } cases[] = {
        {"", STP_ERROR_TRUNCATED, "ends in its header"},
        {"FIELDS x y z\nSIZE 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n0 0 0\n", STP_ERROR_FORMAT,
         "2 SIZE"},
        {"FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nPOINTS 1\nDATA ascii\n0 0 0\n", STP_ERROR_FORMAT,
         "line 2"},
        {"FIELDS x y z\nSIZE 4 4 4\nTYPE F F Q\nPOINTS 1\nDATA ascii\n0 0 0\n", STP_ERROR_FORMAT,
         "line 3"},
        {"FIELDS x y z\nSIZE 4 4 2\nTYPE F F F\nPOINTS 1\nDATA ascii\n0 0 0\n", STP_ERROR_FORMAT,
         "2 bytes"},
        {"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nDATA ascii\n0 0 0\n", STP_ERROR_FORMAT,
         "neither POINTS"},
        {"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nPOINTS 1\nDATA ascii\n0 0 0\n",
         STP_ERROR_FORMAT, "is 2"},
        {"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA cipher\n", STP_ERROR_FORMAT,
         "line 5"},
        {"FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 1\nDATA ascii\n0 0\n", STP_ERROR_FORMAT,
         "no fields x, y and z"},
        {"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA ascii\n0 0 0\n", STP_ERROR_TRUNCATED,
         "after 1"},
        {"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA ascii\n0 0 0\n0 y 0\n",
         STP_ERROR_FORMAT, "line 7"},
        {"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 99999999999\nDATA binary\n0 0 0\n",
         STP_ERROR_TRUNCATED, "after 0"},
        {"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 9223372036854775808\nDATA ascii\n0 0 0\n",
         STP_ERROR_FORMAT, "line 4: expected a count below 2^48"},
        {"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 18446744073709551617\nHEIGHT 1\nDATA ascii\n",
         STP_ERROR_FORMAT, "line 4: expected a count below 2^48"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        CHECK(is_refused("a.pcd", cases[i].text, strlen(cases[i].text), cases[i].result,
                         cases[i].says));
    }
    // sizes that a small file cannot expand to, and bytes that expand to nothing
    unsigned char bytes[2048];
    size_t size = write_compressed(bytes),
           body = write_header((unsigned char[1024]){0}, "binary_compressed");
    bytes[body + 8] = 0xff;
    CHECK(is_refused("a.pcd", bytes, size, STP_ERROR_FORMAT, "damaged"));
    stp_write_u32(bytes + body + 4, 0xfffffff0);
    CHECK(is_refused("a.pcd", bytes, size, STP_ERROR_FORMAT, "do not fit"));
    stp_write_u32(bytes + body, 0xfffffff0);
    CHECK(is_refused("a.pcd", bytes, size, STP_ERROR_TRUNCATED, "bytes of compressed points"));
}
