// SPDX-License-Identifier: MIT
#include "lab/measure/splat_pictures.h"

#include "lab/measure/measured_views.h"
#include "program/drawing/frame.h"
#include "program/files/point_file.h"
#include "program/options/tool.h"
#include "select/visibility.h"

enum { SAMPLES = 4 };

const char* const splat_picture_views[SPLAT_PICTURES] = {"front", "back",   "left", "right",
                                                         "top",   "bottom", "iso"};

/// The two scenes, the splats first.
typedef struct pair {
    const splat_scene* scenes[2];
    const uint32_t* size;
    frame_maker makers[2];
    stp_image images[2];
} pair;

static stp_vec3d change_axes(char from, char to, stp_vec3d v)
{
    return tool_scene_axes(to, tool_own_axes(from, v));
}

static stp_view find_view(const pair* p, int index, const char* name)
{
    const stp_store_directory* original = stp_store_get_directory(p->scenes[1]->store);
    const stp_store_directory* own = stp_store_get_directory(p->scenes[index]->store);
    stp_view view = {.width = p->size[0], .height = p->size[1]};
    stp_boxd box = stp_visible_bounds(p->scenes[1]->store, NULL);
    (void)measured_standard_view(name, &box, &view);
    view.eye = change_axes(original->up, own->up, view.eye);
    view.target = change_axes(original->up, own->up, view.target);
    view.up = change_axes(original->up, own->up, view.up);
    return view;
}

static stp_result draw(pair* p, int index, const char* name)
{
    frame_maker* maker = &p->makers[index];
    const stp_quality* quality = &p->scenes[index]->quality;
    stp_view view = find_view(p, index, name);
    stp_result result = STP_OK;
    for (int i = 0; i < SAMPLES && result == STP_OK; ++i) {
        result = tool_is_interrupted()
                     ? STP_ERROR_CANCELLED
                     : frame_accumulate(maker, &view, quality, SAMPLES, &p->images[index]);
    }
    return result;
}

static stp_result begin(stp_context* context, pair* p)
{
    static const stp_draw_style style = {.transparency = STP_TRANSPARENCY_LAYERS};
    stp_result result = STP_OK;
    for (int i = 0; i < 2 && result == STP_OK; ++i) {
        result = frame_maker_create(context, p->scenes[i]->store, &style, &p->makers[i]);
        bool made =
            result == STP_OK && frame_image_create(context, p->size[0], p->size[1], &p->images[i]);
        result = result == STP_OK && !made ? STP_ERROR_OUT_OF_MEMORY : result;
    }
    return result;
}

stp_result splat_pictures_compare(stp_context* context, const splat_scene* splats,
                                  const splat_scene* original, const uint32_t size[2],
                                  splat_pictures* found)
{
    pair p = {.scenes = {splats, original}, .size = size};
    *found = (splat_pictures){0};
    stp_result result = begin(context, &p);
    for (int v = 0; v < SPLAT_PICTURES && result == STP_OK; ++v) {
        stp_image_quality* quality = &found->views[v];
        result = draw(&p, 0, splat_picture_views[v]);
        result = result == STP_OK ? draw(&p, 1, splat_picture_views[v]) : result;
        result = result == STP_OK
                     ? stp_image_compare(context, &p.images[0], &p.images[1], NULL, NULL, quality)
                     : result;
        found->ssim += quality->ssim;
        found->ssim_covered += quality->ssim_covered;
    }
    found->ssim /= SPLAT_PICTURES;
    found->ssim_covered /= SPLAT_PICTURES;
    for (int i = 0; i < 2; ++i) {
        stp_free(context, p.images[i].pixels);
        frame_maker_destroy(&p.makers[i]);
    }
    return result;
}
