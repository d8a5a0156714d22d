// SPDX-License-Identifier: MIT
//
// E57: values of all encodings, poses, grids, and errors in each part of a file.
#include "e57_writer.h"
#include "points_test.h"

#include "import/reading/scan_info.h"

#define HEAD                                                                                       \
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<e57Root type=\"Structure\" "                     \
    "xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\" xmlns:nor=\"http://nor\">"
#define POINTS                                                                                     \
    "<points type=\"CompressedVector\" fileOffset=\"%llu\" recordCount=\"%llu\"><prototype "       \
    "type=\"Structure\">"
#define END_POINTS "</prototype><codecs type=\"Vector\"/></points>"

enum { COUNT = 700 };

static uint64_t bits_of_double(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof(bits));
    return bits;
}

static uint64_t bits_of_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof(bits));
    return bits;
}

// Two scans: one with all encodings and a pose; one with spherical coordinates, without a name.
static unsigned char* write_two(size_t* size)
{
    static uint64_t v[E57_STREAMS][COUNT];
    for (size_t i = 0; i < COUNT; ++i) {
        v[0][i] = bits_of_double(600000.0 + (double)i * 0.25);
        v[1][i] = bits_of_float((float)i * -0.5f);
        v[2][i] = i * 37;              // scaled: -5000 + i * 37, by 0.001, from 100
        v[3][i] = i % 10 == 9 ? 2 : 0; // no point
        v[4][i] = i % 1001;            // 10 bits: intensity from 0 to 1000
        v[5][i] = i % 256;
        v[6][i] = 255 - i % 256;
        v[8][i] = i % 8; // an unknown field, 3 bits
        v[9][i] = bits_of_double((double)i * 0.125);
    }
    const e57_stream first[] = {{64, v[0]}, {32, v[1]}, {15, v[2]}, {2, v[3]}, {10, v[4]},
                                {8, v[5]},  {8, v[6]},  {0, v[7]},  {3, v[8]}, {64, v[9]}};
    e57_file f = e57_begin();
    unsigned long long a = e57_add_points(&f, first, 10, COUNT, 113);
    for (size_t i = 0; i < COUNT; ++i) {
        v[0][i] = bits_of_double(2.0);
        v[1][i] = bits_of_double((double)i * 0.01);
        v[2][i] = bits_of_double(-0.5);
    }
    const e57_stream second[] = {{64, v[0]}, {64, v[1]}, {64, v[2]}};
    unsigned long long b = e57_add_points(&f, second, 3, COUNT, 1000);
    char* xml = malloc(1 << 14);
    snprintf(xml, 1 << 14,
             HEAD
             "<coordinateMetadata type=\"String\"><![CDATA[EPSG:25832]]></coordinateMetadata>"
             "<data3D type=\"Vector\"><vectorChild type=\"Structure\"><name type=\"String\">"
             "<![CDATA[hall]]></name><pose type=\"Structure\"><rotation type=\"Structure\"><w "
             "type=\"Float\">0.5</w><x type=\"Float\"/><y type=\"Float\"/><z type=\"Float\">0.5</z>"
             "</rotation><translation type=\"Structure\"><x type=\"Float\">1000000</x><y "
             "type=\"Float\">1</y><z type=\"Float\"/></translation></pose><intensityLimits "
             "type=\"Structure\"><intensityMinimum type=\"Integer\"/><intensityMaximum "
             "type=\"Integer\">1000</intensityMaximum></intensityLimits>" POINTS
             "<cartesianX type=\"Float\"/><cartesianY type=\"Float\" precision=\"single\"/>"
             "<cartesianZ type=\"ScaledInteger\" minimum=\"-5000\" maximum=\"20863\" "
             "scale=\"0.001\" offset=\"100\"/><cartesianInvalidState type=\"Integer\" "
             "minimum=\"0\" maximum=\"2\"/><intensity type=\"Integer\" minimum=\"0\" "
             "maximum=\"1023\"/><colorRed type=\"Integer\" minimum=\"0\" maximum=\"255\"/>"
             "<colorGreen type=\"Integer\" minimum=\"0\" maximum=\"255\"/><colorBlue "
             "type=\"Integer\" minimum=\"0\" maximum=\"0\"/><other type=\"Integer\" "
             "minimum=\"0\" maximum=\"7\"/><timeStamp type=\"Float\"/>" END_POINTS
             "</vectorChild><vectorChild type=\"Structure\">" POINTS
             "<sphericalRange type=\"Float\"/><sphericalAzimuth type=\"Float\"/>"
             "<sphericalElevation type=\"Float\"/>" END_POINTS
             "</vectorChild></data3D><images2D type=\"Vector\"><vectorChild "
             "type=\"Structure\"/></images2D></e57Root>\n",
             a, (unsigned long long)COUNT, b, (unsigned long long)COUNT);
    unsigned char* bytes = e57_finish(&f, xml, size);
    free(xml);
    return bytes;
}

void test_e57_codings_and_poses(test_state* test)
{
    size_t size;
    unsigned char* bytes = write_two(&size);
    test_log log = {0};
    stp_context* context = test_context(NULL, 3, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.bin", bytes, size, &result); // recognised by
                                                                             // content
    CHECK_EQUAL(STP_OK, result);
    CHECK(strcmp(scene->sources[0].coordinate_system, "EPSG:25832") == 0);
    CHECK(scene->unit_metres == 1.0 && strcmp(scene->up, "z") == 0);
    CHECK(strstr(log.warning, "1 point column; 1 scanner picture") != NULL);
    CHECK(strcmp(scene->objects[1].name, "hall") == 0);
    CHECK(strcmp(scene->objects[2].name, "scan 2") == 0);
    const stp_point_set* p = &scene->point_sets[0];
    CHECK_EQUAL(COUNT - COUNT / 10, p->point_count);
    for (size_t i = 0, at = 0; i < COUNT; ++i) {
        if (i % 10 == 9) {
            continue;
        }
        double x = 600000.0 + (double)i * 0.25, y = (double)i * -0.5;
        double z = ((double)i * 37 - 5000.0) * 0.001 + 100.0;
        // a quarter turn about z: x to y, y to -x
        CHECK(is_near(place_of(scene, 1, 0, at), 1000000.0 - y, 1.0 + x, z, 1e-4));
        CHECK_EQUAL(i % 256, p->colors[4 * at]);
        CHECK_EQUAL(255 - i % 256, p->colors[4 * at + 1]);
        CHECK_EQUAL(0, p->colors[4 * at + 2]);
        CHECK_EQUAL((int)((double)i * 65.535 + 0.5),
                    ((uint16_t*)p->attributes[STP_ATTRIBUTE_INTENSITY])[at]);
        CHECK(((double*)p->attributes[STP_ATTRIBUTE_TIME])[at] == (double)i * 0.125);
        at += 1;
    }
    CHECK_EQUAL(COUNT, scene->point_sets[1].point_count);
    for (size_t i = 0; i < COUNT; ++i) {
        double angle = (double)i * 0.01;
        CHECK(is_near(place_of(scene, 2, 1, i), 2.0 * cos(-0.5) * cos(angle),
                      2.0 * cos(-0.5) * sin(angle), 2.0 * sin(-0.5), 1e-6));
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(is_the_same_everywhere("a.e57", bytes, size));
    CHECK(survives_failing_allocator("a.e57", bytes, size));
    free(bytes);
}

// Records without a point have no part in the range of intensities.
void test_e57_ranges_are_those_of_valid_records(test_state* test)
{
    enum { RECORDS = 8 };
    uint64_t places[RECORDS], invalid[RECORDS], intensities[RECORDS];
    for (size_t i = 0; i < RECORDS; ++i) {
        places[i] = bits_of_double((double)i);
        invalid[i] = i == 3 ? 1 : 0;
        intensities[i] = bits_of_float(i == 3 ? 1e9f : (float)i / 7.0f);
    }
    const e57_stream streams[] = {
        {64, places}, {64, places}, {64, places}, {1, invalid}, {32, intensities}};
    e57_file f = e57_begin();
    unsigned long long at = e57_add_points(&f, streams, 5, RECORDS, 300);
    char xml[4096];
    snprintf(xml, sizeof(xml),
             HEAD "<data3D type=\"Vector\"><vectorChild type=\"Structure\">" POINTS
                  "<cartesianX type=\"Float\"/><cartesianY type=\"Float\"/><cartesianZ "
                  "type=\"Float\"/><cartesianInvalidState type=\"Integer\" minimum=\"0\" "
                  "maximum=\"1\"/><intensity type=\"Float\" precision=\"single\"/>" END_POINTS
                  "</vectorChild></data3D></e57Root>",
             at, (unsigned long long)RECORDS);
    size_t size;
    unsigned char* bytes = e57_finish(&f, xml, &size);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.e57", bytes, size, &result);
    CHECK_EQUAL(STP_OK, result);
    const stp_point_set* p = &scene->point_sets[0];
    CHECK_EQUAL(RECORDS - 1, p->point_count);
    CHECK_EQUAL(65535, ((uint16_t*)p->attributes[STP_ATTRIBUTE_INTENSITY])[RECORDS - 2]);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(bytes);
}

// A room seen from its centre, in a grid; some cells have no record, one has two.
static unsigned char* write_grid(size_t* size, int normals)
{
    enum { ROWS = 20, COLUMNS = 30 };
    static uint64_t v[8][ROWS * COLUMNS];
    size_t count = 0;
    for (int c = 0; c < COLUMNS; ++c) {
        for (int r = 0; r < ROWS; ++r, ++count) {
            double y = (c - COLUMNS / 2) * 0.05, z = (r - ROWS / 2) * 0.05;
            v[0][count] = bits_of_double(c % 10 < 5 ? 2.0 : 3.0);
            v[1][count] = bits_of_double((c % 10 < 5 ? 2.0 : 3.0) * y);
            v[2][count] = bits_of_double((c % 10 < 5 ? 2.0 : 3.0) * z);
            v[3][count] = (uint64_t)r;
            v[4][count] = (uint64_t)c;
            v[5][count] = bits_of_float(0.0f);
            v[6][count] = bits_of_float(3.0f);
        }
    }
    const e57_stream streams[] = {{64, v[0]}, {64, v[1]}, {64, v[2]}, {5, v[3]},
                                  {5, v[4]},  {32, v[5]}, {32, v[6]}, {32, v[5]}};
    e57_file f = e57_begin();
    unsigned long long at = e57_add_points(&f, streams, normals ? 8 : 5, count, 300);
    char* xml = malloc(1 << 14);
    snprintf(xml, 1 << 14,
             HEAD "<data3D type=\"Vector\"><vectorChild type=\"Structure\">" POINTS
                  "<cartesianX type=\"Float\"/><cartesianY type=\"Float\"/><cartesianZ "
                  "type=\"Float\"/><rowIndex type=\"Integer\" minimum=\"0\" maximum=\"19\"/>"
                  "<columnIndex type=\"Integer\" minimum=\"0\" maximum=\"29\"/>%s" END_POINTS
                  "</vectorChild></data3D></e57Root>",
             at, (unsigned long long)count,
             normals
                 ? "<nor:normalX type=\"Float\" precision=\"single\"/><nor:normalY type=\"Float\" "
                   "precision=\"single\"/><nor:normalZ type=\"Float\" precision=\"single\"/>"
                 : "");
    unsigned char* bytes = e57_finish(&f, xml, size);
    free(xml);
    return bytes;
}

void test_e57_headers_are_described(test_state* test)
{
    static const struct {
        const char *name, *type;
    } expected[] = {{"cartesianX", "f64"},
                    {"cartesianY", "f32"},
                    {"cartesianZ", "scaled integer"},
                    {"cartesianInvalidState", "integer"},
                    {"intensity", "integer"},
                    {"colorRed", "integer"},
                    {"colorGreen", "integer"},
                    {"colorBlue", "integer"},
                    {"other", "integer"},
                    {"timeStamp", "f64"},
                    {"sphericalRange", "f64"},
                    {"sphericalAzimuth", "f64"},
                    {"sphericalElevation", "f64"}};
    size_t size;
    unsigned char* bytes = write_two(&size);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    stp_scan_info info;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    CHECK_EQUAL(STP_OK,
                stp_import_memory(scene, "a.e57", bytes, size, &(stp_import_desc){.scan = &info}));
    CHECK(strcmp(info.format, "e57") == 0 && strcmp(info.version, "1.0") == 0);
    CHECK_EQUAL(2 * COUNT, info.point_count);
    CHECK(info.scan_count == 2 && info.point_format == -1 && info.record_bytes == 0);
    CHECK_EQUAL(sizeof(expected) / sizeof(expected[0]), info.field_count);
    for (uint32_t i = 0; i < info.field_count; ++i) {
        const stp_scan_field* field = &info.fields[i];
        CHECK(strcmp(field->name, expected[i].name) == 0);
        CHECK(strcmp(field->type, expected[i].type) == 0);
        CHECK(field->kept == (strcmp(field->name, "other") != 0));
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(bytes);
}

// More points than are read at a time (runs of 2,048), all with values of their own.
void test_e57_scans_of_many_runs(test_state* test)
{
    enum { LONG = 5000 };
    static uint64_t v[4][LONG];
    for (size_t i = 0; i < LONG; ++i) {
        v[0][i] = bits_of_double((double)i * 0.5);
        v[1][i] = bits_of_float((float)(i % 977));
        v[2][i] = i * 13; // 16 bits
        v[3][i] = bits_of_double((double)i * 0.125);
    }
    const e57_stream streams[] = {{64, v[0]}, {32, v[1]}, {0, v[1]}, {16, v[2]}, {64, v[3]}};
    e57_file f = e57_begin();
    unsigned long long at = e57_add_points(&f, streams, 5, LONG, 777);
    char xml[4096];
    snprintf(xml, sizeof(xml),
             HEAD "<data3D type=\"Vector\"><vectorChild type=\"Structure\"><intensityLimits "
                  "type=\"Structure\"><intensityMinimum type=\"Integer\"/><intensityMaximum "
                  "type=\"Integer\">65535</intensityMaximum></intensityLimits>" POINTS
                  "<cartesianX type=\"Float\"/><cartesianY type=\"Float\" precision=\"single\"/>"
                  "<cartesianZ type=\"Integer\" minimum=\"3\" maximum=\"3\"/>"
                  "<intensity type=\"Integer\" minimum=\"0\" maximum=\"65535\"/>"
                  "<timeStamp type=\"Float\"/>" END_POINTS "</vectorChild></data3D></e57Root>\n",
             at, (unsigned long long)LONG);
    size_t size;
    unsigned char* bytes = e57_finish(&f, xml, &size);
    stp_context* context = test_context(NULL, 2, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.e57", bytes, size, &result);
    CHECK_EQUAL(STP_OK, result);
    const stp_point_set* p = &scene->point_sets[0];
    CHECK_EQUAL(LONG, p->point_count);
    const uint16_t* intensities = p->attributes[STP_ATTRIBUTE_INTENSITY];
    const double* times = p->attributes[STP_ATTRIBUTE_TIME];
    CHECK(intensities != NULL && times != NULL);
    for (size_t i = 0; i < LONG; ++i) {
        CHECK(is_near(place_of(scene, 1, 0, i), (double)i * 0.5, (double)(i % 977), 3.0, 1e-3));
        CHECK_EQUAL(i * 13, intensities[i]);
        CHECK(times[i] == (double)i * 0.125);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(is_the_same_everywhere("a.e57", bytes, size));
    free(bytes);
}

void test_e57_normals(test_state* test)
{
    for (int own = 0; own < 2; ++own) {
        size_t size;
        unsigned char* bytes = write_grid(&size, own);
        stp_context* context = test_context(NULL, 2, NULL);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.e57", bytes, size, &result);
        CHECK(scene != NULL);
        const stp_point_set* p = &scene->point_sets[0];
        CHECK(p->normals != NULL && p->point_count == 600);
        for (size_t i = 0; i < p->point_count; ++i) {
            CHECK(own ? p->normals[3 * i + 1] == 1.0f : p->normals[3 * i] < -0.999f);
        }
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK(is_the_same_everywhere("a.e57", bytes, size));
        CHECK(survives_failing_allocator("a.e57", bytes, size));
        free(bytes);
    }
}

static unsigned char* write_xml(const char* xml, size_t* size)
{
    e57_file f = e57_begin();
    return e57_finish(&f, xml, size);
}

void test_e57_bad_input_is_one_sentence(test_state* test)
{
    size_t size;
    unsigned char* bytes = write_two(&size);
    CHECK(is_refused("a.e57", "", 0, STP_ERROR_TRUNCATED, "shorter"));
    CHECK(is_refused("a.e57", bytes, 40, STP_ERROR_TRUNCATED, "shorter"));
    CHECK(is_refused("a.e57", bytes, size - 1, STP_ERROR_TRUNCATED, "but it ends after"));
    bytes[5000] ^= 4;
    CHECK(is_refused("a.e57", bytes, size, STP_ERROR_FORMAT, "page 5 of"));
    bytes[2000] ^= 4;
    CHECK(is_refused("a.e57", bytes, size, STP_ERROR_FORMAT, "page 2 of"));
    bytes[5000] ^= 4;
    bytes[2000] ^= 4;
    const struct {
        size_t at;
        unsigned char byte;
        stp_result result;
        const char* says;
    } changes[] = {
        {8, 2, STP_ERROR_UNSUPPORTED, "version 2"},
        {41, 8, STP_ERROR_UNSUPPORTED, "2048 bytes"},
        {17, 1, STP_ERROR_FORMAT, "not a whole number of pages"},
        {31, 1, STP_ERROR_FORMAT, "outside the file"},
        {39, 1, STP_ERROR_FORMAT, "outside the file"},
        {0, 'B', STP_ERROR_FORMAT, "no E57 signature"},
        {48, 7, STP_ERROR_FORMAT, "scan 1: no section"},
        {48 + 15, 1, STP_ERROR_FORMAT, "beyond the end of the file"},
        {48 + 23, 1, STP_ERROR_FORMAT, "beyond the end of the file"},
        {48 + 34, 14, STP_ERROR_FORMAT, "invalid size"},
        {48 + 48, 9, STP_ERROR_FORMAT, "unknown type"},
        {48 + 52, 4, STP_ERROR_FORMAT, "different numbers of fields"},
        {48 + 55, 255, STP_ERROR_FORMAT, "longer than the packet"},
        {48 + 48, 2, STP_ERROR_TRUNCATED, "has 700 records, but its packets hold"},
    };
    for (size_t i = 0; i < sizeof(changes) / sizeof(changes[0]); ++i) {
        unsigned char before = bytes[changes[i].at];
        bytes[changes[i].at] = changes[i].byte;
        e57_seal(bytes, size);
        CHECK(is_refused("a.e57", bytes, size, changes[i].result, changes[i].says));
        bytes[changes[i].at] = before;
        e57_seal(bytes, size);
    }
    free(bytes);
}

// Scans that share one section of points would take any amount of memory.
void test_e57_scans_may_not_share_their_points(test_state* test)
{
    enum { SCANS = 20 };
    static uint64_t values[COUNT];
    const e57_stream streams[] = {{64, values}, {64, values}, {64, values}};
    e57_file f = e57_begin();
    unsigned long long section = e57_add_points(&f, streams, 3, COUNT, 1000);
    char* xml = malloc(1 << 14);
    int length = snprintf(xml, 1 << 14, HEAD "<data3D type=\"Vector\">");
    for (int i = 0; i < SCANS; ++i) {
        length += snprintf(xml + length, (1 << 14) - (size_t)length,
                           "<vectorChild type=\"Structure\">" POINTS
                           "<cartesianX type=\"Float\"/><cartesianY type=\"Float\"/>"
                           "<cartesianZ type=\"Float\"/>" END_POINTS "</vectorChild>",
                           section, (unsigned long long)COUNT);
    }
    snprintf(xml + length, (1 << 14) - (size_t)length, "</data3D></e57Root>\n");
    size_t size;
    unsigned char* bytes = e57_finish(&f, xml, &size);
    free(xml);
    CHECK(is_refused("a.e57", bytes, size, STP_ERROR_FORMAT, "are longer than the file"));
    free(bytes);
}

void test_e57_bad_xml_is_one_sentence(test_state* test)
{
    static const struct {
        const char* xml;
        stp_result result;
        const char* says;
    } cases[] = {
        {"", STP_ERROR_FORMAT, "XML section"},
        {"<e57Root", STP_ERROR_FORMAT, "line 1 of its XML section"},
        {"<a>\n<b></a>", STP_ERROR_FORMAT, "line 2 of its XML section"},
        {"<!DOCTYPE a [<!ENTITY b \"bbbbbbbb\">]><a>&b;</a>", STP_ERROR_FORMAT, "document type"},
        {HEAD
         "<data3D><vectorChild><points><prototype><cartesianX type=\"Float\"/></prototype></points>"
         "</vectorChild></data3D></e57Root>",
         STP_ERROR_FORMAT, "no fileOffset"},
        {HEAD
         "<data3D><vectorChild><points fileOffset=\"48\" recordCount=\"9\"><prototype><cartesianX "
         "type=\"Complex\"/></prototype></points></vectorChild></data3D></e57Root>",
         STP_ERROR_FORMAT, "unknown type"},
        {HEAD
         "<data3D><vectorChild><points fileOffset=\"48\" recordCount=\"9\"><prototype><cartesianX "
         "type=\"Integer\" minimum=\"1\" "
         "maximum=\"0\"/></prototype></points></vectorChild></data3D>"
         "</e57Root>",
         STP_ERROR_FORMAT, "invalid bounds"},
        {HEAD
         "<data3D><vectorChild><pose><rotation><w/></rotation></pose><points fileOffset=\"48\" "
         "recordCount=\"9\"><prototype><cartesianX "
         "type=\"Float\"/></prototype></points></vectorChild>"
         "</data3D></e57Root>",
         STP_ERROR_FORMAT, "not a rotation"},
        {HEAD "<data3D><vectorChild><points fileOffset=\"1022\" "
              "recordCount=\"9\"><prototype><cartesianX "
              "type=\"Float\"/><cartesianY type=\"Float\"/><cartesianZ "
              "type=\"Float\"/></prototype></points>"
              "</vectorChild></data3D></e57Root>",
         STP_ERROR_FORMAT, "no section"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        size_t size;
        unsigned char* bytes = write_xml(cases[i].xml, &size);
        CHECK(is_refused("a.e57", bytes, size, cases[i].result, cases[i].says));
        free(bytes);
    }
    char* deep = malloc(4096);
    for (int i = 0; i < 500; ++i) {
        memcpy(deep + 3 * i, "<a>", 4);
    }
    size_t size;
    unsigned char* bytes = write_xml(deep, &size);
    CHECK(is_refused("a.e57", bytes, size, STP_ERROR_FORMAT, "nested too deeply"));
    free(bytes);
    free(deep);
    // reading nothing is not an error
    bytes = write_xml(HEAD "<data3D><vectorChild/></data3D></e57Root>", &size);
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.e57", bytes, size, &result);
    CHECK(scene != NULL && strstr(log.warning, "1 scan without positions") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(bytes);
}

// Every truncation of a file at whole pages, with a matching header, is rejected or valid.
void test_e57_survives_truncation(test_state* test)
{
    size_t size;
    unsigned char* bytes = write_grid(&size, 0);
    CHECK(survives_truncation("a.e57", bytes, size < 3000 ? size : 3000));
    unsigned char* cut = malloc(size);
    for (size_t pages = 1; pages < size / 1024; ++pages) {
        memcpy(cut, bytes, pages * 1024);
        stp_write_u64(cut + 16, pages * 1024);
        stp_write_u64(cut + 24, 100); // the XML offset is now wrong: no XML
        e57_seal(cut, pages * 1024);
        CHECK(is_refused("a.e57", cut, pages * 1024, STP_ERROR_FORMAT, "XML section"));
    }
    free(cut);
    free(bytes);
}
