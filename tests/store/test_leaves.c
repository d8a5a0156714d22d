// SPDX-License-Identifier: MIT
// Leaves of sets in a file (src/store/sets/leaves.c): round trip with and without a residency; invalid
// ones are rejected.
#include "support_reader.h"
#include "support_sample.h"
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/leaf_runs.h"
#include "lod/set_columns.h"
#include "lod/stochastic/set.h"
#include "store/file/content.h"
#include "store/file/store_state.h"
#include "store/residency/residency.h"
#include "store/writer/writer.h"

#include <string.h>
#include <unistd.h>

enum { POINTS = 4000 };

typedef struct fixture {
    stp_context* context;
    stp_splats set;
    stp_store_node node;
    stp_store_method method;
    stp_shading shading;
    stp_store_content content;
    unsigned char* bytes;
    size_t size;
} fixture;

static bool make_set(fixture* f)
{
    static float positions[3 * POINTS], normals[3 * POINTS];
    static uint8_t colors[4 * POINTS];
    static uint32_t materials[POINTS];
    static const uint8_t shadings[1] = {0};
    for (uint64_t i = 0; i < 3 * POINTS; ++i) {
        double v = (double)(stp_rng_hash(4, i) >> 11) * 0x1p-53;
        positions[i] = (float)(i % 3 == 1 ? 0.01 * v : v);
        normals[i] = i % 3 == 1 ? 1.0f : 0.0f;
    }
    stp_candidates candidates = {.count = POINTS,
                                 .positions = positions,
                                 .normals = normals,
                                 .colors = colors,
                                 .materials = materials};
    const stp_leaf_desc desc = {.budget = 100, .minimum = 20, .flatness = 0.005f, .sample = 100};
    const stp_stochastic_source source = {.candidates = &candidates,
                                          .shading_of_material = shadings,
                                          .wanted = POINTS,
                                          .has_normals = true};
    return stp_stochastic_make_set(f->context, &source, &desc, &f->set) == STP_OK;
}

static bool set_up(fixture* f, test_log* log)
{
    *f = (fixture){.context = test_context(NULL, 1, log)};
    if (f->context == NULL || !make_set(f)) {
        return false;
    }
    f->node = (stp_store_node){.point_count = POINTS, .bounds = {{0, 0, 0}, {1, 1, 1}}};
    f->method = (stp_store_method){.name = "stochastic",
                                   .id = STP_METHOD_STOCHASTIC,
                                   .columns = STP_STOCHASTIC_COLUMNS,
                                   .set_count = 1};
    f->content = (stp_store_content){.directory = {.node_count = 1,
                                                   .shading_count = 1,
                                                   .set_count = 1,
                                                   .method_count = 1,
                                                   .nodes = &f->node,
                                                   .shadings = &f->shading,
                                                   .methods = &f->method,
                                                   .up = 'y'},
                                     .sets = &f->set};
    return true;
}

static stp_result write_file(fixture* f)
{
    char path[256];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stp_leaves_%ld.stip", folder != NULL ? folder : "/tmp",
             (long)getpid());
    free(f->bytes);
    f->bytes = NULL;
    stp_result result = stp_store_write(f->context, &f->content, path);
    if (result == STP_OK) {
        f->bytes = sample_read_file(path, &f->size);
    }
    unlink(path);
    return result;
}

static stp_store* open_file(fixture* f, uint64_t prefix)
{
    stp_store* store = NULL;
    const stp_store_open_desc desc = {.accept_partial = prefix != 0, .partial_bytes = prefix};
    return stp_store_open_memory(f->context, "leaves", f->bytes, f->size, &desc, &store) == STP_OK
               ? store
               : NULL;
}

static void tear_down(fixture* f)
{
    free(f->bytes);
    stp_splats_destroy(f->context, &f->set);
    stp_context_destroy(f->context);
}

/// Block of the file's leaves.
static stp_store_block* find_block(const stp_store* store)
{
    stp_store_block* blocks = store->tables[STP_SECTION_BLOCKS];
    for (uint32_t i = 0; i < store->counts[STP_SECTION_BLOCKS]; ++i) {
        if (blocks[i].kind == STP_BLOCK_LEAVES) {
            return &blocks[i];
        }
    }
    return NULL;
}

void test_leaves_come_back(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, NULL));
    CHECK_EQUAL(STP_OK, write_file(&f));
    stp_store* store = open_file(&f, 0);
    CHECK(store != NULL && stp_store_leaf_count(store, 0) == f.set.leaf_count);
    CHECK((store->known[STP_SECTION_LEAVES]->flags & STP_SECTION_CRITICAL) == 0);
    stp_store_leaves leaves;
    CHECK_EQUAL(STP_OK, stp_store_get_leaves(store, 0, &leaves));
    CHECK_EQUAL(f.set.leaf_count, leaves.leaf_count);
    CHECK(memcmp(leaves.leaves, f.set.leaves, sizeof(*f.set.leaves) * f.set.leaf_count) == 0);
    CHECK(leaves.node_count >= leaves.leaf_count && leaves.nodes[0].count == POINTS);
    stp_store_check_report report;
    CHECK_EQUAL(STP_OK, stp_store_check_open(store, false, &report));
    uint64_t begin = find_block(store)->offset;
    stp_store_close(store);
    store = open_file(&f, begin + 1); // it ends within the leaves
    CHECK(store != NULL);
    CHECK_EQUAL(STP_OK, stp_store_get_leaves(store, 0, &leaves));
    CHECK_EQUAL(0, leaves.leaf_count);
    CHECK(stp_store_resident_splats(store, 0) > 0); // but it has some splats
    stp_store_close(store);
    tear_down(&f);
}

void test_leaves_come_with_a_residency(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, NULL));
    CHECK_EQUAL(STP_OK, write_file(&f));
    stp_store* store = open_file(&f, 0);
    CHECK(store != NULL);
    stp_residency* residency;
    const stp_residency_desc desc = {.thread_count = 1};
    CHECK_EQUAL(STP_OK, stp_residency_create(store, &desc, &residency));
    stp_store_leaves leaves;
    CHECK_EQUAL(STP_OK, stp_store_get_leaves(store, 0, &leaves));
    CHECK_EQUAL(0, leaves.leaf_count); // not requested
    const stp_data_request want = {.kind = STP_RESIDENT_LEAVES, .index = 0, .need = 2.0f};
    do {
        stp_residency_update(residency, &want, 1);
    } while (stp_residency_wait(residency));
    CHECK_EQUAL(STP_OK, stp_store_get_leaves(store, 0, &leaves));
    CHECK_EQUAL(f.set.leaf_count, leaves.leaf_count);
    CHECK(memcmp(leaves.leaves, f.set.leaves, sizeof(*f.set.leaves) * f.set.leaf_count) == 0);
    stp_residency_destroy(residency);
    CHECK_EQUAL(STP_OK, stp_store_get_leaves(store, 0, &leaves)); // from the file again
    CHECK_EQUAL(f.set.leaf_count, leaves.leaf_count);
    stp_store_close(store);
    tear_down(&f);
}

/// Each way makes the leaves invalid differently.
static bool break_leaves(stp_splats* set, int way)
{
    stp_splat_leaf* leaf = &set->leaves[set->leaf_count / 2];
    switch (way) {
    case 0:
        leaf->count += 1;
        return true;
    case 1:
        leaf->count = 0;
        return true;
    case 2:
        leaf->corner[1] += 1;
        return true;
    case 3:
        leaf->place |= 128;
        return true;
    case 4:
        leaf->place = (uint8_t)((leaf->place & ~STP_LEAF_DEPTH) | 17);
        return true;
    case 5:
        leaf->extent = 0;
        return true;
    case 6: {
        stp_splat_leaf kept = leaf[0];
        leaf[0] = leaf[1];
        leaf[1] = kept;
        return true;
    }
    case 7:
        memcpy(leaf->corner, leaf[1].corner, sizeof(leaf->corner));
        return true;
    case 8:
        set->octave_ends[0] += 1;
        return true;
    default:
        return false;
    }
}

void test_leaves_that_make_no_sense_are_refused(test_state* test)
{
    for (int way = 0; way < 9; ++way) {
        fixture f;
        test_log log = {.errors = 0};
        CHECK(set_up(&f, &log));
        CHECK(stp_splat_leaves_fault(&f.set, f.set.leaves, f.set.leaf_count) == NULL);
        CHECK_EQUAL(STP_OK, write_file(&f));
        stp_splats before = f.set;
        CHECK(break_leaves(&f.set, way));
        CHECK(stp_splat_leaves_fault(&f.set, f.set.leaves, f.set.leaf_count) != NULL);
        stp_store* store = open_file(&f, 0);
        CHECK(store != NULL);
        stp_store_block* block = find_block(store);
        memcpy(f.bytes + block->offset, f.set.leaves, (size_t)block->size);
        stp_store_leaves leaves;
        if (way != 8) { // wrong checksum first; then resealed, so the leaves are checked
            CHECK_EQUAL(STP_ERROR_FORMAT, stp_store_get_leaves(store, 0, &leaves));
            block->crc = stp_store_crc(0, f.bytes + block->offset, (size_t)block->size);
            CHECK_EQUAL(STP_ERROR_FORMAT, stp_store_get_leaves(store, 0, &leaves));
            CHECK_EQUAL(0, leaves.leaf_count);
        }
        stp_store_close(store);
        CHECK_EQUAL(STP_ERROR_ARGUMENT, write_file(&f));
        CHECK(strstr(log.text, "splat set 0") != NULL);
        f.set.octave_ends[0] = before.octave_ends[0];
        tear_down(&f);
    }
}
