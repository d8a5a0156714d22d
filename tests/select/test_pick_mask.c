// SPDX-License-Identifier: MIT
// Rays pass through areas removed by alpha: a pick hits what the picture shows in that pixel.
#include "draw/support_picture.h"
#include "select/pick_ray.h"
#include "store/support_mesh.h"

#include <string.h>

enum { TEXELS = 8 };

static uint8_t texels[4 * TEXELS * TEXELS];
static stp_coded_mesh coded[2];
static const float texcoords[] = {0, 0, 1, 0, 0, 1, 1, 1};

/// A red square with chequered alpha in front of a green one.
static bool make_scene(made_picture* p, stp_store_alpha alpha, bool clustered)
{
    if (!made_picture_begin(p, NULL, 1)) {
        return false;
    }
    for (size_t i = 0; i < TEXELS * TEXELS; ++i) {
        const uint8_t texel[4] = {255, 0, 0, (i % TEXELS / 2 + i / TEXELS / 2) % 2 == 0 ? 255 : 0};
        memcpy(texels + 4 * i, texel, sizeof(texel));
    }
    made_scene* s = &p->scene;
    made_picture_add(p, 0.3, (stp_vec3d){0, 0, 0.5}, NULL);
    made_picture_add(p, 0.0, (stp_vec3d){0.2, 0.1, -1.5}, NULL);
    s->texture_count = 1;
    s->textures[0] = (stp_store_texture){
        .width = TEXELS, .height = TEXELS, .wrap_u = 1, .wrap_v = 2, .texels = texels};
    s->materials[1] = made_material();
    s->materials[1].flags = s->materials[0].flags;
    s->material_count = 2;
    s->materials[0].alpha = alpha;
    s->materials[0].base_color_texture.texture = 0;
    s->materials[0].base_color_texture.transform[0][2] = 0.3f;
    s->materials[1].base_color[0] = s->materials[1].base_color[2] = 0;
    s->meshes[0].texcoords[0] = texcoords;
    s->meshes[1].material = 1;
    for (int i = 0; i < 2 && clustered; ++i) {
        if (stp_clusters_encode(p->context, &s->meshes[i], 1.0 / 1024, &coded[i]) != STP_OK) {
            return false;
        }
        s->meshes[i].bounds = coded[i].bounds;
        s->coded_meshes = coded;
    }
    return made_picture_open(p) == STP_OK;
}

/// 0: nothing, 1: the red one, 2: the green one
static int shown(const made_picture* p, int x, int y)
{
    const uint8_t* pixel = made_picture_pixel(p, x, y);
    return pixel[3] == 0 ? 0 : pixel[0] > pixel[1] ? 1 : 2;
}

/// The picked part in every pixel of a picture of the originals.
static void pick_all(test_state* test, made_picture* p)
{
    p->quality.reference = true;
    CHECK_EQUAL(STP_OK, made_picture_draw(p));
    int counts[3] = {0}, different = 0;
    for (int y = 0; y < PICTURE_SIDE; ++y) {
        for (int x = 0; x < PICTURE_SIDE; ++x) {
            stp_pick_desc desc = {0};
            stp_pick pick;
            CHECK(stp_ray_of_pixel(&p->view, x + 0.5, y + 0.5, &desc.ray));
            CHECK_EQUAL(STP_OK, stp_pick_ray(p->context, p->store, &desc, &pick));
            int met = pick.hit ? 1 + (int)pick.part.index : 0;
            counts[met] += 1;
            different += met != shown(p, x, y) ? 1 : 0;
        }
    }
    CHECK(counts[0] > 1000 && counts[1] > 200 && counts[2] > 200);
    CHECK(different <= 12); // at edges
}

void test_picks_go_through_what_alpha_leaves_out(test_state* test)
{
    for (int clustered = 0; clustered < 2; ++clustered) {
        made_picture p;
        memset(coded, 0, sizeof(coded));
        CHECK(make_scene(&p, STP_STORE_MASK, clustered == 1));
        CHECK_EQUAL(clustered == 1, stp_store_is_clustered(p.store, 0));
        pick_all(test, &p);
        for (int i = 0; i < 2; ++i) {
            stp_coded_mesh_destroy(p.context, &coded[i]);
        }
        made_picture_end(&p);
    }
}

void test_picks_meet_what_is_not_wholly_transparent(test_state* test)
{
    for (int i = 0; i < 2; ++i) {
        made_picture p;
        CHECK(make_scene(&p, i == 0 ? STP_STORE_BLEND : STP_STORE_OPAQUE, false));
        int red = 0, green = 0;
        for (int y = 20; y < 44; ++y) {
            for (int x = 20; x < 44; ++x) {
                stp_pick_desc desc = {0};
                stp_pick pick;
                CHECK(stp_ray_of_pixel(&p.view, x + 0.5, y + 0.5, &desc.ray));
                CHECK_EQUAL(STP_OK, stp_pick_ray(p.context, p.store, &desc, &pick));
                red += pick.hit && pick.part.index == 0 ? 1 : 0;
                green += pick.hit && pick.part.index == 1 ? 1 : 0;
            }
        }
        CHECK(red > 300 && (i == 0 ? green > 60 : green == 0));
        made_picture_end(&p);
    }
}
