// SPDX-License-Identifier: MIT
#include "formats_test.h"

#include "base/io/bytes.h"

#include <math.h>

// A byte buffer, in either byte order.
typedef struct buffer {
    unsigned char bytes[8192];
    size_t size;
    int big;
} buffer;

static void put_text(buffer* b, const char* text)
{
    memcpy(b->bytes + b->size, text, strlen(text));
    b->size += strlen(text);
}

static void put(buffer* b, uint64_t value, size_t size)
{
    for (size_t i = 0; i < size; ++i) {
        size_t shift = 8 * (b->big ? size - 1 - i : i);
        b->bytes[b->size++] = (unsigned char)(value >> shift);
    }
}

static void put_float(buffer* b, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof(bits));
    put(b, bits, 4);
}

static void put_double(buffer* b, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof(bits));
    put(b, bits, 8);
}

static const char ascii[] =
    "ply\r\nformat ascii 1.0\ncomment a quad and a triangle\nobj_info none\n"
    "element vertex 5\nproperty float x\nproperty double y\nproperty float32 z\n"
    "property float nx\nproperty float ny\nproperty float nz\n"
    "property uchar red\nproperty uchar green\nproperty uint8 blue\n"
    "property float s\nproperty float t\nproperty int flags\n"
    "element extra 2\nproperty list uchar short data\nproperty float weight\n"
    "element face 3\nproperty uchar quality\nproperty list uchar int vertex_indices\n"
    "end_header\n"
    "0 0 0 0 0 2 255 0 0 0 0 7\n1 0 0 0 0 2 0 255 0 1 0 7\n"
    "1 1 0 0 0 2 0 0 255 1 1 7\n0 1 0 0 0 2 51 51 51 0 1 7\n"
    "2 0.5 0 0 0 2 0 0 0 0.25 0.75 7\n"
    "3 1 2 3 0.5\n0 1\n9 4 0 1 2 3\n9 3 1 4 2\n9 2 0 1\n";

static int check_ascii_mesh(const stp_scene* scene)
{
    const stp_mesh* mesh = &scene->meshes[0];
    return scene->mesh_count == 1 && mesh->vertex_count == 5 && mesh->triangle_count == 3 &&
           mesh->positions[12] == 2.0f && mesh->positions[13] == 0.5f && mesh->normals[2] == 1.0f &&
           mesh->colors[0] == 65535 && mesh->colors[1] == 0 && mesh->colors[12] == 2170 &&
           mesh->colors[3] == 65535 && mesh->texcoords[0][8] == 0.25f &&
           mesh->texcoords[0][9] == 0.25f && mesh->indices[6] == 1 && mesh->indices[7] == 4;
}

void test_ply_ascii_mesh(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.ply", ascii, strlen(ascii), &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(scene_is_sound(scene));
    CHECK(check_ascii_mesh(scene));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// The same mesh as binary, in either order, with other types.
static void make_binary(buffer* b, int big)
{
    static const double rows[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 0.5}};
    static const double uv[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.25, 0.75}};
    static const unsigned red[5] = {65535, 0, 0, 13107, 0}, green[5] = {0, 65535, 0, 13107, 0},
                          blue[5] = {0, 0, 65535, 13107, 0};
    *b = (buffer){.big = big};
    put_text(b, big ? "ply\nformat binary_big_endian 1.0\n"
                    : "ply\nformat binary_little_endian 1.0\n");
    put_text(b, "element vertex 5\nproperty double x\nproperty float y\nproperty float64 z\n"
                "property ushort r\nproperty ushort g\nproperty uint16 b\n"
                "property short nx\nproperty char ny\nproperty float nz\n"
                "property float texture_u\nproperty double texture_v\n"
                "element extra 2\nproperty list uint double data\nproperty float weight\n"
                "element tail 1\nproperty int unused\n"
                "element face 2\nproperty list int uint vertex_index\nproperty uchar "
                "quality\nend_header\n");
    for (int i = 0; i < 5; ++i) {
        put_double(b, rows[i][0]);
        put_float(b, (float)rows[i][1]);
        put_double(b, 0.0);
        put(b, red[i], 2);
        put(b, green[i], 2);
        put(b, blue[i], 2);
        put(b, 0, 2);
        put(b, 0, 1);
        put_float(b, 4.0f);
        put_float(b, (float)uv[i][0]);
        put_double(b, uv[i][1]);
    }
    put(b, 2, 4);
    put_double(b, 1.0);
    put_double(b, 2.0);
    put_float(b, 0.5f);
    put(b, 0, 4);
    put_float(b, 0.5f);
    put(b, 77, 4);
    static const unsigned faces[2][5] = {{4, 0, 1, 2, 3}, {3, 1, 4, 2, 0}};
    for (int i = 0; i < 2; ++i) {
        for (unsigned k = 0; k <= faces[i][0]; ++k) {
            put(b, faces[i][k], 4);
        }
        put(b, 9, 1);
    }
}

void test_ply_binary_mesh(test_state* test)
{
    for (int big = 0; big < 2; ++big) {
        for (uint32_t threads = 1; threads <= 3; ++threads) {
            static buffer b;
            make_binary(&b, big);
            stp_context* context = test_context(NULL, threads, NULL);
            stp_result result;
            stp_scene* scene = import_bytes(context, "a.ply", b.bytes, b.size, &result);
            CHECK_EQUAL(STP_OK, result);
            CHECK(scene_is_sound(scene));
            CHECK(check_ascii_mesh(scene));
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
    }
}

void test_ply_triangle_strips(test_state* test)
{
    static const char text[] = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\n"
                               "property float y\nproperty float z\nelement tristrips 1\n"
                               "property list int int vertex_indices\nend_header\n"
                               "0 0 0 1 0 0 0 1 0 1 1 0 0 2 0 1 2 0\n9 0 1 2 3 4 -1 3 5 4\n";
    static const uint32_t wanted[12] = {0, 1, 2, 2, 1, 3, 2, 3, 4, 3, 5, 4};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.ply", text, strlen(text), &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(4, scene->meshes[0].triangle_count);
    for (int i = 0; i < 12; ++i) {
        CHECK_EQUAL(wanted[i], scene->meshes[0].indices[i]);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_ply_points(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    // colours as floats, an unmeasured point, an empty face element
    static const char text[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nproperty float red\n"
        "property float green\nproperty float blue\nproperty float alpha\n"
        "element face 0\nproperty list uchar int vertex_indices\nend_header\n"
        "1 2 3 1 0.5 0 0.2\nnan nan nan 0 0 0 0\n4 5 6 0 0 1 1";
    stp_scene* scene = import_bytes(context, "a.ply", text, strlen(text), &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(1, scene->point_set_count);
    CHECK_EQUAL(0, scene->mesh_count);
    const stp_point_set* points = &scene->point_sets[0];
    CHECK_EQUAL(2, points->point_count);
    CHECK(points->colors[0] == 255 && points->colors[1] == 128 && points->colors[3] == 51);
    CHECK(points->positions[3] == 4.0f && points->colors[6] == 255);
    stp_scene_destroy(scene);

    // splats: the colour of the first spherical harmonic, no normals if all are zero
    static const char splats[] =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
        "property float y\nproperty float z\nproperty float nx\n"
        "property float ny\nproperty float nz\nproperty float f_dc_0\n"
        "property float f_dc_1\nproperty float f_dc_2\nproperty float opacity\n"
        "end_header\n1 2 3 0 0 0 0 1.7724538509 -9 0.5\n";
    scene = import_bytes(context, "a.ply", splats, strlen(splats), &result);
    CHECK_EQUAL(STP_OK, result);
    points = &scene->point_sets[0];
    CHECK(points->colors[0] == 128 && points->colors[1] == 255 && points->colors[2] == 0);
    CHECK(points->normals == NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// CloudCompare writes floats, PDAL the types of LAS: both become the scene's. A skipped point
// removes its values too.
void test_ply_attributes(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    static const char text[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nproperty float scalar_Intensity\n"
        "property uchar classification\nproperty double gps_time\n"
        "property float scalar_Scan_Angle_Rank\nproperty uchar returnnumber\n"
        "property uchar numberofreturns\nproperty ushort pointsourceid\nproperty uchar nir\n"
        "end_header\n1 2 3 0.5 2 86400.125 -1.5 1 2 400 255\n"
        "nan 2 3 0.25 7 1 1 1 1 1 1\n4 5 6 1 6 86401 90 2 2 65535 0\n";
    stp_scene* scene = import_bytes(context, "a.ply", text, strlen(text), &result);
    CHECK_EQUAL(STP_OK, result);
    const stp_point_set* points = &scene->point_sets[0];
    CHECK_EQUAL(2, points->point_count);
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        CHECK(points->attributes[i] != NULL);
    }
    const uint16_t* intensity = points->attributes[STP_ATTRIBUTE_INTENSITY];
    const uint8_t* class = points->attributes[STP_ATTRIBUTE_CLASS];
    const double* time = points->attributes[STP_ATTRIBUTE_TIME];
    const int16_t* angle = points->attributes[STP_ATTRIBUTE_SCAN_ANGLE];
    const uint16_t* source = points->attributes[STP_ATTRIBUTE_SOURCE];
    const uint16_t* infrared = points->attributes[STP_ATTRIBUTE_NEAR_INFRARED];
    CHECK(intensity[0] == 32768 && intensity[1] == 65535);
    CHECK(class[0] == 2 && class[1] == 6);
    CHECK(time[0] == 86400.125 && time[1] == 86401.0);
    CHECK(angle[0] == -250 && angle[1] == 15000);
    CHECK(source[0] == 400 && source[1] == 65535);
    CHECK(infrared[0] == 65535 && infrared[1] == 0);
    CHECK(((const uint8_t*)points->attributes[STP_ATTRIBUTE_RETURN])[1] == 2);
    CHECK(((const uint8_t*)points->attributes[STP_ATTRIBUTE_RETURNS])[0] == 2);
    stp_scene_destroy(scene);

    // binary; floats above 1 are taken as they are
    unsigned char bytes[512];
    int head = snprintf((char*)bytes, sizeof(bytes),
                        "ply\nformat binary_little_endian 1.0\nelement vertex 2\n"
                        "property float x\nproperty float y\nproperty float z\n"
                        "property float intensity\nend_header\n");
    static const float rows[8] = {0, 0, 0, 0.75f, 1, 0, 0, 300.0f};
    memcpy(bytes + head, rows, sizeof(rows));
    scene = import_bytes(context, "a.ply", (char*)bytes, (size_t)head + sizeof(rows), &result);
    CHECK_EQUAL(STP_OK, result);
    intensity = scene->point_sets[0].attributes[STP_ATTRIBUTE_INTENSITY];
    CHECK(intensity[0] == 1 && intensity[1] == 300);
    CHECK(scene->point_sets[0].attributes[STP_ATTRIBUTE_CLASS] == NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Normalised from their floats in double: gcc 12 skipped the rounding of x and y to floats when
// vectorising.
void test_ply_normals_are_the_same_from_every_compiler(test_state* test)
{
    static const char text[] =
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n"
        "1 2 3 0.295706 0.946062 0.132381\n4 5 6 0.333333333333 0.666666666666 0.7\n";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.ply", text, strlen(text), &result);
    CHECK_EQUAL(STP_OK, result);
    const double given[2][3] = {{0.295706, 0.946062, 0.132381},
                                {0.333333333333, 0.666666666666, 0.7}};
    for (int i = 0; i < 2; ++i) {
        volatile float rounded[3]; // prevents the compiler from removing these
        double square = 0.0;
        for (int k = 0; k < 3; ++k) {
            rounded[k] = (float)given[i][k];
            double value = (double)rounded[k];
            square += value * value;
        }
        for (int k = 0; k < 3; ++k) {
            float expected = (float)((double)rounded[k] / sqrt(square));
            CHECK(scene->point_sets[0].normals[3 * i + k] == expected);
        }
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

#define HEAD "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
#define BINARY "ply\nformat binary_little_endian 1.0\n"

void test_ply_bad_input_is_one_sentence(test_state* test)
{
    static const struct {
        const char* text;
        stp_result result;
        const char* says;
    } cases[] = {
        {"ply\n", STP_ERROR_TRUNCATED, "end_header"},
        {"plywood\n", STP_ERROR_FORMAT, "no PLY signature"},
        {"ply\nformat ternary 1.0\n", STP_ERROR_FORMAT, "ternary"},
        {"ply\nelement vertex many\n", STP_ERROR_FORMAT, "count"},
        {"ply\nproperty float x\n", STP_ERROR_FORMAT, "element before"},
        {HEAD "property list float int z\n", STP_ERROR_FORMAT, "list"},
        {HEAD "property quaternion z\n", STP_ERROR_FORMAT, "quaternion"},
        {HEAD "end_header\n1 2\n", STP_ERROR_FORMAT, "x, y and z"},
        {"ply\nformat ascii 1.0\nend_header\n", STP_ERROR_FORMAT, "no vertex element"},
        {HEAD "property float z\nend_header\n1 2 x   \n", STP_ERROR_FORMAT, "not a number"},
        {HEAD "property float z\nend_header\n1 2        \n", STP_ERROR_TRUNCATED, "row 1"},
        {HEAD "property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
              "0 0 0\n3 0 0 1\n",
         STP_ERROR_FORMAT, "refers to vertex 1"},
        {HEAD "property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
              "0 0 0\n3 0 0 -1\n",
         STP_ERROR_FORMAT, "refers to vertex -1"},
        {HEAD "property float z\nelement face 1\nproperty list uint int vertex_index\nend_header\n"
              "0 0 0\n4000000000 0 0 0\n",
         STP_ERROR_TRUNCATED, "row 1"},
        {BINARY "element vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n"
                "end_header\n0123456789",
         STP_ERROR_TRUNCATED, "4000000000"},
        {BINARY "element vertex 18446744073709551615\nproperty float x\nproperty float y\n"
                "property float z\nend_header\n0123456789",
         STP_ERROR_TRUNCATED, "vertex"},
        {BINARY "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
                "element face 1\nproperty list uint int vertex_index\nend_header\n\xff\xff\xff\xff",
         STP_ERROR_TRUNCATED, "face"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene =
            import_bytes(context, "a.ply", cases[i].text, strlen(cases[i].text), &result);
        if (result != cases[i].result || strstr(log.text, cases[i].says) == NULL) {
            fprintf(stderr, "case %zu says: %s\n", i, log.text);
        }
        CHECK(scene == NULL);
        CHECK_EQUAL(cases[i].result, result);
        CHECK_EQUAL(1, log.errors);
        CHECK(strstr(log.text, cases[i].says) != NULL);
        stp_context_destroy(context);
    }
}

void test_ply_survives_truncation(test_state* test)
{
    static buffer b;
    make_binary(&b, 0);
    CHECK(survives_truncation("a.ply", b.bytes, b.size));
    CHECK(survives_truncation("a.ply", ascii, strlen(ascii)));
}

void test_ply_survives_failing_allocator(test_state* test)
{
    static buffer b;
    make_binary(&b, 1);
    CHECK(survives_failing_allocator("a.ply", b.bytes, b.size));
    CHECK(survives_failing_allocator("a.ply", ascii, strlen(ascii)));
}
