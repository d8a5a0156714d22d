// SPDX-License-Identifier: MIT
// Compares the object counts of the input with a walk over every use.
#include "tests.h"

#include "base/math/rng.h"
#include "builder/writer_input.h"
#include "scene/scene_helpers.h"

#include <stdio.h>
#include <string.h>

enum { OBJECTS = 14, MESHES = 4 };

typedef struct dice {
    uint64_t seed, next;
} dice;

static uint32_t below(dice* d, uint32_t bound)
{
    return stp_rng_below(d->seed, d->next++, bound);
}

// Objects with up to three parts (one mesh is empty), instances, uses of earlier objects, and
// prototypes.
static bool make_scene(stp_context* context, uint64_t seed, stp_scene** scene)
{
    dice d = {seed, 0};
    bool made = stp_scene_create(context, scene) == STP_OK;
    for (uint32_t i = 0; made && i < MESHES; ++i) {
        made = add_strip(*scene, i, (float)i, NULL); // the first has no triangles
    }
    uint32_t count = 1 + below(&d, OBJECTS);
    for (uint32_t i = 0; made && i < count; ++i) {
        uint32_t parent = i == 0 || below(&d, 3) == 0 ? STP_NONE : below(&d, i);
        uint32_t flags = below(&d, 4) == 0 ? STP_OBJECT_PROTOTYPE : 0;
        made = add_object(*scene, parent, make_translation(i, 0, 0), flags, NULL);
        for (uint32_t k = below(&d, 4); made && k > 1; --k) {
            stp_part part = {STP_PART_MESH, below(&d, MESHES)};
            made = stp_scene_add_part(*scene, part) == STP_OK;
        }
        for (uint32_t k = below(&d, 4); made && k > 1; --k) {
            stp_affine at = make_translation(0, k, 0);
            made = stp_scene_add_instance(*scene, &at) == STP_OK;
        }
        uint32_t used = i > 0 ? below(&d, i) : 0;
        // an object cannot use its own ancestors
        for (uint32_t up = parent; up != STP_NONE; up = (*scene)->objects[up].parent) {
            used = used <= up ? i : used;
        }
        if (made && used < i && below(&d, 3) == 0) {
            made = stp_scene_add_use(*scene, used) == STP_OK;
        }
    }
    return made;
}

typedef struct counted {
    uint64_t objects, instances;
    uint32_t lists[64][3]; ///< distinct lists of parts seen, as three indices + 1
    uint32_t list_count;
} counted;

static void count_own(const stp_scene* scene, const stp_object* object, counted* c)
{
    uint32_t list[3] = {0}, length = 0;
    for (uint32_t i = 0; i < object->part_count; ++i) {
        stp_part part = scene->parts[object->first_part + i];
        if (scene->meshes[part.index].triangle_count != 0) {
            list[length++] = part.index + 1;
        }
    }
    c->instances += length;
    c->objects += length != 0;
    uint32_t found = 0;
    while (found < c->list_count && memcmp(c->lists[found], list, sizeof(list)) != 0) {
        found += 1;
    }
    if (length != 0 && found == c->list_count && found < 64) {
        memcpy(c->lists[c->list_count++], list, sizeof(list));
    }
}

static void count_object(const stp_scene* scene, uint32_t index, counted* c)
{
    const stp_object* object = &scene->objects[index];
    uint32_t times = object->instance_count > 0 ? object->instance_count : 1;
    for (uint32_t i = 0; i < times; ++i) {
        count_own(scene, object, c);
        if (object->use != STP_NONE) {
            count_object(scene, object->use, c);
        }
    }
    for (uint32_t i = 0; i < scene->object_count; ++i) {
        bool prototype = (scene->objects[i].flags & STP_OBJECT_PROTOTYPE) != 0;
        if (scene->objects[i].parent == index && !prototype) {
            count_object(scene, i, c);
        }
    }
}

void test_census_counts_every_use(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    uint64_t maximum = 0, parts = 0, finished = 0;
    for (uint64_t seed = 0; seed < 400; ++seed) {
        stp_scene* scene = NULL;
        stp_store_census census;
        CHECK(make_scene(context, seed, &scene));
        if (stp_scene_finish(scene) != STP_OK) { // something contains itself
            stp_scene_destroy(scene);
            continue;
        }
        finished += 1;
        CHECK_EQUAL(STP_OK, stp_build_census(scene, &census));
        counted whole = {0};
        for (uint32_t i = 0; i < scene->object_count; ++i) {
            const stp_object* object = &scene->objects[i];
            if (object->parent == STP_NONE && (object->flags & STP_OBJECT_PROTOTYPE) == 0) {
                count_object(scene, i, &whole);
            }
        }
        CHECK_EQUAL(whole.objects, census.objects);
        CHECK_EQUAL(whole.instances, census.instances);
        CHECK_EQUAL(whole.list_count, census.unique_objects);
        uint64_t sum = 0;
        for (uint32_t i = 0; i < census.part_count; ++i) {
            const stp_store_census_part* part = &census.parts[i];
            counted one = {0};
            CHECK_EQUAL(1, part->member_count);
            count_object(scene, part->members[0], &one);
            CHECK_EQUAL(one.objects, part->objects);
            CHECK_EQUAL(one.instances, part->instances);
            CHECK_EQUAL(one.list_count, part->unique_objects);
            CHECK(one.objects > 0);
            sum += one.objects;
        }
        CHECK_EQUAL(whole.objects, sum);
        maximum = sum > maximum ? sum : maximum;
        parts += census.part_count > 1;
        stp_store_census_destroy(context, &census);
        stp_scene_destroy(scene);
    }
    CHECK(maximum > 20 && parts > 100 && finished > 200);
    stp_context_destroy(context);
}

// A plant: a root, a site below it, and there a hall of 500 uses of a motor of two objects, and a
// wall.
void test_census_finds_the_parts(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, other, motor, root, site, hall, index;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 900, 0.0f, &mesh) && add_strip(scene, 7, 0.0f, &other));
    CHECK(add_mesh_object(scene, STP_NONE, make_translation(0, 1, 0), mesh, &motor));
    scene->objects[motor].flags = STP_OBJECT_PROTOTYPE;
    CHECK(add_mesh_object(scene, motor, make_translation(0, 2, 0), other, &index));
    CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}));
    CHECK(add_object(scene, STP_NONE, stp_affine_identity(), 0, &root));
    CHECK(add_object(scene, root, stp_affine_identity(), 0, &site));
    CHECK(add_object(scene, root, stp_affine_identity(), 0, NULL)); // e.g. a lamp
    stp_object named = {.name = "hall", .parent = site, .transform = stp_affine_identity()};
    CHECK_EQUAL(STP_OK, stp_scene_add_object(scene, &named, &hall));
    for (int i = 0; i < 500; ++i) {
        CHECK(add_object(scene, hall, make_translation(10 * i, 0, 0), 0, &index));
        CHECK_EQUAL(STP_OK, stp_scene_add_use(scene, motor));
    }
    named.name = "wall";
    CHECK_EQUAL(STP_OK, stp_scene_add_object(scene, &named, NULL));
    CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_MESH, other}));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    stp_store_census census;
    CHECK_EQUAL(STP_OK, stp_build_census(scene, &census));
    CHECK_EQUAL(2, census.part_count);
    CHECK(strcmp(census.parts[0].name, "hall") == 0 && strcmp(census.parts[1].name, "wall") == 0);
    CHECK_EQUAL(1000, census.parts[0].objects);
    CHECK_EQUAL(2, census.parts[0].unique_objects);
    CHECK_EQUAL(1500, census.parts[0].instances);
    CHECK_EQUAL(1, census.parts[1].objects);
    CHECK_EQUAL(1001, census.objects);
    CHECK_EQUAL(3, census.unique_objects);
    stp_store_census_destroy(context, &census);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// 40 objects, each with two uses of the previous one below it: more uses than a walk can visit.
void test_census_counts_what_cannot_be_walked(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, used, index;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 3, 0.0f, &mesh));
    CHECK(add_mesh_object(scene, STP_NONE, stp_affine_identity(), mesh, &used));
    scene->objects[used].flags = STP_OBJECT_PROTOTYPE;
    for (int i = 0; i < 70; ++i) {
        uint32_t flags = i < 69 ? STP_OBJECT_PROTOTYPE : 0;
        CHECK(add_object(scene, STP_NONE, stp_affine_identity(), flags, &index));
        for (int k = 0; k < 2; ++k) {
            CHECK(add_object(scene, index, make_translation(k, i, 0), 0, NULL));
            CHECK_EQUAL(STP_OK, stp_scene_add_use(scene, used));
        }
        used = index;
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    stp_store_census census;
    CHECK_EQUAL(STP_OK, stp_build_census(scene, &census));
    CHECK_EQUAL(UINT64_MAX, census.objects); // 2^70
    CHECK_EQUAL(1, census.unique_objects);
    CHECK_EQUAL(2, census.part_count);
    stp_store_census_destroy(context, &census);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_census_survives_failing_allocator(test_state* test)
{
    bool done = false;
    int failures = 0;
    for (int n = 0; !done && n < 2000; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        stp_scene* scene = NULL;
        stp_store_census census = {0};
        if (context != NULL && make_scene(context, 5, &scene) &&
            stp_scene_finish(scene) == STP_OK) {
            stp_result result = stp_build_census(scene, &census);
            CHECK_EQUAL(result != STP_OK, log.errors);
            failures += result != STP_OK;
            done = result == STP_OK;
            stp_store_census_destroy(context, &census);
        }
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(done && failures >= 8);
}
