// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_viewpoints -max_total_time=60 -max_len=4096 build/corpus/fuzz_viewpoints
//
// Arbitrary bytes as a viewpoints file: a failure is logged once; accepted viewpoints give finite
// views and can be found and copied.
#include "fuzz.h"

#include "base/math/math.h"
#include "program/present/viewpoints.h"
#include "select/sections.h"

static void check_viewpoints(stp_context* context, const stp_viewpoints* viewpoints)
{
    stp_viewpoints copies = {0};
    for (size_t i = 0; i < viewpoints->count; ++i) {
        const stp_viewpoint* viewpoint = &viewpoints->views[i];
        stp_view view = {.fov_degrees = 60};
        require(stp_viewpoints_find(viewpoints, viewpoint->name) == viewpoint);
        stp_viewpoint_get_view(viewpoint, &view);
        require(isfinite(stp_dotd(view.eye, view.target)) && view.fov_degrees > 0.0);
        require(stp_sections_are_valid(&view.sections));
        require(stp_viewpoints_put(context, &copies, viewpoint) == STP_OK);
    }
    require(copies.count == viewpoints->count);
    stp_viewpoints_destroy(context, &copies);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    int errors = 0;
    stp_context* context = fuzz_context_create(&errors);
    if (context == NULL) {
        return 0;
    }
    stp_viewpoints viewpoints;
    stp_result result = stp_viewpoints_parse(context, "fuzz.json", data, size, &viewpoints);
    require(errors == (result != STP_OK));
    if (result == STP_OK) {
        check_viewpoints(context, &viewpoints);
    }
    stp_viewpoints_destroy(context, &viewpoints);
    stp_context_destroy(context);
    return 0;
}
