// SPDX-License-Identifier: MIT
#include "support_gl.h"

#include "base/math/rng.h"

#include <stdlib.h>

static void add_sheet(made_picture* p)
{
    static const uint8_t color[3] = {200, 40, 40};
    made_picture_add(p, 0.2, (stp_vec3d){0, 0, 0}, color);
}

static void add_sheets(made_picture* p)
{
    static const uint8_t colors[3][3] = {{40, 200, 60}, {60, 60, 220}, {220, 200, 40}};
    add_sheet(p);
    made_picture_add(p, 1.1, (stp_vec3d){0.5, 0.3, 0.2}, colors[0]);
    made_picture_add(p, -0.9, (stp_vec3d){-0.6, -0.2, 0.4}, colors[1]);
    made_picture_add(p, 2.6, (stp_vec3d){0.1, 0.5, -1.5}, colors[2]);
    made_picture_add(p, 0.4, (stp_vec3d){-1.4, 1.0, -1.0}, NULL);
    stp_splats* holes = &p->scene.sets[1];
    for (uint32_t i = 0; i < holes->count; ++i) {
        holes->coverages[i] = (uint8_t)(60 + stp_rng_hash(9, i) % 160);
    }
}

stp_result made_gl_renew(made_gl* m, const stp_draw_gl_desc* settings)
{
    stp_draw_gl_desc desc = settings != NULL ? *settings : (stp_draw_gl_desc){0};
    desc.get_proc_address = stp_headless_get_proc_address;
    desc.user = &m->headless;
    desc.debug = true;
    if (m->renderer != NULL) {
        stp_renderer_destroy(m->renderer);
    }
    return stp_draw_gl_create(m->picture.context, m->picture.store, &desc, &m->renderer);
}

bool made_gl_begin_with(made_gl* m, void (*add)(made_picture* p), const stp_draw_gl_desc* settings,
                        test_heap* heap, bool* failed)
{
    const stp_headless_desc wanted = {.debug = true};
    *failed = false;
    *m = (made_gl){.renderer = NULL};
    if (stp_headless_create(&wanted, &m->headless) != NULL) {
        return false;
    }
    *failed = true;
    if (!made_picture_begin(&m->picture, heap, 2)) {
        return false;
    }
    m->picture.quality.splat_size = 1;
    (add != NULL ? add : add_sheets)(&m->picture);
    if (made_picture_open(&m->picture) != STP_OK || made_gl_renew(m, settings) != STP_OK) {
        return false;
    }
    *failed = false;
    return true;
}

bool made_gl_begin(made_gl* m, bool one, bool* failed)
{
    return made_gl_begin_with(m, one ? add_sheet : add_sheets, NULL, NULL, failed);
}

bool made_gl_begin_or_skip(test_state* test, made_gl* m, void (*add)(made_picture* p),
                           const stp_draw_gl_desc* settings, test_heap* heap)
{
    bool failed;
    if (made_gl_begin_with(m, add, settings, heap, &failed)) {
        return true;
    }
    made_gl_end(m);
    CHECK(!failed);
    test->skipped = "there is no OpenGL";
    return false;
}

stp_result made_gl_draw(made_gl* m)
{
    made_picture* p = &m->picture;
    stp_image image = {PICTURE_SIDE, PICTURE_SIDE, m->pixels};
    return stp_renderer_draw_selected(m->renderer, &p->view, &p->quality, &p->style, &p->list,
                                      &image, &p->stats);
}

void made_gl_end(made_gl* m)
{
    if (m->renderer != NULL) {
        stp_renderer_destroy(m->renderer);
    }
    if (m->picture.context != NULL) {
        made_picture_end(&m->picture);
    }
    if (m->headless.context != NULL) {
        stp_headless_destroy(&m->headless);
    }
}

int made_count_different(const uint8_t* a, const uint8_t* b, int levels)
{
    int count = 0;
    for (int i = 0; i < PICTURE_SIDE * PICTURE_SIDE; ++i) {
        bool differs = false;
        for (int k = 0; k < 4; ++k) {
            differs = differs || abs(a[4 * i + k] - b[4 * i + k]) > levels;
        }
        count += differs ? 1 : 0;
    }
    return count;
}
