// SPDX-License-Identifier: MIT
#include "program/drawing/drawing.h"

#include "lod/method.h"
#include "program/options/cloud_style.h"
#include "program/options/tool.h"
#include "program/present/picture_file.h"

bool drawing_begin(drawing* d, const draw_options* options)
{
    d->context = tool_context_create((uint32_t)options->threads, options->memory, NULL);
    return d->context != NULL;
}

/// Chooses a method whose splats have what the colours need, if none was requested and the default
/// lacks it.
static void choose_method(drawing* d, draw_options* o, const char* path)
{
    const stp_store_directory* directory = stp_store_get_directory(d->store);
    uint32_t usual = stp_store_find_method(directory, draw_options_quality(o).method);
    if (o->has_method || o->settings.quality.reference || !point_colors_need_points(&o->colors)) {
        return;
    }
    uint32_t found = point_colors_find_method(&o->colors, d->store, usual);
    if (found == usual) {
        return;
    }
    const char* what = o->colors.classes != NULL ? "class" : point_color_name(o->colors.color);
    const stp_method* method =
        found != STP_STORE_NONE ? stp_method_by_id(directory->methods[found].id) : NULL;
    if (method != NULL) {
        o->has_method = true;
        o->method = (int)(method - stp_methods);
        stp_warn(d->context, "%s: drawn by %s: splats by %s have no %s", path, method->name,
                 directory->methods[usual].name, what);
    } else if (point_colors_has_originals(&o->colors, d->store) &&
               !stp_store_is_partial(d->store) && o->settings.quality.splat_count == 0 &&
               !(o->budget_ms > 0.0)) {
        o->settings.quality.reference = true;
        o->point_size = o->point_size != NULL ? o->point_size : CLOUD_ORIGINAL_SIZE;
        stp_warn(d->context, "%s: original points are drawn: splats have no %s", path, what);
    }
}

stp_result drawing_open(drawing* d, draw_options* options, const char* path)
{
    stp_result result = tool_open_partial_scene(d->context, path, draw_options_use(options),
                                                &options->partial_file, &d->store);
    d->show = (scene_show){.context = d->context, .store = d->store};
    if (result != STP_OK) {
        return result;
    }
    choose_method(d, options, path);
    stp_quality quality = draw_options_quality(options);
    uint32_t method = stp_store_find_method(stp_store_get_directory(d->store), quality.method);
    if (options->settings.style.filter != STP_FILTER_NONE &&
        options->colors.color == POINT_COLOR_AUTO) {
        options->colors.color = POINT_COLOR_RGB; // pixels are not coloured where splats blend
    }
    result = point_colors_choose(d->store, method, &options->colors.color);
    if (result != STP_OK) {
        return result;
    }
    result = point_colors_find(&options->colors, d->context, d->store, path, method,
                               options->settings.quality.reference, &d->coloring);
    return result == STP_OK ? stp_store_set_coloring(d->store, &d->coloring.points) : result;
}

static stp_result read_splat_texture(drawing* d, const char* path)
{
    stp_image image;
    stp_result result = tool_read_picture(d->context, path, &image);
    if (result == STP_OK) {
        d->splat_texture = stp_splat_texture_of_image(&image);
        stp_free(d->context, image.pixels);
    }
    return result;
}

stp_result drawing_make(drawing* d, const draw_options* options)
{
    stp_draw_style style = draw_options_style(options);
    stp_result result = STP_OK;
    style.coloring = d->coloring.pixels;
    style.elevation[0] = d->coloring.elevation[0];
    style.elevation[1] = d->coloring.elevation[1];
    style.eye_dome = style.eye_dome >= 0.0f ? style.eye_dome : cloud_style_eye_dome(d->store);
    if (options->point_size != NULL) {
        cloud_point_size size;
        (void)cloud_style_read_size(options->point_size, &size);
        cloud_style_set_size(&size, d->store, &style);
    }
    if (options->splat_texture != NULL) {
        result = read_splat_texture(d, options->splat_texture);
        style.splat_texture = &d->splat_texture;
    }
    if (result == STP_OK) {
        result = frame_maker_create_on(d->context, d->store, &style,
                                       (frame_backend)options->backend, &d->maker);
    }
    if (result == STP_OK) {
        frame_maker_use_splats(&d->maker, options->gl_splats);
    }
    if (result == STP_OK && options->memory > 0 && !options->settings.quality.reference) {
        result = frame_maker_stream(&d->maker);
    }
    return result;
}

json_t* drawing_describe(const drawing* d, const stp_view* view)
{
    json_t* object = frame_maker_describe(&d->maker, view->width, view->height);
    json_t* file = json_pack("{s:b, s:I, s:I}", "truncated", stp_store_is_partial(d->store),
                             "file_bytes", (json_int_t)stp_store_file_bytes(d->store),
                             "whole_bytes", (json_int_t)stp_store_whole_bytes(d->store));
    if (file == NULL || json_object_update(object, file) != 0) {
        json_decref(object);
        object = NULL;
    }
    json_decref(file);
    return object;
}

void drawing_end(drawing* d)
{
    frame_maker_destroy(&d->maker);
    scene_show_destroy(&d->show);
    if (d->store != NULL) {
        stp_store_close(d->store);
    }
    stp_context_destroy(d->context);
    *d = (drawing){0};
}
