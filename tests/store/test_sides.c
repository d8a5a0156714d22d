// SPDX-License-Identifier: MIT
// Sides of materials and shadings: written if any has only a front, read back, refused if invalid.
#include "tests.h"

#include "draw/support_store.h"
#include "store/file/sides.h"
#include "store/file/store_state.h"
#include "store/file/tables.h"

static void make_scene(made_scene* scene)
{
    *scene = (made_scene){
        .material_count = 2, .shading_count = 2, .mesh_count = 2, .part_count = 2, .node_count = 1};
    for (uint32_t i = 0; i < 2; ++i) {
        scene->materials[i] = made_material();
        scene->shadings[i] = (stp_shading){.roughness = 1};
        scene->meshes[i] = made_square(i);
        scene->parts[i] = (stp_store_part){STP_STORE_PART_MESH, i};
    }
    scene->nodes[0] = (stp_store_node){.part_count = 2,
                                       .set = STP_STORE_NONE,
                                       .triangle_count = 4,
                                       .bounds = {{-1, -1, 0}, {1, 1, 0}}};
}

void test_sides_are_read_as_written(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    static made_scene scene;
    make_scene(&scene);
    stp_store* store = made_open(context, &scene); // nothing to tell: no section
    CHECK(store != NULL && store->known[STP_SECTION_SIDES] == NULL);
    CHECK_EQUAL(0, stp_store_get_side_figures(store).triangles);
    stp_store_close(store);
    scene.materials[1].flags = STP_SHADING_FRONT_ONLY | STP_SHADING_UNLIT;
    scene.materials[1].inverted = 3;
    scene.shadings[0].flags = STP_SHADING_FRONT_ONLY;
    store = made_open(context, &scene);
    CHECK(store != NULL && store->known[STP_SECTION_SIDES] != NULL);
    CHECK((store->known[STP_SECTION_SIDES]->flags & STP_SECTION_CRITICAL) == 0); // may be skipped
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(0, d->materials[0].flags & STP_SHADING_FRONT_ONLY);
    CHECK_EQUAL(STP_SHADING_FRONT_ONLY | STP_SHADING_UNLIT, d->materials[1].flags);
    CHECK_EQUAL(3, d->materials[1].inverted);
    CHECK_EQUAL(STP_SHADING_FRONT_ONLY, d->shadings[0].flags);
    CHECK_EQUAL(0, d->shadings[1].flags);
    stp_store_side_figures figures = stp_store_get_side_figures(store);
    CHECK(figures.materials == 1 && figures.triangles == 2 && figures.inverted == 3);
    stp_store_close(store);
    stp_context_destroy(context);
}

void test_invalid_sides_are_refused(test_state* test)
{
    for (int way = 0; way < 2; ++way) {
        test_log log = {.errors = 0};
        stp_context* context = test_context(NULL, 1, &log);
        static made_scene scene;
        make_scene(&scene);
        scene.materials[0].flags = STP_SHADING_FRONT_ONLY;
        stp_store* store = made_open(context, &scene);
        CHECK(store != NULL);
        stp_store_sides* records = store->tables[STP_SECTION_SIDES];
        CHECK_EQUAL(4, store->counts[STP_SECTION_SIDES]);
        records[3].flags = way == 0 ? 2 : 0;
        store->counts[STP_SECTION_SIDES] = way == 1 ? 3 : 4;
        CHECK_EQUAL(STP_ERROR_FORMAT, stp_store_link_sides(store));
        CHECK_EQUAL(1, log.errors);
        stp_store_close(store);
        stp_context_destroy(context);
    }
}
