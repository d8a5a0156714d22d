// SPDX-License-Identifier: MIT
//
// Text files of points: columns, values, and invalid lines.
#include "points_test.h"

#include "import/text/text_columns.h"
#include "import/text/text_scan.h"

static stp_scene* import_text(stp_context* context, const char* name, const char* text)
{
    stp_result result;
    return import_bytes(context, name, text, strlen(text), &result);
}

// A text, and the expected second point.
typedef struct text_case {
    const char *name, *text;
    int points;
    int color[3];   ///< -1: the cloud has none
    int intensity;  ///< -1: the cloud has none
    float normal_y; ///< 2: the cloud has none
    int class;      ///< -1: the cloud has none
} text_case;

static int is_as_wanted(const text_case* c)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = import_text(context, c->name, c->text);
    int good = scene != NULL && scene->point_set_count == 1;
    if (good) {
        const stp_point_set* p = &scene->point_sets[0];
        const uint16_t* intensities = p->attributes[STP_ATTRIBUTE_INTENSITY];
        const uint8_t* classes = p->attributes[STP_ATTRIBUTE_CLASS];
        good = p->point_count == (uint32_t)c->points &&
               is_near(place_of(scene, 0, 0, 1), 1, 2, 3, 1e-6);
        good = good && (p->colors != NULL) == (c->color[0] >= 0);
        for (int i = 0; good && i < 3 && p->colors != NULL; ++i) {
            good = p->colors[4 + i] == c->color[i];
        }
        good = good && (intensities != NULL ? intensities[1] : -1) == c->intensity;
        good = good && (p->normals != NULL ? p->normals[4] : 2.0f) == c->normal_y;
        good = good && (classes != NULL ? classes[1] : -1) == c->class;
    }
    if (!good) {
        fprintf(stderr, "%s: not as wanted: %s\n", c->name, c->text);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    return good;
}

#define NO_COLOR                                                                                   \
    {                                                                                              \
        -1, -1, -1                                                                                 \
    }

void test_xyz_columns_are_found(test_state* test)
{
    static const text_case cases[] = {
        {"a.xyz", "0 0 0\n1 2 3\n", 2, NO_COLOR, -1, 2, -1},
        {"no_end.xyz", "0 0 0\n1 2 3", 2, NO_COLOR, -1, 2, -1},
        {"crlf.xyz", "0 0 0\r\n1 2 3\r\n\r\n", 2, NO_COLOR, -1, 2, -1},
        {"a.txt", "0\t0\t0\n1\t2\t3\n", 2, NO_COLOR, -1, 2, -1},
        {"a.csv", "0, 0, 0\n1,2,3\n", 2, NO_COLOR, -1, 2, -1},
        {"a.asc", "0;0;0\n1; 2 ;3\n", 2, NO_COLOR, -1, 2, -1},
        {"comments.xyz", "# made by a test\n0 0 0\n// between\n\n1 2 3\n# end\n", 2, NO_COLOR, -1,
         2, -1},
        {"rgb.xyz", "0 0 0 255 0 9\n1 2 3 7 8 9\n", 2, {7, 8, 9}, -1, 2, -1},
        {"bright.xyz", "0 0 0 0.5 0 1\n1 2 3 1.0 0.2 0.0\n", 2, {255, 51, 0}, -1, 2, -1},
        {"deep.xyz", "0 0 0 65535 0 0\n1 2 3 257 514 771\n", 2, {1, 2, 3}, -1, 2, -1},
        {"normals.xyz", "0 0 0 1 0 0\n1 2 3 0 -1 0\n", 2, NO_COLOR, -1, -1, -1},
        {"both.xyz", "0 0 0 9 9 9 0.6 0.8 0\n1 2 3 7 8 9 0 1 0\n", 2, {7, 8, 9}, -1, 1, -1},
        {"swapped.xyz", "0 0 0 0.6 0.8 0 9 9 9\n1 2 3 0 1 0 7 8 9\n", 2, {7, 8, 9}, -1, 1, -1},
        {"i.xyz", "0 0 0 0.5\n1 2 3 1\n", 2, NO_COLOR, 65535, 2, -1},
        {"i255.xyz", "0 0 0 0\n1 2 3 255\n", 2, NO_COLOR, 65535, 2, -1},
        {"i65535.xyz", "0 0 0 256\n1 2 3 1000\n", 2, NO_COLOR, 1000, 2, -1},
        {"signed.xyz", "0 0 0 -2048\n1 2 3 2047\n", 2, NO_COLOR, 65535, 2, -1},
        {"decibel.xyz", "0 0 0 -5000\n1 2 3 5000\n1 2 3 0\n", 3, NO_COLOR, 65535, 2, -1},
        {"irgb.xyz", "0 0 0 -5 1 2 3\n1 2 3 -2048 7 8 9\n", 2, {7, 8, 9}, 0, 2, -1},
        {"rgbi.xyz", "0 0 0 1 2 3 0.5\n1 2 3 7 8 9 1.0\n", 2, {7, 8, 9}, 65535, 2, -1},
        {"a.pts", "2\n0 0 0 5 1 2 3\n1 2 3 255 7 8 9\n", 2, {7, 8, 9}, 65535, 2, -1},
        {"blocks.pts",
         "1\n0 0 0 5 1 2 3\n2\n1 2 3 255 7 8 9\n1 1 1 0 0 0 0\n",
         3,
         {7, 8, 9},
         65535,
         2,
         -1},
        {"header.csv", "Class,X,Y,Z,q,Intensity\n1,0,0,0,,1\n6,1,2,3,text,0.0\n", 2, NO_COLOR, 0, 2,
         6},
        {"cloud.txt",
         "//X Y Z R G B Intensity\n2\n0 0 0 1 2 3 0\n1 2 3 7 8 9 1\n",
         2,
         {7, 8, 9},
         65535,
         2,
         -1},
        {"gps.csv", "\"Easting\";\"Northing\";\"Elevation\"\n0;0;0\n1;2;3\n", 2, NO_COLOR, -1, 2,
         -1},
        {"nan.xyz", "0 0 0\n1 2 3\nnan nan nan\n5 5 5\n", 3, NO_COLOR, -1, 2, -1},
        {"signs.xyz", "-0 +0 .0\n+1 2. 3e0\n", 2, NO_COLOR, -1, 2, -1},
        {"mark.xyz",
         "\xef\xbb\xbf"
         "0 0 0\n1 2 3\n",
         2, NO_COLOR, -1, 2, -1},
        {"mark.csv", "\xef\xbb\xbfZ,Y,X\r\n0,0,0\r\n3,2,1\r\n", 2, NO_COLOR, -1, 2, -1},
        {"mark.pts",
         "\xef\xbb\xbf"
         "2\n0 0 0\n1 2 3\n",
         2, NO_COLOR, -1, 2, -1},
        {"semicolon.txt", "0,0,0;5\n1,2,3;255\n", 2, NO_COLOR, 65535, 2, -1},
        {"returns.xyz", "0 0 0\r\r\n1 2 3\r\r\n", 2, NO_COLOR, -1, 2, -1},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        CHECK(is_as_wanted(&cases[i]));
    }
}

void test_xyz_columns_are_named(test_state* test)
{
    static const char text[] = "9 3 2 1 4 7 8 9 65535\n9 0 0 0 4 1 2 3 0\n";
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = NULL;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    stp_import_desc desc = {.columns = "-,z,y,x,class,b,g,r,intensity"};
    CHECK_EQUAL(STP_OK, stp_import_memory(scene, "a.xyz", text, strlen(text), &desc));
    const stp_point_set* p = &scene->point_sets[0];
    CHECK(is_near(place_of(scene, 0, 0, 0), 1, 2, 3, 1e-9));
    CHECK_EQUAL(9, p->colors[0]);
    CHECK_EQUAL(7, p->colors[2]);
    CHECK_EQUAL(4, ((uint8_t*)p->attributes[STP_ATTRIBUTE_CLASS])[0]);
    CHECK_EQUAL(65535, ((uint16_t*)p->attributes[STP_ATTRIBUTE_INTENSITY])[0]);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    static const char* const wrong[] = {"",        "x,y",         "x,y,z,q", "x,y,z,x",
                                        "x,y,z,r", "x,y,z,nx,ny", "x,y,z,"};
    stp_columns columns;
    for (size_t i = 0; i < sizeof(wrong) / sizeof(wrong[0]); ++i) {
        CHECK(stp_columns_parse(wrong[i], &columns) != NULL);
    }
    CHECK(stp_columns_parse("x,y,z,-,-", &columns) == NULL);
    CHECK_EQUAL(3, columns.count);
    CHECK_EQUAL(2, columns.unused);
}

void test_xyz_bad_input_is_one_sentence(test_state* test)
{
    static const struct {
        const char *name, *text;
        stp_result result;
        const char* says;
    } cases[] = {
        {"a.xyz", "", STP_ERROR_FORMAT, "none of its first"},
        {"a.txt", "some text\nof words\n", STP_ERROR_FORMAT, "none of its first"},
        {"a.xyz", "0 0 0\n1 2\n3 3 3\n", STP_ERROR_FORMAT, "line 2"},
        {"a.xyz", "0 0 0\n1 2 three\n3 3 3\n", STP_ERROR_FORMAT, "line 2"},
        {"a.xyz", "0 0 0\n1 2 3x\n3 3 3\n", STP_ERROR_FORMAT, "line 2"},
        {"a.csv", "0,0,0\n1,,3\n3,3,3\n", STP_ERROR_FORMAT, "line 2"},
        {"a.csv", "x;y;z\n0,5;1,5;2,5\n1,5;2,5;3,5\n", STP_ERROR_FORMAT,
         "line 2: its numbers have decimal commas"},
        {"a.xyz", "12 1,5\t-2,5 255\n", STP_ERROR_FORMAT, "decimal commas"},
        {"a.xyz", "0 0 0\r1 2 3\r", STP_ERROR_FORMAT, "line 1: contains carriage returns"},
        {"a.pts", "3\n0 0 0\n1 2 3\n", STP_ERROR_TRUNCATED, "say 3 points, but it has 2"},
        {"a.pts", "1\n0 0 0\n2\n1 2 3\n", STP_ERROR_TRUNCATED, "say 3 points, but it has 2"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        CHECK(is_refused(cases[i].name, cases[i].text, strlen(cases[i].text), cases[i].result,
                         cases[i].says));
    }
}

void test_xyz_losses_are_counted(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene =
        import_text(context, "a.xyz", "0 0 0 0.5 7 w\nnan 0 0 1 7 w\n1 2 3 0.5 7 w\n4 4");
    CHECK(scene != NULL && scene->point_sets[0].point_count == 2);
    CHECK_EQUAL(2, log.warnings); // the unit, and skipped content
    CHECK(strstr(log.warning, "1 point without a finite position") != NULL);
    CHECK(strstr(log.warning, "1 unfinished last line") != NULL);
    CHECK(strstr(log.warning, "2 point columns") != NULL);
    stp_scene_destroy(scene);
    static const char more[] = "1\n0 0 0\n1 2 3\n"; // than the count; with a unit
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    CHECK_EQUAL(STP_OK, stp_import_memory(scene, "a.pts", more, sizeof(more) - 1,
                                          &(stp_import_desc){.unit_metres = 1.0}));
    CHECK(scene->point_sets[0].point_count == 2);
    CHECK_EQUAL(3, log.warnings);
    CHECK(strstr(log.warning, "1 points, but it has 2") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_xyz_far_places_keep_their_digits(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = import_text(
        context, "a.xyz", "612345.123 5412345.678 512.125\n612346.124 5412344.679 -0.001\n");
    CHECK(scene != NULL);
    CHECK(is_near(place_of(scene, 0, 0, 0), 612345.123, 5412345.678, 512.125, 1e-4));
    CHECK(is_near(place_of(scene, 0, 0, 1), 612346.124, 5412344.679, -0.001, 1e-4));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Many lines in several blocks, including comments; only the last line reveals the scale.
static char* write_many(size_t* size)
{
    char* text = malloc(5 << 20);
    size_t at = 0;
    for (int i = 0; text != NULL && i < 90000; ++i) {
        at += (size_t)sprintf(text + at, "%d.%03d %d %.7f %d %d %d %d\n", i % 977, i % 1000, -i,
                              i * 1e-4, i % 256, i * 3 % 256, i * 7 % 256,
                              i == 89999 ? 60000 : i % 200);
        if (i % 1000 == 500) {
            at += (size_t)sprintf(text + at, "# a comment\n");
        }
    }
    *size = at;
    return text;
}

void test_xyz_threads_and_spill_change_nothing(test_state* test)
{
    size_t size;
    char* text = write_many(&size);
    CHECK(text != NULL && size > 3 << 20);
    CHECK(is_the_same_everywhere("a.xyz", text, size));
    stp_context* context = test_context(NULL, 3, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.xyz", text, size, &result);
    CHECK(scene != NULL);
    CHECK_EQUAL(90000, scene->point_sets[0].point_count);
    const uint16_t* intensities = scene->point_sets[0].attributes[STP_ATTRIBUTE_INTENSITY];
    CHECK(intensities != NULL);
    CHECK_EQUAL(60000, intensities[89999]);
    CHECK_EQUAL(1, intensities[1]);
    for (size_t i = 0; i < 90000; i += 101) {
        CHECK(scene->point_sets[0].positions[3 * i + 1] == (float)-(double)i);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(text);
}

void test_xyz_survives_truncation_and_failing_allocator(test_state* test)
{
    static const char text[] = "//X Y Z R G B Intensity\n2\n0 0 0 1 2 3 0.25\n1 2 3 7 8 9 1.0\n";
    CHECK(survives_truncation("a.xyz", text, strlen(text)));
    CHECK(survives_truncation("a.pts", text, strlen(text)));
    CHECK(survives_failing_allocator("a.xyz", text, strlen(text)));
}

// Lines without line ends, and line ends without lines.
void test_xyz_odd_texts(test_state* test)
{
    size_t size = 3 << 20;
    char* text = malloc(size);
    CHECK(text != NULL);
    memset(text, '7', size);
    CHECK(is_refused("a.xyz", text, size, STP_ERROR_FORMAT, "none of its first"));
    memset(text, '\n', size);
    CHECK(is_refused("a.xyz", text, size, STP_ERROR_FORMAT, "none of its first"));
    memcpy(text, "1 2 3\n", 6); // the rest are blank lines, which leave no points
    stp_context* context = test_context(NULL, 2, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.xyz", text, size, &result);
    CHECK(scene != NULL && scene->point_sets[0].point_count == 1);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(text);
}

void test_text_scan_variants_agree(test_state* test)
{
    static const char* const texts[] = {"0",
                                        "-0",
                                        "7",
                                        "12345678",
                                        "1234567",
                                        "-1234567.1234567",
                                        "1.5e3",
                                        "1e-3",
                                        "123456789.5",
                                        ".5",
                                        "5.",
                                        "0.00000001",
                                        "1234567.12345678901",
                                        "-.25",
                                        "84.64125",
                                        "1.#IND",
                                        "nan",
                                        "-inf",
                                        "00012.50",
                                        "1234567.123456789012345",
                                        "99999999999999999999.5",
                                        "0.1234567",
                                        "0.12345678",
                                        "0.123456789",
                                        "3.14159265358979",
                                        "-7.e2"};
    for (size_t i = 0; i < sizeof(texts) / sizeof(texts[0]); ++i) {
        char line[STP_SCAN_MARGIN + 64];
        memset(line, '9', sizeof(line)); // bytes after the end must not count
        size_t length = strlen(texts[i]);
        memcpy(line, texts[i], length);
        for (size_t k = 0; k < 2; ++k) {
            line[length] = k == 0 ? '\n' : ' ';
            line[length + 1 + k] = '\n';
            double wanted = -1.0, got = -1.0;
            stp_text a = stp_read_number((stp_text)line, &wanted);
            stp_text b = stp_scan_number((stp_text)line, &got);
            CHECK(a == b);
            CHECK(memcmp(&wanted, &got, sizeof(got)) == 0 || (isnan(wanted) && isnan(got)));
        }
    }
    CHECK(stp_scan_number(
              (stp_text) "x\n                                                                    ",
              &(double){0}) == NULL);
}

// Random numbers of up to 18 digits, and their ends, against the C library: the same bits up to 15
// digits, else two units in the last place at most, and those of the other reader.
void test_text_scan_agrees_with_strtod(test_state* test)
{
    uint64_t random = 1;
    for (size_t i = 0; i < 200000; ++i) {
        char line[STP_SCAN_MARGIN + 64], *end = NULL;
        random = random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        int whole = 1 + (int)(random >> 60) % 8, fraction = (int)(random >> 56 & 15) % 11;
        uint64_t digits = random >> 8;
        size_t length = 0;
        memset(line, '9', sizeof(line));
        line[length] = '-';
        length += random >> 55 & 1;
        for (int k = 0; k < whole + fraction; ++k) {
            if (k == whole) {
                line[length++] = '.';
            }
            line[length++] = (char)('0' + digits % 10);
            digits /= 10;
        }
        line[length] = " ,\t\n"[i % 4];
        line[length + 1] = '\n';
        double got = -1.0, wanted = strtod(line, &end);
        CHECK((char*)(uintptr_t)stp_scan_number((stp_text)line, &got) == end);
        bool exact = whole + fraction <= 15;
        CHECK(exact
                  ? memcmp(&wanted, &got, sizeof(got)) == 0
                  : fabs(wanted - got) <= 2.0 * (nextafter(fabs(wanted), HUGE_VAL) - fabs(wanted)));
        CHECK(stp_read_number((stp_text)line, &wanted) != NULL &&
              memcmp(&wanted, &got, sizeof(got)) == 0);
    }
}

// Lines without points, in any of the blocks that are read together, and blanks of every kind.
void test_xyz_blocks_with_other_lines(test_state* test)
{
    enum { LINES = 150000 };
    static const char* const between[] = {" ", ",", "\t", " ; ", "  ", ", "};
    char* text = malloc((size_t)LINES * 48);
    CHECK(text != NULL);
    size_t size = 0, points = 0;
    for (size_t i = 0; i < LINES; ++i) {
        const char *a = between[i % 6], *b = between[i / 6 % 6];
        if (i % 997 == 5) {
            size += (size_t)sprintf(text + size, "# %zu\n", i);
            continue;
        }
        points += 1;
        size += (size_t)sprintf(text + size, "%zu.25%s-%zu%s%zu.5%s\n", i, a, i, b, i % 100,
                                i % 3 == 0 ? " \r" : "");
    }
    CHECK(size > 5 << 19); // an odd number of blocks
    CHECK(is_the_same_everywhere("a.xyz", text, size));
    stp_context* context = test_context(NULL, 2, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.xyz", text, size, &result);
    CHECK(scene != NULL);
    CHECK_EQUAL(points, scene->point_sets[0].point_count);
    const float *first = scene->point_sets[0].positions, *at = first;
    for (size_t i = 0; i < LINES; ++i) {
        if (i % 997 != 5) {
            CHECK(at[0] - first[0] == (float)i && at[1] - first[1] == -(float)i &&
                  at[2] == (float)(i % 100) + 0.5f);
            at += 3;
        }
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(text);
}
