// SPDX-License-Identifier: MIT
#include "drawing.h"

#include "tool.h"

bool drawing_begin(drawing* d, const draw_options* options)
{
    d->context = tool_context_create((uint32_t)options->threads, options->memory, NULL);
    return d->context != NULL;
}

stp_result drawing_open(drawing* d, const draw_options* options, const char* path)
{
    stp_result result = tool_open_scene_for(d->context, path, draw_options_use(options), &d->store);
    d->show = (scene_show){.context = d->context, .store = d->store};
    return result;
}

stp_result drawing_make(drawing* d, const draw_options* options)
{
    stp_draw_style style = draw_options_style(options);
    stp_result result = frame_maker_create_on(d->context, d->store, &style,
                                              (frame_backend)options->backend, &d->maker);
    if (result == STP_OK) {
        result = frame_maker_use_splats(&d->maker, options->gl_splats);
    }
    if (result == STP_OK && options->memory > 0 && !options->reference) {
        result = frame_maker_stream(&d->maker);
    }
    return result;
}

json_t* drawing_describe(const drawing* d, const stp_view* view)
{
    return frame_maker_describe(&d->maker, view->width, view->height);
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
