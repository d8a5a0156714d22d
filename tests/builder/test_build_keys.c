// SPDX-License-Identifier: MIT
// Keys contain everything that determines a result; a previous output is used only if it is intact.
#include "tests.h"

#include "builder/build_scene.h"

#include <string.h>
#include <unistd.h>

typedef struct place {
    char folder[64];
    char model[128], output[128];
} place;

static bool open_place(place* p)
{
    enum { SIZE = 26 };
    snprintf(p->folder, sizeof(p->folder), "stp_keys_XXXXXX");
    if (mkdtemp(p->folder) == NULL) {
        return false;
    }
    snprintf(p->model, sizeof(p->model), "%s/sheet.obj", p->folder);
    snprintf(p->output, sizeof(p->output), "%s/out.stip", p->folder);
    FILE* file = fopen(p->model, "w");
    if (file == NULL) {
        return false;
    }
    for (int i = 0; i < (SIZE + 1) * (SIZE + 1); ++i) {
        int x = i % (SIZE + 1), y = i / (SIZE + 1);
        fprintf(file, "v %d %d %d\n", x, (x * 7 + y * 13) % 3, y);
    }
    for (int i = 0; i < SIZE * SIZE; ++i) {
        int a = i / SIZE * (SIZE + 1) + i % SIZE + 1, c = a + SIZE + 1;
        fprintf(file, "f %d %d %d\nf %d %d %d\n", a, c, a + 1, a + 1, c, c + 1);
    }
    return fclose(file) == 0;
}

static bool close_place(const place* p)
{
    unlink(p->model);
    unlink(p->output);
    return rmdir(p->folder) == 0; // fails if files were left behind
}

static stp_build_desc describe(const place* p, const char* const* inputs)
{
    return (stp_build_desc){.inputs = inputs,
                            .input_count = 1,
                            .output = p->output,
                            .no_levels = true,
                            .blue = {.capture = {.wanted_candidates = 2000}},
                            .splat_rule = {1e-9, 150},
                            .parameters_json = "{\"method\":\"blue\"}"};
}

void test_builds_never_take_over_what_other_options_gave(test_state* test)
{
    place p;
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL && open_place(&p));
    const char* inputs[] = {p.model};
    const stp_build_desc plain = describe(&p, inputs);
    stp_build_desc others[] = {plain, plain, plain, plain, plain, plain, plain, plain, plain};
    others[0].splat_rule.maximum = 151;
    others[1].blue.order.metric = STP_METRIC_EUCLIDEAN;
    others[2].blue.order.kind = STP_ORDER_RANDOM;
    others[3].blue.order.seed = 9;
    others[4].blue.capture.direction_count = 14;
    others[5].blue.capture.resolution = 77;
    others[6].blue.capture.wanted_candidates = 2500;
    others[7].blue.capture.no_fill = true;
    others[8].from_triangles = true;
    if (plain.blue.order.metric == others[1].blue.order.metric) {
        others[1].blue.order.metric = STP_METRIC_SIDE;
    }
    if (plain.blue.order.kind == others[2].blue.order.kind) {
        others[2].blue.order.kind = STP_ORDER_EXACT;
    }
    stp_build_report report;
    for (size_t i = 0; i < sizeof(others) / sizeof(others[0]); ++i) {
        CHECK_EQUAL(STP_OK, stp_build(context, &plain, &report));
        CHECK_EQUAL(STP_OK, stp_build(context, &plain, &report));
        CHECK(report.sets_found == 1 && report.sets_made == 0 && report.meshes_found == 1);
        CHECK_EQUAL(STP_OK, stp_build(context, &others[i], &report));
        CHECK(report.sets_found == 0 && report.sets_made == 1); // the triangles are unchanged
        CHECK(report.meshes_found == 1 && report.meshes_made == 0);
    }
    stp_build_desc fresh = plain;
    fresh.fresh = true;
    CHECK_EQUAL(STP_OK, stp_build(context, &plain, NULL));
    CHECK_EQUAL(STP_OK, stp_build(context, &fresh, &report));
    CHECK(report.sets_found == 0 && report.meshes_found == 0);
    stp_context_destroy(context);
    CHECK(close_place(&p));
}

static bool write_bytes(const char* path, const unsigned char* bytes, size_t size)
{
    FILE* file = fopen(path, "wb");
    bool written = file != NULL && fwrite(bytes, 1, size, file) == size;
    return file != NULL && fclose(file) == 0 && written;
}

static bool holds(stp_context* context, const char* path, const unsigned char* bytes, size_t size)
{
    stp_mapped_file file;
    if (stp_file_map(context, path, &file) != STP_OK) {
        return false;
    }
    bool same = file.size == size && memcmp(file.bytes, bytes, size) == 0;
    stp_file_unmap(&file);
    return same;
}

// The new output does not depend on a damaged previous one.
void test_damaged_former_outputs_do_no_harm(test_state* test)
{
    place p;
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL && open_place(&p));
    const char* inputs[] = {p.model};
    const stp_build_desc desc = describe(&p, inputs);
    CHECK_EQUAL(STP_OK, stp_build(context, &desc, NULL));
    stp_mapped_file file;
    CHECK_EQUAL(STP_OK, stp_file_map(context, p.output, &file));
    size_t size = file.size;
    unsigned char* good = stp_alloc(context, size);
    unsigned char* damaged = stp_alloc(context, size);
    CHECK(good != NULL && damaged != NULL);
    memcpy(good, file.bytes, size);
    stp_file_unmap(&file);
    uint32_t used = 0, unused = 0;
    for (size_t at = 0; at < size; at += 1 + (at >= 64 ? size / 61 : 0)) {
        memcpy(damaged, good, size);
        damaged[at] ^= 0x21; // in the first bytes: another format or version
        stp_build_report report;
        CHECK(write_bytes(p.output, damaged, at % 5 == 4 ? at : size)); // some are truncated there
        CHECK_EQUAL(STP_OK, stp_build(context, &desc, &report));
        CHECK_EQUAL(0, log.errors);
        CHECK(holds(context, p.output, good, size));
        used += report.sets_found;
        unused += report.sets_made;
    }
    CHECK(used > 0 && unused >= 32);
    stp_free(context, good);
    stp_free(context, damaged);
    stp_context_destroy(context);
    CHECK(close_place(&p));
}
