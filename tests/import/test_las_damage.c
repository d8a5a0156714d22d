// SPDX-License-Identifier: MIT
#include "exhaustive.h"
#include "las_points.h"

enum { COUNT = 120 };

static las_point points[COUNT];

static las_buffer write_small(unsigned format, las_coding coding)
{
    las_make_points(points, COUNT, format, 3);
    las_desc desc = {.points = points,
                     .count = COUNT,
                     .format = format,
                     .coding = coding,
                     .chunk_size = 50,
                     .extra = 2};
    return las_write(&desc);
}

// No point is lost silently: truncated files are rejected with a sentence.
void test_las_refuses_every_truncation(test_state* test)
{
    static const unsigned formats[] = {1, 3, 5, 6, 8, 10};
    for (size_t i = 0; i < sizeof(formats) / sizeof(formats[0]); ++i) {
        for (int coding = LAS_RAW; coding <= LAZ_VARIABLE; coding += LAZ_CHUNKED) {
            las_buffer file = write_small(formats[i], (las_coding)coding);
            for (size_t cut = 0; cut < file.size; ++cut) {
                test_log log = {0};
                stp_context* context = test_context(NULL, 1, &log);
                stp_result result;
                unsigned char* bytes = malloc(cut + 1); // so that a sanitizer detects reads past
                                                        // the end
                memcpy(bytes, file.bytes, cut);
                stp_scene* scene = import_bytes(context, "a.las", bytes, cut, &result);
                free(bytes);
                CHECK(scene == NULL);
                CHECK_EQUAL(1, log.errors);
                CHECK(strncmp(log.text, "a.las: ", 7) == 0);
                stp_context_destroy(context);
            }
            free(file.bytes);
        }
    }
}

/// The place to damage after `at`: all of the header and of the chunk table, some of the points.
static size_t next_place(const las_buffer* file, size_t at)
{
    uint32_t points_at;
    memcpy(&points_at, file->bytes + 96, sizeof(points_at));
    bool within_points = at >= points_at + 64 && at + 64 < file->size;
    return at + (within_points ? test_stride(9) : 1);
}

// For any flipped bit: a valid scene, or one sentence.
void test_las_survives_flipped_bits(test_state* test)
{
    static const unsigned formats[] = {5, 10};
    for (int i = 0; i < 4; ++i) {
        las_buffer file = write_small(formats[i % 2], i < 2 ? LAZ_VARIABLE : LAZ_CHUNKED);
        for (size_t at = 0; at < file.size; at = next_place(&file, at)) {
            unsigned char* bytes = malloc(file.size);
            memcpy(bytes, file.bytes, file.size);
            bytes[at] ^= (unsigned char)(1u << at % 8);
            test_log log = {0};
            stp_context* context = test_context(NULL, 1, &log);
            stp_result result;
            stp_scene* scene = import_bytes(context, "a.laz", bytes, file.size, &result);
            CHECK_EQUAL(scene == NULL, log.errors);
            CHECK(scene == NULL || scene_is_sound(scene));
            stp_scene_destroy(scene);
            stp_context_destroy(context);
            free(bytes);
        }
        free(file.bytes);
    }
}

void test_las_survives_failing_allocator(test_state* test)
{
    static const unsigned formats[] = {3, 8};
    for (int i = 0; i < 4; ++i) {
        las_buffer file = write_small(formats[i % 2], i < 2 ? LAS_RAW : LAZ_CHUNKED);
        CHECK(survives_failing_allocator("a.las", file.bytes, file.size));
        free(file.bytes);
    }
}

typedef struct refusal {
    size_t at, size;
    uint64_t value;
    const char* sentence;
} refusal;

void test_las_refuses_nonsense_in_its_header(test_state* test)
{
    static const refusal wrong[] = {
        {247, 8, 12000000000000000000u, "ends after 120 of the 12000000000000000000 points"},
        {24, 1, 2, "has LAS version 2.4; only 1.0 to 1.4 are supported"},
        {25, 1, 9, "has LAS version 1.9; only 1.0 to 1.4 are supported"},
        {94, 2, 100, "its header has 100 bytes"},
        {104, 1, 11, "its point format is 11; LAS has formats 0 to 10"},
        {104, 1, 128 + 6,
         "its points are compressed, but the VLR that describes the compression is missing"},
        {105, 2, 29, "its points have 29 bytes each; those of format 6 have 30"},
        {131, 8, 0, "the scale of its x is 0"},
        {139, 8, (uint64_t)0x7FF8 << 48, "the scale of its y is nan"},
    };
    for (size_t i = 0; i < sizeof(wrong) / sizeof(wrong[0]); ++i) {
        las_make_points(points, COUNT, 6, 3);
        las_desc desc = {.points = points, .count = COUNT, .format = 6};
        las_buffer file = las_write(&desc);
        for (size_t k = 0; k < wrong[i].size; ++k) {
            file.bytes[wrong[i].at + k] = (unsigned char)(wrong[i].value >> (8 * k));
        }
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.las", file.bytes, file.size, &result);
        if (scene != NULL || strstr(log.text, wrong[i].sentence) == NULL) {
            fprintf(stderr, "%zu: \"%s\"\n", i, log.text);
        }
        CHECK(scene == NULL);
        CHECK(strstr(log.text, wrong[i].sentence) != NULL);
        stp_context_destroy(context);
        free(file.bytes);
    }
}

// Compressed points take almost no space, but not zero.
void test_laz_refuses_absurd_counts(test_state* test)
{
    for (int coding = LAZ_SINGLE; coding <= LAZ_CHUNKED; ++coding) {
        las_buffer file = write_small(1, (las_coding)coding);
        memset(file.bytes + 107, 0xFF, 4);
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.laz", file.bytes, file.size, &result);
        CHECK(scene == NULL);
        CHECK_EQUAL(STP_ERROR_FORMAT, result);
        CHECK(strstr(log.text, "4294967295") != NULL);
        stp_context_destroy(context);
        free(file.bytes);
    }
}

static las_buffer write_claim(unsigned format, uint64_t claimed, size_t padding)
{
    static const unsigned char zeros[10000] = {0};
    las_make_points(points, COUNT, format, 3);
    las_desc desc = {.points = points,
                     .count = COUNT,
                     .format = format,
                     .coding = format < 6 ? LAZ_SINGLE : LAZ_CHUNKED,
                     .chunk_size = 1u << 31};
    las_buffer file = las_write(&desc);
    if (format < 6) {
        memcpy(file.bytes + 107, &claimed, 4);
        las_put(&file, zeros, padding);
    } else {
        memcpy(file.bytes + 247, &claimed, 8);
    }
    return file;
}

// No memory is taken for claimed points before the chunks prove that they exist.
void test_laz_claims_take_no_memory(test_state* test)
{
    static const struct {
        unsigned format;
        uint64_t claimed;
        size_t padding;
        stp_result result;
        const char* says;
    } claims[] = {
        {1, 1000000, 0, STP_ERROR_FORMAT, "1000000 points from byte"},
        {7, 3000000, 0, STP_ERROR_FORMAT, "3000000 points from byte"},
        {1, (1 << 24) + 1, 10000, STP_ERROR_LIMIT, "up to 256 a byte are supported"},
    };
    for (size_t i = 0; i < sizeof(claims) / sizeof(claims[0]); ++i) {
        las_buffer file = write_claim(claims[i].format, claims[i].claimed, claims[i].padding);
        test_log log = {0};
        stp_context* context = NULL;
        const stp_context_desc desc = {.thread_count = 1,
                                       .memory_limit_bytes = 12 << 20,
                                       .log = test_log_message,
                                       .log_user = &log};
        CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.laz", file.bytes, file.size, &result);
        if (result != claims[i].result || strstr(log.text, claims[i].says) == NULL) {
            fprintf(stderr, "%zu: %d: %s\n", i, result, log.text);
        }
        CHECK(scene == NULL);
        CHECK_EQUAL(claims[i].result, result);
        CHECK(strstr(log.text, claims[i].says) != NULL);
        stp_context_destroy(context);
        free(file.bytes);
    }
}

// Equal points take almost no bytes, and still are all there.
void test_laz_reads_equal_points(test_state* test)
{
    enum { EQUAL = 50000 };
    las_point* equal = calloc(EQUAL, sizeof(*equal));
    las_desc desc = {.points = equal, .count = EQUAL, .coding = LAZ_CHUNKED, .chunk_size = EQUAL};
    las_buffer file = las_write(&desc);
    CHECK(file.size < EQUAL / 32);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.laz", file.bytes, file.size, &result);
    CHECK(scene != NULL);
    CHECK_EQUAL(EQUAL, scene->point_sets[0].point_count);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(file.bytes);
    free(equal);
}

void test_laz_names_the_damaged_chunk(test_state* test)
{
    las_buffer file = write_small(8, LAZ_CHUNKED);
    uint64_t points_at = 0;
    memcpy(&points_at, file.bytes + 96, 4);
    size_t record = 38 + 2, at = (size_t)points_at + 8 + record;
    memset(file.bytes + at + 4, 0xFF, 4); // the size of the first layer
    test_log log = {0};
    stp_context* context = test_context(NULL, 2, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.laz", file.bytes, file.size, &result);
    CHECK(scene == NULL);
    CHECK(strstr(log.text, "a.laz: chunk 0 of 3, 50 points from byte ") != NULL);
    CHECK(strstr(log.text, "cannot be decoded") != NULL);
    stp_context_destroy(context);
    free(file.bytes);
}

// For the fuzz target: small files of every format.
void test_las_writes_seeds(test_state* test)
{
    const char* folder = getenv("STP_LAS_SEEDS");
    if (folder == NULL) {
        SKIP("STP_LAS_SEEDS names no folder");
    }
    for (unsigned format = 0; format <= 10; ++format) {
        for (int coding = LAS_RAW; coding <= LAZ_VARIABLE; ++coding) {
            if (coding == LAZ_SINGLE && format >= 6) {
                continue;
            }
            char path[512];
            snprintf(path, sizeof(path), "%s/format-%u-%d.las", folder, format, coding);
            las_buffer bytes = write_small(format, (las_coding)coding);
            FILE* file = fopen(path, "wb");
            CHECK(file != NULL);
            CHECK_EQUAL(bytes.size, fwrite(bytes.bytes, 1, bytes.size, file));
            CHECK_EQUAL(0, fclose(file));
            free(bytes.bytes);
        }
    }
}
