// SPDX-License-Identifier: MIT
#include "support_picture.h"

#include "base/math/color.h"
#include "base/splats/coverage.h"

#include <assert.h>
#include <math.h>
#include <string.h>

bool made_picture_begin(made_picture* p, test_heap* heap, uint32_t threads)
{
    *p = (made_picture){.context = test_context(heap, threads, NULL)};
    p->scene.material_count = p->scene.shading_count = 1;
    p->scene.materials[0] = made_material();
    p->scene.materials[0].flags = STP_SHADING_UNLIT;
    p->scene.shadings[0] = (stp_shading){.roughness = 1, .flags = STP_SHADING_UNLIT};
    p->view = (stp_view){.eye = {0, 0, 5},
                         .up = {0, 1, 0},
                         .fov_degrees = 2.0 * 21.8014094863518,
                         .width = PICTURE_SIDE,
                         .height = PICTURE_SIDE};
    p->image = (stp_image){PICTURE_SIDE, PICTURE_SIDE, p->pixels};
    p->quality.early_switch =
        1; // there are few triangles per splat: splats are drawn as long as they cover
    return p->context != NULL;
}

void made_picture_add(made_picture* p, double angle, stp_vec3d move, const uint8_t* color)
{
    made_scene* s = &p->scene;
    uint32_t at = s->node_count;
    assert(at + 1 < MADE_LIMIT && at == s->mesh_count && "one node is left for the root");
    s->meshes[s->mesh_count++] = made_square(0);
    s->parts[s->part_count++] = (stp_store_part){STP_STORE_PART_MESH, at};
    s->nodes[s->node_count++] = (stp_store_node){.first_part = at,
                                                 .part_count = 1,
                                                 .set = STP_STORE_NONE,
                                                 .triangle_count = 2,
                                                 .bounds = {{-1, -1, 0}, {1, 1, 0}}};
    if (color != NULL) {
        s->nodes[at].set = s->set_count;
        s->sets[s->set_count++] = made_square_set(p->context, 5, color);
    }
    stp_affine m = stp_affine_identity();
    m.m[1][1] = m.m[2][2] = cos(angle);
    m.m[1][2] = -sin(angle);
    m.m[2][1] = sin(angle);
    m.m[0][3] = move.x;
    m.m[1][3] = move.y;
    m.m[2][3] = move.z;
    s->edges[s->edge_count++] = (stp_store_edge){at, m};
}

void made_picture_add_material(made_picture* p, uint32_t index, const float color[4])
{
    made_scene* s = &p->scene;
    s->materials[index] = s->materials[0];
    memcpy(s->materials[index].base_color, color, 4 * sizeof(float));
    s->materials[index].alpha = color[3] < 1.0f ? STP_STORE_BLEND : STP_STORE_OPAQUE;
    s->shadings[index] = s->shadings[0];
    s->shadings[index].flags |= color[3] < 1.0f ? STP_SHADING_TRANSPARENT : 0u;
    s->material_count = s->shading_count = index + 1;
}

void made_picture_add_sheet(made_picture* p, uint32_t material, double angle, stp_vec3d move,
                            bool splats)
{
    made_scene* s = &p->scene;
    const float* base = s->materials[material].base_color;
    uint8_t color[3];
    for (int k = 0; k < 3; ++k) {
        color[k] = stp_linear_to_srgb8(base[k]);
    }
    made_picture_add(p, angle, move, splats ? color : NULL);
    s->meshes[s->mesh_count - 1].material = material;
    if (splats) {
        const stp_splats* set = &s->sets[s->set_count - 1];
        float chance = 1.0f - sqrtf(1.0f - base[3]); // as src/lod/blue/pyramid_chance.c writes it
        memset(set->coverages, stp_coverage_of_share((double)chance), set->count);
        memset(set->materials, (int)material, set->count);
    }
}

stp_result made_picture_open(made_picture* p)
{
    made_scene* s = &p->scene;
    s->nodes[s->node_count] = (stp_store_node){.edge_count = s->edge_count,
                                               .set = STP_STORE_NONE,
                                               .triangle_count = 2 * s->node_count,
                                               .bounds = {{-9, -9, -9}, {9, 9, 3}}};
    s->node_count += 1;
    p->store = made_open(p->context, s);
    if (p->store == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    return stp_draw_cpu_create(p->context, p->store, &p->renderer);
}

stp_result made_picture_draw(made_picture* p)
{
    return stp_renderer_draw_selected(p->renderer, &p->view, &p->quality, &p->style, &p->list,
                                      &p->image, &p->stats);
}

stp_result made_picture_accumulate(made_picture* p)
{
    return stp_renderer_accumulate(p->renderer, &p->view, &p->quality, &p->style, &p->list,
                                   &p->image, &p->stats);
}

void made_picture_end(made_picture* p)
{
    for (uint32_t i = 0; i < p->scene.set_count; ++i) {
        made_free_set(p->context, &p->scene.sets[i]);
    }
    stp_renderer_destroy(p->renderer);
    stp_draw_list_destroy(p->context, &p->list);
    if (p->store != NULL) {
        stp_store_close(p->store);
    }
    stp_context_destroy(p->context);
}

const uint8_t* made_picture_pixel(const made_picture* p, int x, int y)
{
    return p->pixels + 4 * (y * PICTURE_SIDE + x);
}
