// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/rng.h"
#include "draw/support_store.h"
#include "select/support_built.h"
#include "store/outline/outline.h"
#include "store/support_reseal.h"
#include "store/support_sample.h"
#include "store/writer/writer.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MANY = 20000 };

typedef struct forest {
    stp_context* context;
    stp_store* store;
    stp_store_object* objects; ///< as written
    char (*names)[24];
    char path[64];
} forest;

/// Invisible objects, each below a random earlier one, or below the previous one (seed 0).
static bool plant(forest* f, uint32_t count, uint64_t seed)
{
    snprintf(f->path, sizeof(f->path), "stp_outline_XXXXXX");
    int file = mkstemp(f->path);
    f->context = test_context(NULL, 1, NULL);
    f->objects = calloc(count, sizeof(*f->objects));
    f->names = calloc(count, sizeof(*f->names));
    if (file < 0 || close(file) != 0 || f->context == NULL || f->objects == NULL ||
        f->names == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < count; ++i) {
        snprintf(f->names[i], sizeof(f->names[i]), "%s %u", i % 100 == 0 ? "T\xC3\x9CR" : "Pipe",
                 i % 1000);
        bool top = seed == 0 ? i == 0 : i < 3 || stp_rng_below(seed, 2 * i, 50) == 0;
        f->objects[i] = (stp_store_object){
            .name = i % 11 == 10 ? NULL : f->names[i],
            .id = i % 13 == 0 ? "2x3fGUID" : NULL,
            .parent = top         ? STP_STORE_NONE
                      : seed == 0 ? i - 1
                                  : stp_rng_below(seed, 2 * i + 1, i < 40 ? i : 40),
            .node = STP_STORE_NONE,
            .transform = stp_affine_identity()};
        f->objects[i].transform.m[0][3] = i % 7;
    }
    stp_store_content content = {.directory = {.object_count = count,
                                               .objects = f->objects,
                                               .root = STP_STORE_NONE,
                                               .up = 'y',
                                               .build_json = "{}"}};
    stp_store_open_desc desc = {.defer_objects = true};
    return stp_store_write(f->context, &content, f->path) == STP_OK &&
           stp_store_open_with(f->context, f->path, &desc, &f->store) == STP_OK;
}

static void fell(forest* f)
{
    stp_store_close(f->store);
    stp_context_destroy(f->context);
    free(f->objects);
    free(f->names);
    unlink(f->path);
}

void test_outline_lists_children_in_order(test_state* test)
{
    forest f;
    CHECK(plant(&f, MANY, 5));
    stp_outline* outline;
    bool ready = false;
    CHECK_EQUAL(STP_OK, stp_outline_create(f.context, f.store, &outline));
    uint32_t slices = 0;
    while (!ready) { // a slice per frame
        CHECK_EQUAL(STP_OK, stp_outline_prepare(outline, 1000, &ready));
        slices += 1;
    }
    CHECK(slices >= 3 * MANY / 1000 && slices < 3 * MANY / 1000 + 4);
    for (uint32_t parent = 0; parent < 60; ++parent) {
        stp_outline_item item, children[64];
        stp_outline_row row;
        uint32_t count, next = 0, seen = 0;
        if (parent == 59) {
            item = stp_outline_root(outline);
        } else {
            CHECK_EQUAL(STP_OK, stp_outline_item_of(outline, parent, &item));
        }
        uint32_t wanted = parent == 59 ? STP_STORE_NONE : parent;
        do {
            CHECK_EQUAL(STP_OK, stp_outline_children(outline, &item, seen, 64, children, &count));
            for (uint32_t i = 0; i < count; ++i, ++next) {
                while (next < MANY && f.objects[next].parent != wanted) {
                    next += 1;
                }
                CHECK_EQUAL(next, children[i].objects[children[i].depth - 1]);
                CHECK_EQUAL(item.depth + 1, children[i].depth);
                double x = item.transform.m[0][3] + next % 7;
                CHECK(children[i].transform.m[0][3] == x);
            }
            seen += count;
        } while (count == 64);
        while (next < MANY && f.objects[next].parent != wanted) {
            next += 1;
        }
        CHECK_EQUAL(MANY, next); // none was left out
        CHECK_EQUAL(STP_OK, stp_outline_describe(outline, &item, &row));
        CHECK_EQUAL(seen, row.child_count);
        const char* name = parent == 59 ? NULL : f.objects[parent].name;
        CHECK((row.name == NULL) == (name == NULL) && (name == NULL || !strcmp(name, row.name)));
    }
    stp_outline_destroy(outline);
    fell(&f);
}

void test_outline_survives_parents_that_change(test_state* test)
{
    enum { COUNT = 400, PARENT = 8 }; // PARENT: offset within the record of an object
    stp_store_object objects[COUNT] = {{.parent = STP_STORE_NONE, .node = STP_STORE_NONE}};
    for (uint32_t i = 0; i < COUNT; ++i) {
        objects[i] = (stp_store_object){.parent = i == 0 ? STP_STORE_NONE : 0,
                                        .node = STP_STORE_NONE,
                                        .transform = stp_affine_identity()};
    }
    stp_store_content content = {.directory = {.object_count = COUNT,
                                               .objects = objects,
                                               .root = STP_STORE_NONE,
                                               .up = 'y',
                                               .build_json = "{}"},
                                 .passing = true}; // not packed, so read from the mapping
    stp_context* context = test_context(NULL, 1, &(test_log){0});
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, stp_store_write(context, &content, "changing.stip"));
    size_t size = 0;
    unsigned char* bytes = sample_read_file("changing.stip", &size);
    stp_store* store = NULL;
    stp_outline* outline = NULL;
    bool ready = false;
    CHECK(bytes != NULL);
    stp_store_open_desc desc = {.defer_objects = true};
    CHECK_EQUAL(STP_OK, stp_store_open_memory(context, "m", bytes, size, &desc, &store));
    CHECK_EQUAL(STP_OK, stp_outline_create(context, store, &outline));
    CHECK_EQUAL(STP_OK, stp_outline_prepare(outline, COUNT, &ready)); // children are counted
    stp_store_section section = reseal_section(find_section(bytes, STP_SECTION_OBJECTS));
    CHECK(!stp_store_is_packed(&section));
    for (uint32_t i = 1; i < COUNT; ++i) {
        stp_write_u32(bytes + section.offset + i * section.record_size + PARENT, i - 1);
    }
    CHECK_EQUAL(STP_ERROR_FORMAT, stp_outline_prepare(outline, 0, &ready));
    CHECK(!ready);
    stp_outline_destroy(outline);
    stp_store_close(store);
    free(bytes);
    unlink("changing.stip");
    stp_context_destroy(context);
}

void test_outline_search_finds_parts_of_names_in_any_case(test_state* test)
{
    static const struct {
        const char* text;
        const char* sure; ///< text that names must contain, in their spelling
    } searches[] = {{"t\xC3\xBCr 9", "T\xC3\x9CR 9"}, {"PIPE 77", "Pipe 77"}, {"guid", NULL}};
    forest f;
    CHECK(plant(&f, MANY, 6));
    stp_outline* outline;
    CHECK_EQUAL(STP_OK, stp_outline_create(f.context, f.store, &outline));
    for (int s = 0; s < 3; ++s) {
        stp_outline_search search = stp_outline_search_begin(searches[s].text);
        uint32_t next = 0, found[7], count;
        while (search.next < MANY) { // few at a time, and little room
            uint32_t before = search.next;
            CHECK_EQUAL(STP_OK, stp_outline_search_on(outline, &search, 500, 7, found, &count));
            CHECK(search.next - before <= 500 &&
                  (count == 7 || search.next - before == 500 || search.next == MANY));
            for (uint32_t i = 0; i <= count; ++i) {
                uint32_t end = i < count ? found[i] : search.next;
                for (; next < end; ++next) {
                    const stp_store_object* o = &f.objects[next];
                    CHECK(searches[s].sure != NULL
                              ? o->name == NULL || strstr(o->name, searches[s].sure) == NULL
                              : o->id == NULL);
                }
                next += i < count ? 1 : 0;
            }
        }
        CHECK(search.matches > 15);
    }
    stp_outline_search empty = stp_outline_search_begin("");
    uint32_t found[1], count;
    CHECK_EQUAL(STP_OK, stp_outline_search_on(outline, &empty, MANY, 1, found, &count));
    CHECK(count == 0 && empty.next == MANY);
    stp_outline_destroy(outline);
    fell(&f);
}

void test_outline_paths_lead_back(test_state* test)
{
    forest f;
    CHECK(plant(&f, 300, 7));
    stp_outline* outline;
    bool ready, named;
    char path[512], cut[9];
    CHECK_EQUAL(STP_OK, stp_outline_create(f.context, f.store, &outline));
    CHECK_EQUAL(STP_OK, stp_outline_prepare(outline, 0, &ready));
    CHECK(ready);
    for (uint32_t i = 0; i < 300; ++i) {
        stp_outline_item item, back;
        bool found;
        CHECK_EQUAL(STP_OK, stp_outline_item_of(outline, i, &item));
        CHECK_EQUAL(STP_OK, stp_outline_path(outline, &item, path, sizeof(path)));
        CHECK_EQUAL(STP_OK, stp_outline_by_path(outline, path, NULL, &back, &found));
        CHECK(found); // names repeat, so it may be another with this path
        char again[512];
        CHECK_EQUAL(STP_OK, stp_outline_path(outline, &back, again, sizeof(again)));
        CHECK(strcmp(path, again) == 0);
        for (const char* end = path; end != NULL; end = strchr(end, '/')) {
            end += *end == '/' ? 1 : 0;
            CHECK_EQUAL(STP_OK, stp_outline_is_named(outline, i, end, &named));
            CHECK(named);
        }
        CHECK_EQUAL(STP_OK, stp_outline_is_named(outline, i, path + 1, &named));
        CHECK(!named || path[1] == 0);
        snprintf(path, sizeof(path), "#%u", i);
        CHECK_EQUAL(STP_OK, stp_outline_is_named(outline, i, path, &named));
        CHECK(named);
        CHECK_EQUAL(STP_OK, stp_outline_path(outline, &item, cut, sizeof(cut)));
        CHECK(strlen(cut) < sizeof(cut));
        CHECK_EQUAL(STP_OK, stp_outline_by_path(outline, "Pipe 1/nothing", NULL, &back, &found));
        CHECK(!found);
    }
    stp_outline_destroy(outline);
    fell(&f);
}

void test_outline_cuts_paths_between_characters(test_state* test)
{
    static const char* const cuts[] = {"", "T", "T", "T\xC3\x9C", "T\xC3\x9CR", "T\xC3\x9CR "};
    forest f;
    stp_outline* outline = NULL;
    stp_outline_item item;
    bool ready = false;
    CHECK(plant(&f, 2, 0));
    CHECK_EQUAL(STP_OK, stp_outline_create(f.context, f.store, &outline));
    CHECK_EQUAL(STP_OK, stp_outline_prepare(outline, 100, &ready));
    CHECK_EQUAL(STP_OK, stp_outline_item_of(outline, 0, &item));
    for (size_t i = 0; i < sizeof(cuts) / sizeof(cuts[0]); ++i) {
        char path[8] = "xxxxxxx";
        CHECK_EQUAL(STP_OK, stp_outline_path(outline, &item, path, i + 1));
        CHECK(strcmp(path, cuts[i]) == 0);
    }
    stp_outline_destroy(outline);
    fell(&f);
}

/// Walks the whole outline and counts its rows.
static bool walk(stp_outline* outline, const stp_store* store, const stp_outline_item* item,
                 uint32_t depth, uint32_t* rows)
{
    stp_outline_item* children = calloc(8, sizeof(*children));
    uint32_t count = 8;
    bool good = children != NULL && depth < 20;
    for (uint64_t first = 0; good && count == 8; first += 8) {
        good = stp_outline_children(outline, item, first, 8, children, &count) == STP_OK;
        for (uint32_t i = 0; good && i < count; ++i) {
            *rows += 1;
            good = *rows < 4000 && walk(outline, store, &children[i], depth + 1, rows);
        }
    }
    free(children);
    return good;
}

void test_outline_places_what_is_too_deep_for_an_item(test_state* test)
{
    enum { DEEP = 200 };
    forest f;
    CHECK(plant(&f, DEEP, 0));
    stp_outline* outline;
    stp_outline_item item, below;
    bool ready, named;
    uint32_t count;
    char path[4096];
    CHECK_EQUAL(STP_OK, stp_outline_create(f.context, f.store, &outline));
    CHECK_EQUAL(STP_OK, stp_outline_prepare(outline, 0, &ready));
    double x = 0.0;
    for (uint32_t i = 0; i < DEEP; ++i) {
        x += i % 7;
        CHECK_EQUAL(STP_OK, stp_outline_item_of(outline, i, &item));
        CHECK_EQUAL(i < STP_OUTLINE_DEPTH ? i + 1 : STP_OUTLINE_DEPTH, item.depth);
        CHECK_EQUAL(i, item.objects[item.depth - 1]);
        CHECK_EQUAL(i + 1 - item.depth, item.objects[0]);
        CHECK(item.transform.m[0][3] == x);
        CHECK_EQUAL(STP_OK, stp_outline_path(outline, &item, path, sizeof(path)));
        CHECK_EQUAL(i >= STP_OUTLINE_DEPTH, strncmp(path, ".../", 4) == 0);
    }
    CHECK_EQUAL(STP_OK, stp_outline_is_named(outline, DEEP - 1, "Pipe 198/Pipe 199", &named));
    CHECK(named);
    CHECK_EQUAL(STP_OK, stp_outline_children(outline, &item, 0, 1, &below, &count));
    CHECK_EQUAL(0, count);
    stp_outline_destroy(outline);
    fell(&f);
}

void test_outline_unfolds_prototypes_where_they_are_used(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    for (uint64_t seed = 40; seed < 44; ++seed) {
        stp_store* store = built_open(context, seed, false);
        CHECK(store != NULL);
        stp_outline* outline;
        bool ready;
        uint32_t rows = 0, below_prototypes = 0;
        CHECK_EQUAL(STP_OK, stp_outline_create(context, store, &outline));
        CHECK_EQUAL(STP_OK, stp_outline_prepare(outline, 0, &ready));
        stp_outline_item root = stp_outline_root(outline), item;
        CHECK(walk(outline, store, &root, 0, &rows));
        const stp_store_directory* d = stp_store_get_directory(store);
        CHECK(rows >= d->object_count - 4);
        for (uint32_t i = 0; i < d->object_count; ++i) {
            CHECK_EQUAL(STP_OK, stp_outline_item_of(outline, i, &item));
            bool nowhere = i < 4 && item.node == STP_STORE_NONE;
            below_prototypes += nowhere ? 1 : 0;
            CHECK(nowhere || i >= 4);
        }
        CHECK_EQUAL(4, below_prototypes);
        stp_outline_destroy(outline);
        stp_store_close(store);
    }
    stp_context_destroy(context);
}

/// A car of three wheels that all are uses of one object: two on an axle, and one beside.
static stp_store* open_car(stp_context* context)
{
    static const double uses[] = {10, 20, 100, 1, 1000}; // of nodes 0, 0, 1, 0, 2
    static const uint32_t used[] = {0, 0, 1, 0, 2};
    char path[] = "stp_outline_XXXXXX";
    stp_store_mesh mesh = made_square(0);
    stp_store_material material = made_material();
    stp_store_part part = {STP_STORE_PART_MESH, 0};
    stp_store_edge edges[5];
    stp_store_node nodes[4] = {{.part_count = 1, .triangle_count = 2},
                               {.edge_count = 2, .triangle_count = 4},
                               {.first_edge = 2, .edge_count = 2, .triangle_count = 6},
                               {.first_edge = 4, .edge_count = 1, .triangle_count = 6}};
    stp_store_object objects[] = {
        {.name = "wheel", .parent = STP_STORE_NONE, .node = 0},
        {.name = "car", .parent = STP_STORE_NONE, .node = 2, .transform = stp_affine_identity()}};
    objects[1].transform.m[0][3] = uses[4];
    for (int i = 0; i < 5; ++i) {
        edges[i] = (stp_store_edge){used[i], stp_affine_identity()};
        edges[i].transform.m[0][3] = uses[i];
    }
    for (int i = 0; i < 4; ++i) {
        nodes[i].set = STP_STORE_NONE;
        nodes[i].bounds = (stp_boxd){{-1, -1, 0}, {2000, 1, 0}};
    }
    const stp_store_content content = {.directory = {.object_count = 2,
                                                     .objects = objects,
                                                     .node_count = 4,
                                                     .nodes = nodes,
                                                     .edge_count = 5,
                                                     .edges = edges,
                                                     .part_count = 1,
                                                     .parts = &part,
                                                     .material_count = 1,
                                                     .materials = &material,
                                                     .mesh_count = 1,
                                                     .root = 3,
                                                     .up = 'y',
                                                     .build_json = "{}"},
                                       .meshes = &mesh};
    stp_store* store = NULL;
    int file = mkstemp(path);
    bool good = file >= 0 && close(file) == 0 && stp_store_write(context, &content, path) == STP_OK;
    good = good && stp_store_open(context, path, &store) == STP_OK;
    unlink(path);
    return good ? store : NULL;
}

// An object without objects of its own has what the nodes below it use.
void test_outline_lists_uses_below_an_object(test_state* test)
{
    static const double places[] = {1110, 1120, 1001};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_store* store = open_car(context);
    CHECK(store != NULL);
    stp_outline* outline;
    stp_outline_item root, car, wheels[4];
    stp_outline_row row;
    bool ready;
    uint32_t count;
    CHECK_EQUAL(STP_OK, stp_outline_create(context, store, &outline));
    CHECK_EQUAL(STP_OK, stp_outline_prepare(outline, 0, &ready));
    root = stp_outline_root(outline);
    CHECK_EQUAL(STP_OK, stp_outline_children(outline, &root, 0, 1, &car, &count));
    CHECK(count == 1 && car.objects[0] == 1);
    CHECK_EQUAL(STP_OK, stp_outline_describe(outline, &car, &row));
    CHECK_EQUAL(3, row.child_count);
    for (uint64_t first = 0; first < 4; ++first) {
        for (uint32_t room = 0; room <= 4; ++room) {
            uint32_t left = first < 3 ? 3 - (uint32_t)first : 0;
            CHECK_EQUAL(STP_OK, stp_outline_children(outline, &car, first, room, wheels, &count));
            CHECK_EQUAL(left < room ? left : room, count);
            for (uint32_t i = 0; i < count; ++i) {
                CHECK(wheels[i].depth == 2 && wheels[i].objects[1] == 0 && wheels[i].node == 0);
                CHECK(wheels[i].transform.m[0][3] == places[first + i]);
            }
        }
    }
    CHECK_EQUAL(STP_OK, stp_outline_children(outline, &car, 0, 1, wheels, &count));
    CHECK_EQUAL(STP_OK, stp_outline_describe(outline, &wheels[0], &row));
    CHECK(strcmp(row.name, "wheel") == 0 && row.child_count == 0 && row.triangle_count == 2);
    stp_outline_destroy(outline);
    stp_store_close(store);
    stp_context_destroy(context);
}

// Chains: also the last objects of a file have their children, with the index made in any steps.
void test_outline_lists_children_to_the_last_object(test_state* test)
{
    for (uint32_t length = 1; length < 6; ++length) {
        forest f;
        CHECK(plant(&f, length, 0));
        for (uint64_t step = 0; step < 4; ++step) {
            stp_outline* outline;
            bool ready = false;
            CHECK_EQUAL(STP_OK, stp_outline_create(f.context, f.store, &outline));
            while (!ready) {
                CHECK_EQUAL(STP_OK, stp_outline_prepare(outline, step, &ready));
            }
            stp_outline_item item = stp_outline_root(outline), children[2];
            for (uint32_t i = 0; i <= length; ++i) {
                uint32_t count;
                CHECK_EQUAL(STP_OK, stp_outline_children(outline, &item, 0, 2, children, &count));
                CHECK_EQUAL(i < length, count);
                CHECK(count == 0 || children[0].objects[children[0].depth - 1] == i);
                item = children[0];
            }
            stp_outline_destroy(outline);
        }
        fell(&f);
    }
}

void test_outline_refuses_damaged_records_and_survives_lack_of_memory(test_state* test)
{
    forest f;
    CHECK(plant(&f, 2000, 9));
    size_t size;
    FILE* file = fopen(f.path, "rb");
    CHECK(file != NULL && fseek(file, 0, SEEK_END) == 0);
    size = (size_t)ftell(file);
    rewind(file);
    unsigned char* bytes = aligned_alloc(64, (size + 63) / 64 * 64);
    CHECK(bytes != NULL && fread(bytes, 1, size, file) == size && fclose(file) == 0);
    stp_store_open_desc desc = {.defer_objects = true};
    uint32_t refused = 0;
    for (uint32_t i = 0; i < 60; ++i) { // one byte of the second half, where the objects are
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        size_t at = size / 2 + stp_rng_below(3, i, (uint32_t)(size / 2));
        bytes[at] ^= 0x40;
        stp_store* store = NULL;
        stp_outline* outline = NULL;
        bool ready = false;
        stp_result result = stp_store_open_memory(context, "m", bytes, size, &desc, &store);
        if (result == STP_OK) {
            CHECK_EQUAL(STP_OK, stp_outline_create(context, store, &outline));
            result = stp_outline_prepare(outline, 0, &ready);
            stp_outline_search search = stp_outline_search_begin("q");
            uint32_t found[4], count;
            result = result == STP_OK
                         ? stp_outline_search_on(outline, &search, 4000, 4, found, &count)
                         : result;
            stp_outline_destroy(outline);
            stp_store_close(store);
        }
        CHECK(result == STP_OK || (result == STP_ERROR_FORMAT && log.errors == 1));
        refused += result != STP_OK ? 1 : 0;
        stp_context_destroy(context);
        bytes[at] ^= 0x40;
    }
    CHECK(refused > 50);
    bool failed = true;
    for (int n = 0; failed; ++n) {
        test_heap heap = TEST_HEAP(-1);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_outline* outline = NULL;
        bool ready = false;
        heap.count = 0;
        heap.fail_at = n;
        stp_result result = stp_outline_create(context, f.store, &outline);
        result = result == STP_OK ? stp_outline_prepare(outline, 0, &ready) : result;
        failed = result != STP_OK;
        CHECK(!failed || result == STP_ERROR_OUT_OF_MEMORY);
        if (failed && outline != NULL) { // a retry starts again
            heap.fail_at = -1;
            CHECK_EQUAL(STP_OK, stp_outline_prepare(outline, 0, &ready));
            CHECK(ready);
        }
        stp_outline_destroy(outline);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    free(bytes);
    fell(&f);
}
