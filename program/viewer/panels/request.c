// SPDX-License-Identifier: MIT
// Converts settings and camera to a request for the painter.
#include "program/viewer/panels/panels.h"
#include "select/sections.h"

static stp_fovea make_fovea(const viewer_settings* s)
{
    stp_fovea fovea = {0};
    if (s->fovea) { // as in the paper: from a quarter of the half diagonal outwards
        fovea.count = 2;
        fovea.zones[0] = (stp_fovea_zone){0.25f, 1.0f};
        fovea.zones[1] = (stp_fovea_zone){1.0f, s->fovea_factor};
    }
    return fovea;
}

bool viewer_uses_gl(const viewer* v)
{
    int backend = v->settings.backend;
    return v->window.has_worker &&
           (backend == BACKEND_OPENGL || (backend == BACKEND_AUTO && v->window.is_hardware));
}

paint_request request_make(viewer* v)
{
    const viewer_settings* s = &v->settings;
    bool original = s->drawing.quality.reference;
    uint32_t splats = splats_count(v);
    paint_request request = {
        .scene = v->scene->serial,
        .style = s->drawing.style,
        .quality = s->drawing.quality,
        .budget_ms = s->adapts && !original && splats == 0 ? (double)s->budget_ms : 0.0,
        .samples = (uint32_t)s->samples,
    };
    request.style.eye_dome = cloud_page_eye_dome(v);
    request.quality.splat_count = splats;
    request.quality.cues_off = v->options.cues_off;
    request.quality.fovea = original || splats > 0 ? (stp_fovea){0} : make_fovea(s);
    cloud_page_give(v, &request);
    stp_navigator_write_view(&v->camera, &request.view);
    request.view.sections = section_make(v);
    if (v->explorer != NULL) {
        stp_sections_drop_idle(&request.view.sections, &v->scene->bounds, v->explorer->rounding);
    }
    request.gl = viewer_uses_gl(v);
    point_style_give(v, &request);
    return request;
}
